"""NC programs whose tool leans: what is written, what LinuxCNC makes of it, and what is refused."""

from __future__ import annotations

import re
import shutil
import subprocess

import numpy as np
import pytest
from numpy.testing import assert_allclose

from gough.cutting.profile import profile_of, thinned
from gough.cutting.rewrite import CHORD, rewritten
from gough.errors import ExperimentError, LogError, ProgramError
from gough.program.nc import NCProgram
from gough.program.path import Path

RS274 = shutil.which("rs274")
DEG = np.pi / 180
STRAIGHT = "G21 G90 G94 G61\nG0 X0 Y0 Z0\nG1 Y-50 F6000 (the wall)\nG1 Y-60\nG0 X20\nM2\n"
S, TILT = [0.0, 0.010, 0.012, 0.038, 0.040, 0.1], [0.0, 0.0, 0.06 * DEG, 0.06 * DEG, 0.0, 0.0]


def lean(text, s=S, tilt=TILT, height=18e-3):
    return rewritten(NCProgram(text=text, name="part.ngc"), np.array(s), np.array(tilt), height)


def test_a_line_that_leans_stands_above_its_new_lines():
    made = lean(STRAIGHT)
    assert made.program.text.splitlines() == [
        "G21 G90 G94 G61", "G0 X0 Y0 Z0", "; was: G1 Y-50 F6000 (the wall)", "G64 P0.002", "G1 Y-10 F6000",
        "G1 X-0.0188 Y-12 B0.06", "G1 Y-38", "G1 X0 Y-40 B0", "G1 Y-50", "G61", "G1 Y-60", "G0 X20", "M2",
    ]  # fmt: skip
    (change,) = made.changes
    assert (change.line, change.was) == (3, "G1 Y-50 F6000 (the wall)")
    assert_allclose([change.tilt, change.shift], [0.06 * DEG, 18e-3 * np.tan(0.06 * DEG)], rtol=1e-12)


def test_nothing_to_lean_against_leaves_every_character():
    assert lean(STRAIGHT, tilt=np.zeros(6)).program.text == STRAIGHT


def test_a_line_behind_one_that_ends_leaning_goes_back_to_its_place():
    made = lean(STRAIGHT, s=[0.0, 0.02, 0.05, 0.055], tilt=[0.0, 0.05 * DEG, 0.05 * DEG, 0.0])
    assert [change.line for change in made.changes] == [3, 4]
    assert made.program.text.splitlines()[-7:] == [
        "; was: G1 Y-60", "G64 P0.002", "G1 X0 Y-55 B0 F6000", "G1 Y-60", "G61", "G0 X20", "M2",
    ]  # fmt: skip


def test_the_corrected_path_is_the_correction_of_the_path():
    """Along +x the tool moves by -delta y and turns by -theta about x: a is -theta."""
    made = lean("G0 X0 Y0 Z0\nG1 X50 F600\nM2\n")
    path = made.program.path()
    i, u = path.locate(np.array([0.025]))
    assert_allclose(path.point(i, u), [[0.025, -18e-3 * np.tan(0.06 * DEG), 0.0]], rtol=0, atol=1e-7)
    assert_allclose(path.angles(i, u), [[-0.06 * DEG, 0, 0]], rtol=0, atol=1e-6)


@pytest.mark.parametrize("code", ["G2 X40 Y0 I20 J0", "G3 X40 Y0 I20 J0"])
def test_an_arc_becomes_chords_of_the_arc_beside_it(code):
    """Clockwise from (0, 0) about (20, 0): the left of the feed is outward, so the tool moves inward by delta."""
    text, theta = f"G0 X0 Y0 Z0\n{code} F600\nG1 X50 Y0\nM2\n", 0.1 * DEG
    made = lean(text, s=[0.0, 0.01, 0.05, 0.07], tilt=[0.0, theta, theta, 0.0])
    path = made.program.path()
    s = np.linspace(0.015, 0.045, 200)
    p = path.point(*path.locate(s))
    radius = np.hypot(p[:, 0] - 0.02, p[:, 1])
    delta = 18e-3 * np.tan(0.1 * DEG)
    expected = 0.02 - delta if code.startswith("G2") else 0.02 + delta
    assert (np.abs(radius - expected) < CHORD + 1e-7).all()
    assert_allclose(np.hypot(*path.angles(*path.locate(s))[:, :2].T), 0.1 * DEG, rtol=0.01)


def test_a_modal_arc_behind_a_leaning_one_is_written_out():
    text = "G0 X0 Y0 Z0\nG2 X10 Y0 I5 J0 F600\nX20 Y0 I5 J0\nG1 X30\nM2\n"
    made = lean(text, s=[0.0, 0.004, 0.008, 0.012], tilt=[0.0, 0.0, 0.05 * DEG, 0.0])
    assert [change.line for change in made.changes] == [2, 3]
    end = made.program.path()
    assert_allclose(end.point(np.array([len(end) - 1]), end.length[-1:]), [[0.03, 0, 0]], rtol=0, atol=1e-9)


@pytest.mark.skipif(RS274 is None, reason="LinuxCNC's interpreter rs274 is not installed")
def test_linuxcnc_moves_where_gough_does(tmp_path):
    made = lean(STRAIGHT)
    file = tmp_path / "c.ngc"
    file.write_text(made.program.text)
    done = subprocess.run([RS274, "-g", file], cwd=tmp_path, capture_output=True, text=True, timeout=20)
    assert done.returncode == 0, done.stderr
    theirs = [
        [float(x) for x in re.findall(r"[-\d.]+", row)] for row in re.findall(r"STRAIGHT_\w+\((.*)\)", done.stdout)
    ]
    path: Path = made.program.path()
    rows = np.arange(len(path))
    ours = np.concatenate([1e3 * path.point(rows, path.length), np.degrees(path.angles(rows, path.extent))], 1)
    theirs = np.array(theirs)[-len(ours) :]  # the rapid to where the tool is already is no move of ours
    assert_allclose(ours, theirs, rtol=0, atol=5e-5)  # it prints four decimals


@pytest.mark.parametrize(
    "text, message",
    [
        (
            "G0 X0 Y0 Z0\nG1 X50 F600 M3 S100\nM2\n",
            "part.ngc:2: a line whose tool leans must do no more than move, got M3",
        ),
        ("G0 X0 Y0 Z0\nG1 X[25+25] F600\nM2\n", "part.ngc:2: a line whose tool leans must do no more than move, got "),
        (
            "G91\nG1 X25 F600\nX25\nM2\n",
            "part.ngc:2: the corrected program does not come to the path that was meant, got",
        ),
        (
            "G93\nG1 X50 F10\nM2\n",
            "part.ngc: the corrected program cannot be read back, got part.ngc:5: G1 without F in its own block",
        ),
        ("G20\nG1 X2 F60\nM2\n", "part.ngc:2: the corrected program does not come to the path that was meant, got"),
        ("o1 repeat [2]\nG1 X25 F600\nG1 X0\no1 endrepeat\nM2\n", "must run once, got 2 moves; write out the loop"),
    ],
)
def test_a_program_that_cannot_be_rewritten_is_refused(text, message):
    with pytest.raises(ProgramError) as caught:
        lean(text)
    assert message in str(caught.value)


# -- the force along the path ---------------------------------------------------------------------------------------


def ran(force_y, feed=0.1, way=0.05):
    """Rows of a straight run along +x at an even feed, pushed across; 0.05 s of acceleration at either end."""
    path = NCProgram(text=f"G0 X0 Y0 Z0\nG1 X{1e3 * way:g} F{6e4 * feed:g}\nM2\n").path()
    t = np.arange(0, way / feed + 0.05, 1e-3)
    speed = feed * np.clip(np.minimum(t, t[-1] - t) / 0.05, 0, 1)
    s = np.concatenate([[0], np.cumsum((speed[1:] + speed[:-1]) / 2 * 1e-3)])
    f = np.zeros((len(t), 3))
    f[:, 1] = force_y(s) + 2000 * (np.gradient(speed, t) / 2)  # inertia, where the tool starts and stops
    return path, t, s * way / s[-1], f


def test_the_profile_is_the_force_less_that_of_the_air():
    path, t, s, f = ran(lambda s: 7.0 + 50.0 * (s > 0.03), way=0.08)
    found = profile_of(path, t, s, f, air=(0.018, 0.028))
    assert_allclose(found.air, 7.0, rtol=0, atol=1e-9)
    assert_allclose(found.force[(found.s > 0.033) & (found.s < 0.07)], 50.0, rtol=0, atol=1e-9)
    assert not found.force[found.s < 0.027].any()


def test_a_force_that_never_rises_is_told():
    path, t, s, f = ran(lambda s: 3.0 + 0 * s, way=0.08)
    with pytest.raises(LogError) as caught:
        profile_of(path, t, s, f, air=None)
    assert "the force never rises: there is nothing to compensate, got at most 3 N in a row" in str(caught.value)
    with pytest.raises(ExperimentError, match="--air: no row of the log lies in the air cut at an even speed"):
        profile_of(path, t, s, f, air=(0.5, 0.6))


def test_thinning_keeps_the_corners_of_a_chain_and_no_more():
    s = np.linspace(0, 1, 101)
    value = np.interp(s, [0, 0.2, 0.3, 1], [0, 0, 1, 1])
    assert_allclose(s[thinned(s, value, 1e-9)], [0, 0.2, 0.3, 1], rtol=0, atol=1e-12)
    noisy = value + 1e-3 * np.sin(1e3 * s)
    rows = thinned(s, noisy, 2.5e-3)
    assert np.abs(np.interp(s, s[rows], noisy[rows]) - noisy).max() <= 2.5e-3
    assert len(rows) < 8
