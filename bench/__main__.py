"""make bench: how fast the simulations and the array functions are, measured so that anyone can do it again.

Every engine runs once a round and the rounds are interleaved; a figure is the median of the rounds, a ratio the median
of the ratios within a round.  What is measured is CPU time of one core; of the workers it is work a second of the wall
clock.  `python -m bench [loops] [laws] [learning] [rows] [workers] [peers] [campaign]` measures some of it and keeps
the rest of the last result.
"""

from __future__ import annotations

import importlib.util
import json
import os
import statistics
import sys
import time
from pathlib import Path

import gough as gk
from gough.kernel.lanes import native_width
from gough.log.build import plain
from gough.simulate.provenance import processor

from . import campaign, learning, loops, tables
from .rows import Rows
from .workers import Workers

ROUNDS = 5
DOCS = Path(__file__).parent.parent / "docs"
PARTS = ("loops", "laws", "learning", "rows", "workers", "peers", "campaign")


def medians(rounds: list[dict[str, float]]) -> dict[str, float]:
    return {name: statistics.median(each[name] for each in rounds) for name in rounds[0]}


def measure_loops() -> dict:
    """Per friction: simulated seconds a CPU second, and the ratios."""
    return {"width": native_width(), "cases": {name: measured(machine) for name, machine in loops.machines().items()}}


def measure_laws() -> dict:
    """The same per law, with the friction of the sheet, and the 3-PRS of Chen and Tsai 2008."""
    sheet = gk.load_machine("nist-octahedral")
    cases = {name: measured(sheet, law) for name, law in loops.LAWS.items()}
    return {"width": native_width(), "cases": {**cases, loops.CHEN: measured(*loops.published())}}


def measure_learning() -> dict:
    """Ten minutes of learning: medians of three runs, the kernel compiled before."""
    learning.measure()
    return medians([learning.measure() for _ in range(3)])


def measured(machine, law=loops.LAW, program=loops.PROGRAM) -> dict[str, float]:
    """One closed loop: simulated seconds a CPU second, and the ratios."""
    loop = loops.Loop(machine, law, program)
    begun = time.perf_counter()
    one = loop.compiled(1, cache=False)
    compiled = time.perf_counter() - begun
    lanes, slow = loop.compiled("auto", cache=False), loop.compiled(1, native=False)
    plants = loops.plants_of(machine)
    loops.single(machine, law, program), loops.batch(machine, plants[:1], law, program)  # fills the caches
    rounds = []
    for _ in range(ROUNDS):
        found = {
            "interpreter": loop.rate(slow, 1, 100),
            "one lane": loop.rate(one, 1),
            "lanes": loop.rate(lanes, lanes.lanes),
            "simulate": loops.single(machine, law, program),
            "batch": loops.batch(machine, plants, law, program),
        }
        found["one lane / interpreter"] = found["one lane"] / found["interpreter"]
        found["lanes / one lane"] = found["lanes"] / found["one lane"]
        found["batch / simulate"] = found["batch"] / found["simulate"]
        rounds.append(found)
    return medians(rounds) | {"operations": one.operations, "compile_s": compiled}


def measure_rows() -> dict:
    rows = Rows()
    return medians([rows.times() for _ in range(ROUNDS)])


def measure_workers() -> dict:
    with Workers() as workers:
        return medians([workers.round() for _ in range(ROUNDS)])


def measure_peers() -> dict:
    """What bench/peers.py measures, where its engines are installed."""
    if importlib.util.find_spec("bench.peers") is None:
        return {"missing": "there is no bench/peers.py"}
    try:
        from . import peers

        found = peers.rows()
        return {"rows": plain(found), "lines": peers.lines(found)}
    except ImportError as error:
        return {"missing": f"{error}; pip install -e '.[dev]'"}


def main(parts: list[str]) -> None:
    wrong = [part for part in parts if part not in PARTS]
    if wrong:
        sys.exit(f"bench: no part {wrong[0]}; there is {', '.join(PARTS)}")
    path = DOCS / "performance.json"
    old = json.loads(path.read_text()) if parts and path.exists() else {}
    result = {"processor": processor(), "threads": os.cpu_count(), "version": gk.__version__, "rounds": ROUNDS}
    if any(old.get(key, value) != value for key, value in result.items()):
        old = {}  # figures of two machines do not stand in one table
    measures = {
        "loops": measure_loops,
        "laws": measure_laws,
        "learning": measure_learning,
        "rows": measure_rows,
        "workers": measure_workers,
        "peers": measure_peers,
        "campaign": campaign.growth,
    }
    for part in PARTS:
        if not parts or part in parts:
            result[part] = measures[part]()
        elif part in old:
            result[part] = old[part]
    text = tables.page(result)
    print(text)
    (DOCS / "performance.md").write_text(text)
    path.write_text(json.dumps(result, indent=1, allow_nan=False) + "\n")


if __name__ == "__main__":
    main(sys.argv[1:])
