"""What a sweep costs a run, from ten runs on: CPU of all its processes, wall, memory, and what is not simulation.

python -m bench.sweeps [most runs]        writes docs/performance-sweeps.md
"""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from gough.simulate.provenance import processor

SIZES = (10, 100, 1000, 10_000, 100_000)
WORKERS = 2
PAGE = Path(__file__).parents[1] / "docs" / "performance-sweeps.md"
HEADS = (
    "runs", "wall [s]", "CPU, all processes [s]", "CPU a run [ms]", "all but simulation, wall a run [ms]",
    "the same command again [s]", "peak memory, parent + workers [MB]",
)  # fmt: skip
TEXT = """\
# What a sweep costs

`python -m bench.sweeps` on {processor}, {cores} of them for this process, {workers} workers; every size in
processes of its own, kernels in the cache. One run is a circle of 0.94 s of a hexapod with friction under computed
torque, another friction and payload each.

| {heads} |
|{line}
{rows}

"All but simulation" is the same sweep with workers that answer at once: design, ids, a file a run on the disk, the
index. "The same command again" finds every run in the store. Both include the start of Python.
"""
EXPERIMENT = """\
schema = "gough-experiment-1"
[machine]
use = "nist-octahedral"
[program]
kind = "circle"
radius = "10 mm"
feed = "4 m/min"
settle = "0 s"
[[controller]]
kind = "computed_torque"
bandwidth = "10 Hz"
[sweep]
vary = { "plant.friction.coulomb" = "uniform(0.6, 1.1) x", "plant.payload" = "uniform(1, 40) kg" }
"""


def alone(what: str, folder: Path, runs: int) -> dict[str, float]:
    """Wall and CPU seconds and peak memory of one part, in a process of its own."""
    done = subprocess.run(
        [sys.executable, "-m", "bench.sweeps", what, str(folder), str(runs)], capture_output=True, text=True, check=True
    )
    names = ("wall", "cpu", "self", "mb", "worker_mb")
    return dict(zip(names, map(float, done.stdout.split()), strict=True))


def part(what: str, folder: Path, runs: int) -> None:
    """A whole sweep, or one whose workers answer at once ("rest"): what is left is design, ids, store and index."""
    from gough.experiment import load_experiment
    from gough.sweep import run, table
    from gough.sweep.design import METRICS
    from gough.sweep.work import Done

    experiment = load_experiment(folder / "part.toml")
    if what == "rest":

        class Nobody:
            def __init__(self, workers: int):
                pass

            def __enter__(self):
                return self

            def __exit__(self, *_error):
                pass

            def each(self, tasks, most):
                metrics = dict.fromkeys(METRICS, 0.1234567890123)
                for number, task in enumerate(tasks):
                    told = {"status": "done", "reason": "", "metrics": metrics, "simulated_time": 1.0}
                    yield number, Done([{**job._asdict(), **told} for job in task.jobs], {}, [])

        run.Pool = Nobody
    begun = time.perf_counter()
    swept = run.sweep(experiment, folder / f"{what}-{runs}", runs=runs, workers=WORKERS)
    table.write_index(swept, table.lines_of(swept), folder / f"{what}-{runs}" / "index.parquet")
    wall = time.perf_counter() - begun
    me, others = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    own = me.ru_utime + me.ru_stime
    cpu = own + others.ru_utime + others.ru_stime
    print(wall, cpu, own, me.ru_maxrss / 1e3, others.ru_maxrss / 1e3)


def main(most: int) -> None:
    rows = []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "part.toml").write_text(EXPERIMENT)
        for runs in (size for size in SIZES if size <= most):
            whole, again = alone("whole", folder, runs), alone("whole", folder, runs)
            rest = alone("rest", folder, runs)
            rows.append(
                f"| {runs} | {whole['wall']:.1f} | {whole['cpu']:.1f} | {1e3 * whole['cpu'] / runs:.1f} "
                f"| {1e3 * rest['wall'] / runs:.2f} | {again['wall']:.1f} "
                f"| {whole['mb']:.0f} + {WORKERS} x {whole['worker_mb']:.0f} |"
            )
            print(rows[-1], flush=True)
    PAGE.write_text(
        TEXT.format(
            processor=processor(),
            cores=len(os.sched_getaffinity(0)),
            workers=WORKERS,
            rows="\n".join(rows),
            heads=" | ".join(HEADS),
            line="---|" * len(HEADS),
        )  # fmt: skip
    )


if __name__ == "__main__":
    if len(sys.argv) == 4:
        part(sys.argv[1], Path(sys.argv[2]), int(sys.argv[3]))
    else:
        main(int(sys.argv[1]) if len(sys.argv) > 1 else SIZES[-1])
