"""Maps of a million poses and envelopes: `python -m bench.maps` writes docs/performance-maps.md.

Every map once a round, rounds interleaved, medians; CPU seconds of one core, the row functions compiled before.  Memory
is what the process has had at most, with all that Python loads.
"""

from __future__ import annotations

import os
import resource
import statistics
import time
from pathlib import Path

import numpy as np

import gough as gk
from gough.machine.workspace import random_poses
from gough.plan.maps import machine_map
from gough.simulate.provenance import processor

from .tables import table

ROUNDS = 3
MACHINES = ("nist-octahedral", "eth-hexaglide", "ccu-3prs", "ifma-hsm")
WHAT = ("workspace", "dexterity", "feed", "acceleration", "force", "gravity")
OVER = {6: (("x", "y", "z", "a", "b"), (20, 20, 10, 16, 16)), 3: (("x", "y", "z"), (100, 100, 100))}  # 1.024e6, 1e6
POSES = 20  # of envelopes


def measure() -> tuple[dict, dict]:
    """CPU seconds of a map and milliseconds of an envelope, by machine."""
    maps: dict = {name: {what: [] for what in WHAT} for name in MACHINES}
    envelopes: dict = {name: [] for name in MACHINES}
    for name in MACHINES:
        machine = gk.load_machine(name)
        over, points = OVER[len(machine.task)]
        machine_map(machine, WHAT, over=over, points=3), gk.envelope(machine)  # compiled
        for _ in range(ROUNDS):
            for what in WHAT:
                begun = time.process_time()
                machine_map(machine, what, over=over, points=points)
                maps[name][what].append(time.process_time() - begun)
        for x in random_poses(machine, POSES, np.random.default_rng(0)):
            begun = time.process_time()
            gk.envelope(machine, x)
            envelopes[name].append(1e3 * (time.process_time() - begun))
    return maps, envelopes


def main() -> None:
    maps, envelopes = measure()
    most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    load = f"{processor()}, load {os.getloadavg()[0]:.0f}"
    rows = [[name, *(f"{statistics.median(maps[name][what]):.2f}" for what in WHAT)] for name in MACHINES]
    spans = [[name, f"{statistics.median(found):.0f}", f"{max(found):.0f}"] for name, found in envelopes.items()]
    lines = [
        "# Maps and envelopes", "", f"Written by `python -m bench.maps`, gough {gk.__version__}.  {load}.", "",
        "## A million poses", "",
        "CPU seconds of one core; hexapod and hexaglide 1 024 000 poses over x, y, z, a, b, the others 1 000 000 over",
        f"x, y, z.  With the dataset; without writing it.  The process had {most:.0f} MB at most.", "",
        *table(["machine", *WHAT], rows), "", "## gk.envelope", "",
        f"CPU milliseconds at {POSES} random poses of the workspace.  The aim is below 100.", "",
        *table(["machine", "median", "most"], spans),
    ]  # fmt: skip
    text = "\n".join(lines) + "\n"
    print(text)
    (Path(__file__).parent.parent / "docs" / "performance-maps.md").write_text(text)


if __name__ == "__main__":
    main()
