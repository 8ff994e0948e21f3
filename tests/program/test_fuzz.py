"""Damaged programs: no exception but ProgramError, no program over a second, less than 300 MB (G1-G9).

How many and from which seed: GOUGH_FUZZ and GOUGH_FUZZ_SEED.
"""

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
SEED = os.environ.get("GOUGH_FUZZ_SEED", "1")


def fuzz(count, seconds):
    # a process of its own: its memory is that of the reader, not of the tests before
    command = [sys.executable, "-m", "tests.program.fuzz", str(count), SEED]
    return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=seconds)


@pytest.mark.full
def test_damaged_programs_are_read_or_refused():
    done = fuzz(os.environ.get("GOUGH_FUZZ", 2_000), 300)
    assert done.returncode == 0, done.stdout[-4000:] + done.stderr[-2000:]


@pytest.mark.slow
def test_many_damaged_programs_are_read_or_refused():
    done = fuzz(os.environ.get("GOUGH_FUZZ", 100_000), 7200)
    assert done.returncode == 0, done.stdout[-4000:] + done.stderr[-2000:]
