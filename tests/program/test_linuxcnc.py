"""Our reading of NC programs against LinuxCNC's: its interpreter `rs274` prints the moves it makes of a program."""

import re
import shutil
import subprocess
from pathlib import Path as FilePath

import numpy as np
import pytest

from gough.errors import ProgramError
from gough.program.blocks import ARC
from gough.program.gcode import read_gcode
from gough.program.path import Path

RS274 = shutil.which("rs274")
EXAMPLE = FilePath(__file__).parents[2] / "examples" / "circle_diamond_square.ngc"
# rs274 prints four decimals of the program's unit; generated words have six, which moves the centre of an arc through
# both ends by a few of their last place
HALF, WRITTEN = 0.5e-4, 5e-6

pytestmark = pytest.mark.skipif(RS274 is None, reason="LinuxCNC's interpreter rs274 is not installed")


def rs274(text, folder):
    file = folder / "part.ngc"
    file.write_text(text)
    return subprocess.run([RS274, "-g", file], cwd=folder, capture_output=True, text=True, timeout=20)


def canon(text):
    """Moves: unit in mm, end x y z a b c in mm and deg, and of an arc its centre and its sense, else None."""
    unit, out = 1.0, []
    for name, inner in re.findall(r"([A-Z_]+)\(([^)]*)\)", text):
        if name == "USE_LENGTH_UNITS":
            unit = {"CANON_UNITS_MM": 1.0, "CANON_UNITS_INCHES": 25.4}[inner]
        elif name in ("STRAIGHT_TRAVERSE", "STRAIGHT_FEED"):
            n = [float(word) for word in inner.split(",")]
            out.append((unit, [*(unit * v for v in n[:3]), *n[3:6]], None))
        elif name == "ARC_FEED":  # end x, y, centre x, y, turns, end z, a, b, c
            n = [float(word) for word in inner.split(",")]
            end = [unit * n[0], unit * n[1], unit * n[5], *n[6:9]]
            out.append((unit, end, (unit * n[2], unit * n[3], np.sign(n[4]))))
    return out


def assert_alike(text, folder):
    found = rs274(text, folder)
    assert found.returncode == 0, found.stderr
    theirs, ours = canon(found.stdout), Path(read_gcode(text))
    assert len(ours) == len(theirs) > 0
    i = np.arange(len(ours))
    ends = np.column_stack([1e3 * ours.point(i, ours.length), np.degrees(ours.angles(i, ours.extent))])
    arcs = ours.batches[ARC]
    for k, (unit, end, round_) in enumerate(theirs):
        off = HALF * unit + WRITTEN * unit
        np.testing.assert_allclose(ends[k, :3], end[:3], rtol=0, atol=off, err_msg=f"move {k}")
        np.testing.assert_allclose(ends[k, 3:], end[3:], rtol=0, atol=HALF + WRITTEN, err_msg=f"move {k}")
        assert (ours.kind[k] == ARC) == (round_ is not None)
        if round_:
            j = ours.index[k]
            np.testing.assert_allclose(1e3 * arcs.center[j, :2], round_[:2], rtol=0, atol=off, err_msg=f"move {k}")
            assert np.sign(arcs.sweep[j] * arcs.normal[j, 2]) == round_[2]


class Writer:
    """Random programs of the subset.  Position and offsets are in the program's unit, as written, six decimals."""

    def __init__(self, seed):
        self.rng = np.random.default_rng(seed)
        self.at, self.scale, self.absolute = np.zeros(6), 1.0, True
        self.lines = ["G17 G21 G90", "F500"]
        self.lines += [self.block() for _ in range(14)]
        self.text = "\n".join([*self.lines, "M2\n"])

    def words(self, letters, end):
        out = []
        for letter in letters:
            k = "XYZABC".index(letter)
            written = round(end[k] - (0.0 if self.absolute else self.at[k]), 6)
            self.at[k] = written if self.absolute else self.at[k] + written
            out.append(f"{letter}{written:.6f}")
        return out

    def block(self):
        rng = self.rng
        kind = rng.choice(["line", "turn", "center", "radius", "full", "unit", "distance"], p=[0.3, *[0.12] * 5, 0.1])
        if kind == "unit":
            inch = bool(rng.integers(2))
            self.at[:3] *= self.scale / (25.4 if inch else 1.0)
            self.scale = 25.4 if inch else 1.0
            return "G20" if inch else "G21"
        if kind == "distance":
            self.absolute = bool(rng.integers(2))
            return "G90" if self.absolute else "G91"
        end = np.append(rng.uniform(-80, 80, 3) / self.scale, rng.uniform(-20, 20, 3))
        more = "".join(letter for letter in "ZABC" if rng.random() < 0.4)  # what makes a helix, or tilts on the way
        if kind == "turn":
            return " ".join([f"G{rng.integers(2)}", *self.words("ABC", end)])
        if kind == "line":
            return " ".join([f"G{rng.integers(2)}", *self.words("XY" + more, end)])
        code, radius, angle = rng.integers(2, 4), rng.uniform(5, 40) / self.scale, rng.uniform(0, 2 * np.pi)
        offset = np.round(radius * np.array([np.cos(angle), np.sin(angle)]), 6)
        ij = [f"I{offset[0]:.6f}", f"J{offset[1]:.6f}"]
        if kind == "full":
            return " ".join([f"G{code}", *self.words(more, end), *ij])
        turn = rng.uniform(0.6, 2 * np.pi - 0.6)  # the chord is half a radius at least
        c, s = np.cos(turn), np.sin(turn)
        end[:2] = self.at[:2] + offset - np.array([[c, -s], [s, c]]) @ offset
        chord = np.linalg.norm(end[:2] - self.at[:2])
        r = f"R{rng.choice([-1, 1]) * chord * rng.uniform(0.6, 2):.6f}"
        return " ".join([f"G{code}", *self.words("XY" + more, end), *([r] if kind == "radius" else ij)])


def test_the_example_moves_as_linuxcnc_moves_it(tmp_path):
    assert_alike(EXAMPLE.read_text(), tmp_path)


@pytest.mark.parametrize("seed", range(30))
def test_a_random_program_of_the_subset_moves_as_linuxcnc_moves_it(seed, tmp_path):
    assert_alike(Writer(seed).text, tmp_path)


def test_the_random_programs_use_what_they_are_to_compare():
    words = set(re.findall(r"G\d+|[A-Z](?=-?\d+\.)", " ".join(Writer(seed).text for seed in range(30))))
    assert words >= set("XYZABCIJR") | {"G0", "G1", "G2", "G3", "G20", "G21", "G90", "G91"}


@pytest.mark.parametrize(
    "block",
    [
        "G1 X10",  # no feed
        "F100 G2 X10 R4",
        "F100 G2 X0 Y0 R4",
        "F100 G2 X21 I10",
        "F100 G2 X10 I0 J0",
        "F100 G2 X10",
        "F100 G2 X10 R5 I5",
        "G0 G1 X10 F100",
        "G0 X1 X2",
        "G0 X1.2.3",
        "G0 X1 (open",
    ],
)
def test_what_linuxcnc_refuses_is_refused(block, tmp_path):
    text = f"G21 G90\n{block}\nM2\n"
    assert rs274(text, tmp_path).returncode != 0
    with pytest.raises(ProgramError):
        Path(read_gcode(text))
