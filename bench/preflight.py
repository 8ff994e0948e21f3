"""python -m bench.preflight: how long the preflight of NC programs of 100 000 lines takes, from file to verdict, and
how long it takes to find feeds that the joints can follow where they cannot follow those of the program.

Each case runs in a process of its own, on one core; figures are CPU time.  The programs are those of bench.programs.
Writes docs/performance-preflight.md.
"""

from __future__ import annotations

import json
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

from gough.simulate.provenance import processor

from .programs import LINES, corners, flank, surface

ROUNDS = 1
PAGE = Path(__file__).parents[1] / "docs" / "performance-preflight.md"
WORK = """
import json, sys, time
import gough as gk
from gough.plan import fix_feed, preflight

begin = time.process_time()
machine = gk.load_machine("nist-octahedral")
program = gk.load_program(sys.argv[1])
read = time.process_time()
program.plan(machine)
planned = time.process_time()
found = preflight(machine, program)
judged = time.process_time()
memory = next(int(line.split()[1]) for line in open("/proc/self/status") if line.startswith("VmHWM")) / 1024
fixed = None
if not found.passed:
    assert fix_feed(machine, program).after.passed
    fixed = time.process_time() - judged
told = [read - begin, planned - read, judged - planned, judged - begin, memory, found.found.rows, found.exceeded, fixed]
print(json.dumps(told))
"""


def main() -> None:
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for make, feed in ((surface, 3000), (flank, 3000), (corners, 3000), (surface, 40000), (corners, 40000)):
            file = Path(folder) / f"{make.__name__}-{feed}.ngc"
            file.write_text("\n".join(["G21 G90 G94 G64 P0.01", f"G1 F{feed}", *make(), "M2\n"]))
            runs = [_run(file) for _ in range(ROUNDS)]
            middle = [statistics.median(run[k] for run in runs) for k in range(4)]
            fixed = None if runs[0][7] is None else statistics.median(run[7] for run in runs)
            rows.append((f"{make.__name__}, F{feed}", *middle, max(run[4] for run in runs), *runs[0][5:7], fixed))
            print(rows[-1], flush=True)
    PAGE.write_text(_page(rows))


def _run(file):
    command = [sys.executable, "-c", WORK, file]
    return json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)


def _page(rows):
    lines = [
        "# Preflight of programs",
        "",
        f"NC programs of {LINES // 1000} 000 lines with G64 P0.01 on nist-octahedral: read, planned and judged, in",
        "seconds of CPU time; one process each.",
        f"{processor()}.  `python -m bench.preflight` writes this page.",
        "",
        "| program | read | plan | judge | together | memory, MB | poses looked at | limits exceeded | `--fix-feed` |",
        "|---|---|---|---|---|---|---|---|---|",
        *(
            f"| {name} | {read:.2f} | {plan:.2f} | {judge:.2f} | {whole:.2f} | {mb:.0f} | {poses} | {found} "
            f"| {'' if fixed is None else f'{fixed:.1f}'} |"
            for name, read, plan, judge, whole, mb, poses, found, fixed in rows
        ),
        "",
        "surface: a raster, 0.4 mm a line; flank: a helix with a leaning tool, five axes, 0.75 mm a line; corners:",
        "lines of 50 mm between random places.  `--fix-feed`: what it takes beside, until the new program passes.",
        "",
    ]
    return "\n".join(lines)


if __name__ == "__main__":
    main()
