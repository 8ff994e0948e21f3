"""The language against LinuxCNC's interpreter rs274: random expressions and random structured programs."""

import random
import re
import shutil
import subprocess

import pytest

from gough.program.ngc.parameters import Parameters

from .test_expressions import KEPT, tree, value
from .test_flow import body
from .test_flow_random import Writer

RS274 = shutil.which("rs274")
pytestmark = pytest.mark.skipif(RS274 is None, reason="LinuxCNC's interpreter rs274 is not installed")


def linuxcnc_dwells(lines, folder):
    file = folder / "part.ngc"
    file.write_text("\n".join([*lines, "M2", ""]))
    done = subprocess.run([RS274, "-g", file], cwd=folder, capture_output=True, text=True, timeout=20)
    assert done.returncode == 0, done.stderr
    return [float(number) for number in re.findall(r"DWELL\(([^)]*)\)", done.stdout)]


FUNCTIONS = {
    "SIN": (-400, 400), "COS": (-400, 400), "TAN": (-80, 80), "ASIN": (-1, 1), "ACOS": (-1, 1), "EXP": (-5, 5),
    "LN": (0.01, 100), "SQRT": (0, 100), "ABS": (-9, 9), "FIX": (-9, 9), "FUP": (-9, 9), "ROUND": (-9, 9),
}  # fmt: skip


def expressions(seed):
    """Texts of random expressions whose values are small enough to be compared at four decimals."""
    rng, out = random.Random(seed), []
    while len(out) < 150:
        text, found, _ = tree(rng, 3)
        if abs(found) < 1e4 and len(text) < 200:
            out.append(f"[{text}]")
    for name, (low, high) in FUNCTIONS.items():
        out += [f"{name}[{rng.uniform(low, high):.4f}]" for _ in range(8)]
        out += [f"{name}[{max(low, min(high, 30 * k))}]" for k in range(-2, 3) if low <= 30 * k <= high]
    out += [f"ATAN[{rng.randint(-3, 3)}]/[{rng.randint(-3, 3)}.5]" for _ in range(20)]
    return out


@pytest.mark.parametrize("seed", [0, 1, *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(2, 60))])
def test_random_expressions_have_linuxcncs_values(seed, tmp_path):
    texts = expressions(seed)
    # a dwell is not negative: 1e6 is added to every value
    lines = [f"#{n}={kept}" for n, kept in enumerate(KEPT, 1)] + [f"G4 P[{text} + 1000000]" for text in texts]
    theirs = linuxcnc_dwells(lines, tmp_path)
    parameters = Parameters()
    for number, kept in enumerate(KEPT, 1):
        parameters.set(number, kept)
    ours = [value(text, parameters) + 1e6 for text in texts]
    assert len(theirs) == len(ours)
    for text, a, b in zip(texts, ours, theirs, strict=True):
        assert abs(a - b) <= 0.51e-4, text  # half the last decimal that rs274 prints


def written(seed):
    writer = Writer(seed)
    writer.block(4)
    return writer.lines


def has(seed, *words):
    return any(word in " ".join(written(seed)) for word in words)


# a break or continue leaves a mark in LinuxCNC that a later do or repeat loop takes for its own, see below
COMPARED = [seed for seed in range(600) if not (has(seed, "break", "continue") and has(seed, " do", "repeat"))]
LEAVING = [seed for seed in COMPARED if has(seed, "break", "continue")]
QUICK = [
    *LEAVING[:6],
    *[seed for seed in COMPARED if has(seed, " do") and has(seed, "repeat")][:4],
    *[seed for seed in COMPARED if has(seed, "else")][:4],
]


@pytest.mark.parametrize(
    "seed", [*sorted({*QUICK}), *(pytest.param(s, marks=pytest.mark.slow) for s in COMPARED if s not in QUICK)]
)
def test_a_random_structured_program_runs_as_in_linuxcnc(seed, tmp_path):
    lines = written(seed)
    assert body(*lines, steps=10**7) == linuxcnc_dwells(lines, tmp_path)


@pytest.mark.parametrize(
    ("text", "ours", "theirs"),
    [
        # a break makes the next do loop end after its first turn
        ("o1 while [1]|o1 break|o1 endwhile|o2 do|#1=[#1+1]|G4 P#1|o2 while [#1 lt 3]", [1, 2, 3], [1]),
        # even one that never ran
        ("o1 while [0]|o1 break|o1 endwhile|o2 do|#1=[#1+1]|G4 P#1|o2 while [#1 lt 3]", [1, 2, 3], [1]),
        # a continue in the last turn of a do loop makes the next repeat run twice over
        ("o1 do|o1 continue|o1 while [0]|o2 repeat [3]|G4 P1|o2 endrepeat", [1] * 3, [1] * 6),
    ],
)
def test_a_break_and_a_continue_act_on_their_own_loop_only_unlike_in_linuxcnc(text, ours, theirs, tmp_path):
    assert body(*text.split("|")) == ours
    assert linuxcnc_dwells(text.split("|"), tmp_path) == theirs


def test_the_compared_programs_use_every_kind_of_flow():
    text = " ".join(" ".join(written(seed)) for seed in QUICK)
    assert all(word in text for word in ("else", "endwhile", " do", "endrepeat", "break", "continue"))
