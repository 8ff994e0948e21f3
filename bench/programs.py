"""python -m bench.programs: how long NC programs of 100 000 lines take to be read and planned, and in how much memory.

Each case runs in a process of its own, on one core; the figures are the medians of the rounds, the memory is the
largest.  The programs are made here: a raster over a curved surface, the flank of a turning surface with A and B, and
lines from one random place to the next, where no speed is ever held.
"""

from __future__ import annotations

import json
import math
import random
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

from gough.simulate.provenance import processor

LINES, ROUNDS = 100_000, 3
PAGE = Path(__file__).parents[1] / "docs" / "performance-programs.md"
OPTIONS = {
    "trapezoid": {},
    "jerk limited": {"profile": "jerk_limited"},
    "spline, jerk limited": {"profile": "jerk_limited", "spline": True},
    "jerk and joints limited": {"profile": "jerk_limited", "joint_limits": True},
}
WORK = """
import json, sys, time
import gough as gk

machine = gk.load_machine("nist-octahedral")
begin = time.perf_counter()
program = gk.load_program(sys.argv[1], **json.loads(sys.argv[2]))
read = time.perf_counter()
motion = program.plan(machine)
planned = time.perf_counter()
memory = next(int(line.split()[1]) for line in open("/proc/self/status") if line.startswith("VmHWM")) / 1024
print(json.dumps([read - begin, planned - read, memory, len(motion.course.path)]))
"""


def surface():
    """A raster of 250 rows over 160 mm, 0.4 mm a line."""
    for k in range(LINES):
        row, i = divmod(k, 400)
        x = -80 + 0.4 * (i if row % 2 == 0 else 400 - i)
        y = -80 + 160 * row / (LINES / 400)
        yield f"N{k} X{x:.4f} Y{y:.4f} Z{5 * math.sin(x / 20) * math.cos(y / 25):.4f}"


def flank():
    """Two hundred turns of a helix with a tool that leans outward, 0.75 mm a line."""
    for k in range(LINES):
        t = 400 * math.pi * k / LINES
        place = f"X{60 * math.cos(t):.4f} Y{60 * math.sin(t):.4f} Z{-30 * k / LINES:.4f}"
        yield f"N{k} {place} A{5 * math.sin(t):.4f} B{5 * math.cos(t):.4f}"


def corners():
    """Lines of 50 mm or so from one random place to the next."""
    rng = random.Random(0)
    for k in range(LINES):
        yield f"N{k} X{rng.uniform(-50, 50):.3f} Y{rng.uniform(-50, 50):.3f} Z{rng.uniform(-5, 5):.3f}"


def main() -> None:
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for make in (surface, flank, corners):
            file = Path(folder) / f"{make.__name__}.ngc"
            file.write_text("\n".join(["G21 G90 G94 G64 P0.01", "G1 F3000", *make(), "M2\n"]))
            for name, options in OPTIONS.items():
                runs = [_run(file, options) for _ in range(ROUNDS)]
                read, plan = (statistics.median(run[k] for run in runs) for k in (0, 1))
                rows.append((make.__name__, name, read, plan, max(run[2] for run in runs), runs[0][3]))
                print(rows[-1], flush=True)
    PAGE.write_text(_page(rows))


def _run(file, options):
    command = [sys.executable, "-c", WORK, file, json.dumps(options)]
    return json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)


def _page(rows):
    lines = [
        "# Reading and planning programs",
        "",
        f"NC programs of {LINES // 1000} 000 lines with G64 P0.01 on nist-octahedral; median of {ROUNDS}",
        "runs, one process each.",
        f"{processor()}.  `python -m bench.programs` writes this page.",
        "",
        "| program | feed | read, s | plan, s | memory, MB | blocks driven |",
        "|---|---|---|---|---|---|",
        *(f"| {a} | {b} | {read:.2f} | {plan:.2f} | {mb:.0f} | {n} |" for a, b, read, plan, mb, n in rows),
        "",
        "surface: a raster, 0.4 mm a line; flank: a helix with a leaning tool, five axes, 0.75 mm a line; corners:",
        "lines of 50 mm between random places, a valley of the speed at every end.",
        "",
    ]
    return "\n".join(lines)


if __name__ == "__main__":
    main()
