"""Programs with feeds that joints can follow: limits kept, moves where they were, little time lost."""

from __future__ import annotations

import shutil
import subprocess

import numpy as np
import pytest

import gough as gk
from gough.errors import ProgramError, SheetError, WorkspaceError
from gough.plan import fix_feed, preflight
from gough.plan.demand import FORCE, Demand
from gough.plan.preflight import planned
from gough.program.blocks import ARC, LINE
from gough.program.nc import NCProgram

from .programs import TOO_FAST

RS274 = shutil.which("rs274")
_KEEPS = 1e-3  # what a limit may be exceeded by: the issue's


@pytest.fixture(scope="module")
def machine():
    return gk.load_machine("nist-octahedral")


def nc(text: str) -> NCProgram:
    return NCProgram(text=text, name="part.ngc")


@pytest.fixture(scope="module")
def fixed(machine):
    known = {}

    def of(name):
        if name not in known:
            known[name] = fix_feed(machine, nc(TOO_FAST[name]))
        return known[name]

    return of


CASES = pytest.mark.parametrize("name", TOO_FAST)
QUICK = pytest.mark.quick("exact stop", "inverse time")


@QUICK
@CASES
def test_every_joint_keeps_its_limits_at_samples_of_its_own(machine, fixed, name):
    """Speeds and accelerations by differences of strut lengths at 0.5 ms, forces by inverse dynamics there."""
    assert not fixed(name).before.passed and fixed(name).after.passed
    motion = planned(machine, fixed(name).program)
    r = motion.sample(0, motion.count(5e-4), 5e-4)
    speed = np.abs(np.diff(r.q, axis=0)).max() / 5e-4
    assert speed <= machine.limits.speed * (1 + _KEEPS)
    assert np.abs(r.qdd).max() <= machine.limits.acceleration * (1 + _KEEPS)
    demand = Demand(machine)
    forces = demand.values(r.x, r.xd, r.xdd)[FORCE]
    assert np.abs(forces).max() <= demand.limits[FORCE] * (1 + _KEEPS)


@QUICK
@CASES
def test_fixing_twice_is_fixing_once(machine, fixed, name):
    again = fix_feed(machine, fixed(name).program)
    assert again.program.text == fixed(name).program.text and not again.changes and again.before.passed


@QUICK
@CASES
def test_moves_stay_where_they_were_and_arcs_stay_arcs(fixed, name):
    old, new = nc(TOO_FAST[name]).path(), fixed(name).program.path()
    assert new.s0[-1] == pytest.approx(old.s0[-1], rel=1e-9)
    assert {LINE: 0, ARC: 1}[LINE] == LINE
    assert set(new.kind.tolist()) == set(old.kind.tolist())
    s = np.linspace(0, 1, 500)[1:-1]
    at = []
    for path in (old, new):
        i, u = path.locate(s * path.s0[-1])
        at.append(path.point(i, u))
    np.testing.assert_allclose(at[0], at[1], atol=1e-7)  # words are written to a nanometre


@QUICK
@CASES
def test_lines_that_need_no_change_are_the_bytes_they_were(fixed, name):
    old, new = TOO_FAST[name].split("\n"), fixed(name).program.text.split("\n")
    changed = {change.line for change in fixed(name).changes}
    rest = [text for number, text in enumerate(old, 1) if number not in changed]
    position = 0
    for text in rest:  # all of them are there, in their order
        position = new.index(text, position) + 1
    for change in fixed(name).changes:
        if len(change.now) > 1:
            assert f"; was: {change.was}" in [text.rstrip("\r") for text in new]


@pytest.mark.skipif(RS274 is None, reason="LinuxCNC's interpreter rs274 is not installed")
@pytest.mark.full
@CASES
def test_linuxcnc_reads_what_was_written(fixed, name, tmp_path):
    file = tmp_path / "part.ngc"
    file.write_text(fixed(name).program.text)
    done = subprocess.run([RS274, "-g", file], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0 and "error" not in (done.stdout + done.stderr).lower()
    feeds = [line for line in done.stdout.splitlines() if "_FEED(" in line]
    path = fixed(name).program.path()
    assert len(feeds) == np.sum(((path.kind == LINE) | (path.kind == ARC) | path.turning_at_rest) & ~path.rapid)


def test_short_lines_that_the_roundings_beside_them_swallow_whole_are_slowed_as_others_are(machine):
    """Rows of lines of 0.4 mm over a wave, G64 P0.01: of some lines nothing is left between their two corners."""
    rows = [[(-80 + 0.4 * i, y) for i in range(400)] for y in (-80.0, -79.4)]
    places = rows[0] + rows[1][::-1]
    wave = "\n".join(f"X{x:.4f} Y{y:.4f} Z{5 * np.sin(x / 20) * np.cos(y / 25):.4f}" for x, y in places)
    program = nc(f"G21 G90 G64 P0.01\nG1 F40000\n{wave}\nM2\n")
    course = planned(machine, program).course
    middle = course.place(np.arange(len(course.path)), course.path.extent / 2).block
    assert len(np.unique(middle)) < len(course.programmed), "some line has no block of the course about its middle"
    found = fix_feed(machine, program)
    assert not found.before.passed and found.after.passed and found.changes


# -- time against the optimum ------------------------------------------------------------------------------------------


def test_a_vertical_line_loses_less_than_two_per_cent_of_the_feed_optimal_time(machine):
    """On the axis all struts are alike, of length l(z) = sqrt(r^2 + (h + z)^2): the optimum in closed form.

    The greatest speed is V(z) = v l / |l'| / l, v the struts' limit, and the fastest profile rises at A from rest to
    it, keeps it, where the time is |l(z2) - l(z1)| / v whatever z does between, and comes to rest at A.
    """
    A, v = machine.feed.acceleration, machine.limits.speed
    B = machine.home[:3] + machine.platform_joints_np() - machine.joints.base
    r, h = np.hypot(B[0, 0], B[0, 1]), B[0, 2]
    np.testing.assert_allclose(np.hypot(B[:, 0], B[:, 1]), r, rtol=1e-9)

    def length(z):
        return np.hypot(r, h + z)

    def greatest(z):
        return v * length(z) / abs(h + z)

    z0, z1 = -0.2, 0.2
    low = high = 0.05
    for _ in range(100):  # z0 + low: where the ramp reaches the greatest speed; z1 - high likewise
        low, high = greatest(z0 + low) ** 2 / (2 * A), greatest(z1 - high) ** 2 / (2 * A)
    cruise = abs(length(z1 - high) - length(z0 + low)) / v
    optimum = (greatest(z0 + low) + greatest(z1 - high)) / A + cruise
    program = nc("G21 G90\nG1 Z-200 F1000\nZ200 F60000\nM2\n")
    found = fix_feed(machine, program)
    other = planned(machine, nc("G21 G90\nG1 Z-200 F1000\nM2\n")).duration
    assert found.after.passed
    assert found.before.duration - other < 0.85 * optimum  # the struts' limits matter
    assert optimum <= found.after.duration - other <= 1.02 * optimum


@pytest.mark.full
def test_a_circle_loses_less_than_two_per_cent_of_the_feed_optimal_time(machine):
    """The optimum by the phase plane on 200 000 points, with the struts' rates out of distances alone."""
    R, A = 0.1, machine.feed.acceleration
    t = np.linspace(0, 4 * np.pi, 200_001)
    p = R * np.stack([-np.cos(t), -np.sin(t), 0 * t], 1)
    S = machine.home[:3] + p[:, None] + machine.platform_joints_np() - machine.joints.base
    tangent = np.stack([np.sin(t), -np.cos(t), 0 * t], 1)
    g = np.abs((S * tangent[:, None]).sum(2) / np.linalg.norm(S, axis=2)).max(1)
    ds = R * (t[1] - t[0])
    b = np.minimum(machine.limits.speed / g, min(np.sqrt(A * R), 0.5)) ** 2  # towards the centre too the tool has A
    b[[0, -1]] = 0
    for i in range(len(b) - 1):
        b[i + 1] = min(b[i + 1], b[i] + 2 * A * ds)
    for i in reversed(range(len(b) - 1)):
        b[i] = min(b[i], b[i + 1] + 2 * A * ds)
    optimum = (2 * ds / (np.sqrt(b[1:]) + np.sqrt(b[:-1]))).sum()
    found = fix_feed(machine, nc("G21 G90\nG1 X-100 F3000\nG3 X-100 Y0 I100 J0 P2 F30000\nM2\n"))
    other = planned(machine, nc("G21 G90\nG1 X-100 F3000\nM2\n")).duration
    assert found.before.duration - other < optimum < found.after.duration - other < 1.02 * optimum


def test_staircases_are_no_finer_than_they_need_be(machine, fixed):
    """Neighbouring feeds of a move differ by about the step, so their number is what the range of feeds asks for."""
    feeds = [float(text.rpartition("F")[2]) for text in fixed("lines").changes[0].now]
    steps = np.abs(np.diff(np.log(feeds)))
    assert len(feeds) == 4 and (steps > 0.005).all() and (steps < 0.04).all()


# -- rapids, ramps, and what cannot be done ----------------------------------------------------------------------------


def test_a_rapid_that_is_too_fast_becomes_g1_and_the_next_rapid_stays_one(machine):
    slow = machine.replace(**{"limits.speed": 0.1})
    found = fix_feed(slow, nc("G21 G90\nG0 X200\nX100\nZ-1\nG1 X50 F600\nY10\nM2\n"))
    text = found.program.text
    assert "; was: G0 X200" in text and "G1 X" in text and "\nG0 Z-1\n" in text and "\nG1 X50 F600\nY10\n" in text
    path = found.program.path()
    assert path.rapid.sum() == 1 and found.after.passed


def test_a_feed_in_force_is_said_again_where_a_line_before_it_has_changed(machine):
    found = fix_feed(machine, nc("G21 G90\nF30000\nG1 X200\nZ-1\nF500\nZ-2\nM2\n"))
    assert "\nZ-1 F30000\nF500\nZ-2\nM2\n" in found.program.text


@pytest.mark.full
def test_what_ramps_cost_is_told_with_the_acceleration_that_would_cost_less():
    machine = gk.load_machine("eth-hexaglide")
    found = fix_feed(machine, nc("G21 G90 G64 P0.1\nG1 X200 F100000\nG3 X-200 Y0 I-200 J0\nG1 X0 Y0 Z-100\nM2\n"))
    assert found.after.passed and "s are lost to ramps: with an acceleration of" in found.note


@pytest.mark.full
def test_an_acceleration_that_no_feed_cures_is_refused_with_the_one_that_is_fit():
    machine = gk.load_machine("eth-hexaglide").replace(**{"feed.acceleration": 20.0})
    with pytest.raises(WorkspaceError) as told:
        fix_feed(machine, nc("G21 G90\nG1 X100 F60000\nM2\n"))
    assert "no feed keeps the force within its limit" in str(told.value)
    assert "no F helps: an acceleration of" in str(told.value) and told.value.problems[0].line == 2


def test_a_pose_out_of_reach_is_no_matter_of_feeds(machine):
    with pytest.raises(WorkspaceError, match="part.ngc:2: strut .: too long.*clamp the work elsewhere"):
        fix_feed(machine, nc("G21 G90\nG1 X900 F90000\nM2\n"))


def test_a_machine_without_limits_of_its_joints_says_what_to_write():
    machine = gk.load_machine("emps")
    bare = machine.replace(limits=machine.limits.replace(speed=None, acceleration=None))
    with pytest.raises(SheetError, match=r"limits: the machine has no limit of its joints' speed.*write speed = "):
        fix_feed(bare, nc("G21 G90\nG1 X100 F90000\nM2\n"))


@pytest.mark.parametrize(
    "text, rule",
    [
        ("G21 G90\no<a> sub\nG1 X#1\nZ#2\no<a> endsub\nF40000\no<a> call [200] [1]\nF500\no<a> call [0] [0]\nM2\n",
         "a line that runs several times has several feeds"),
        ("G21 G90\nG1 X200 F3000\nG28\nM2\n", "a move of G28 or G30 is too fast, and has no F"),
    ],
)  # fmt: skip
def test_lines_that_cannot_be_given_another_feed_are_named(machine, text, rule):
    slow = machine.replace(**{"limits.speed": 0.1})
    with pytest.raises(ProgramError, match=rule) as told:
        fix_feed(slow if "G28" in text else machine, nc(text))
    assert told.value.problems[0].file == "part.ngc" and told.value.problems[0].line in (3, 4)


def test_moves_of_a_called_file_are_not_changed(machine):
    program = NCProgram(
        text="G21 G90\no<far> call\nM2\n",
        name="part.ngc",
        subroutines={"far": "o<far> sub\nG1 X200 F40000\no<far> endsub\n"},
    )
    with pytest.raises(ProgramError, match="the feed of moves in a called file cannot be changed") as told:
        fix_feed(machine, program)
    assert told.value.problems[0].line == 2


def test_only_an_nc_program_has_feed_words(machine):
    with pytest.raises(ProgramError, match="only an NC program has feed words"):
        fix_feed(machine, gk.Circle(radius=0.1, feed=1.0))


def test_a_program_that_passes_is_left_alone(machine):
    program = nc("G21 G90\nG1 X20 F500\nM2\n")
    found = fix_feed(machine, program)
    assert found.program is program and not found.changes and found.after is found.before


@pytest.mark.full
def test_the_jerk_limited_feed_of_an_experiment_is_kept_too(machine):
    program = nc(TOO_FAST["rounded"]).replace(profile="jerk_limited")
    found = fix_feed(machine, program)
    assert found.after.passed and found.program.profile == "jerk_limited"
    assert preflight(machine, found.program).passed
