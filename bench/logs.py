"""What the observer costs a sample, and what `gough monitor` takes for ten million rows.

python -m bench.logs [rows]        writes docs/performance-logs.md
"""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

import gough as gk
from gough.observe.recorded import Recorder
from gough.simulate.provenance import processor

ROWS = 10_000_000
PAGE = Path(__file__).parents[1] / "docs" / "performance-logs.md"
FORMS = ("momentum", "static")


def step(name: str, form: str, count: int = 200_000, rounds: int = 5) -> float:
    """us of CPU a sample of the observer on recorded rows; the median of rounds."""
    machine = gk.load_machine(name)
    recorder = Recorder(gk.DisturbanceObserver(form=form).on(machine, 1e-3), machine.home)
    q = np.tile(machine.inverse_kinematics(machine.home), (count, 1))
    u = np.tile(machine.inverse_dynamics(machine.home, *np.zeros((2, len(machine.task)))), (count, 1))
    recorder.rows(q[:100], u[:100])
    times = []
    for _ in range(rounds):
        before = time.process_time()
        recorder.rows(q, u)
        times.append((time.process_time() - before) / count * 1e6)
    return float(np.median(times))


def parquet(path: Path, rows: int) -> None:
    """A log of the PM-600 on a circle, there and back until it has so many rows."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    machine = gk.load_machine("okuma-pm600")
    log = gk.simulate(machine, gk.PID(bandwidth=10.0), gk.Circle(radius=0.05, feed=0.05))
    q, u = log["q_m"], log["u"]
    names = ["t", *(f"q_m.{i}" for i in range(1, 7)), *(f"u.{i}" for i in range(1, 7))]
    schema = pa.schema([(name, pa.float64()) for name in names])
    done, way = 0, 1
    with pq.ParquetWriter(path, schema) as writer:
        while done < rows:
            n = min(len(q), rows - done)
            t = (done + np.arange(n)) * 1e-3
            columns = [t, *q[::way][:n].T.copy(), *u[::way][:n].T.copy()]
            writer.write_table(pa.table(columns, schema=schema))
            done, way = done + n, -way


def monitored(rows: int) -> tuple[float, float, float]:
    """Seconds on the clock, CPU seconds and MB of `gough monitor` on so many rows of Parquet."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "log.parquet"
        parquet(path, rows)
        command = [sys.executable, "-m", "gough", "monitor", str(path), "-m", "okuma-pm600", "--quiet"]
        before, clock = resource.getrusage(resource.RUSAGE_CHILDREN), time.monotonic()
        subprocess.run(command, check=True, cwd=folder, stdout=subprocess.DEVNULL)
        after, clock = resource.getrusage(resource.RUSAGE_CHILDREN), time.monotonic() - clock
        cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
        return clock, cpu, after.ru_maxrss / 1024


def main() -> None:
    """Measure, print and write the page."""
    rows = int(sys.argv[1]) if len(sys.argv) > 1 else ROWS
    lines = [
        "# Recorded logs", "",
        f"Written by `python -m bench.logs`, gough {gk.__version__}.  {processor()}, load {os.getloadavg()[0]:.0f}.",
        "",
        "## The disturbance observer", "",
        "CPU microseconds a sample on recorded rows, one core; the median of 5.  The aim is 3.", "",
        "| machine | momentum | static |", "| --- | --- | --- |",
    ]  # fmt: skip
    for name in sorted(gk.library()):
        lines.append(f"| {name} | {' | '.join(f'{step(name, form):.2f}' for form in FORMS)} |")
    clock, cpu, memory = monitored(rows)
    lines += [
        "", "## gough monitor", "",
        f"{rows:,} rows of Parquet, 13 columns of a hexapod, with figure and files: {clock:.0f} s on the clock, "
        f"{cpu:.0f} s of CPU, {memory:.0f} MB at most.  The aims are 60 s and 1000 MB.",
    ]  # fmt: skip
    PAGE.write_text("\n".join(lines) + "\n")
    print("\n".join(lines))


if __name__ == "__main__":
    main()
