"""What a preflight says, against kinematics and dynamics worked out here, and against what another feed comes to."""

from __future__ import annotations

import numpy as np
import pytest

import gough as gk
from gough.errors import ProgramError
from gough.plan import preflight
from gough.plan.demand import ACCELERATION, FORCE, POSE, SPEED, Demand
from gough.plan.preflight import planned
from gough.program import Fourier
from gough.program.nc import NCProgram


@pytest.fixture(scope="module")
def machine():
    return gk.load_machine("nist-octahedral")


def nc(text: str) -> NCProgram:
    return NCProgram(text=text, name="part.ngc")


def lengths(machine, p):
    """Strut lengths of an upright tool at p (n, 3) from home, by the law of distances alone.  (n, 6)."""
    B = machine.home[:3] + np.asarray(p)[:, None] + machine.platform_joints_np()
    return np.linalg.norm(B - machine.joints.base, axis=2)


LINE = "G21 G90\nG1 X-150 Y20 F3000\nG1 X150 Y60 Z30 F9000\nM2\n"


def test_peaks_are_those_of_struts_worked_out_from_distances(machine):
    found = preflight(machine, nc(LINE))
    start, end = np.array([-0.15, 0.02, 0]), np.array([0.15, 0.06, 0.03])
    s = np.linspace(0, 1, 20001)
    l = lengths(machine, start + s[:, None] * (end - start))
    speed = 0.15 * np.abs(np.gradient(l, s * np.linalg.norm(end - start), axis=0, edge_order=2)).max(0)
    for i in range(6):
        peak = next(p for p in found.peaks if p.joint == f"strut {i + 1}" and p.kind == SPEED)
        # at constant speed over nearly all of the line: its ramps of 4.5 mm at both ends slow the ends only
        assert peak.line == 3
        assert float(peak.value.split()[0]) <= speed[i] * (1 + 1e-3)
        assert float(peak.value.split()[0]) == pytest.approx(speed[i], rel=0.02)
        long = next(p for p in found.peaks if p.joint == f"strut {i + 1}" and p.what == "too long")
        assert float(long.value.split()[0]) == pytest.approx(max(l[:, i].max(), lengths(machine, [[0, 0, 0]])[0, i]),
                                                             abs=2e-5)  # fmt: skip


@pytest.mark.full
def test_a_limit_that_is_crossed_between_the_rows_first_looked_at_is_not_missed(machine):
    """The longest strut of a circle is known from distances; a limit a micrometre below it is exceeded for 1.6 mm."""
    circle = "G21 G90\nG1 X-100 F5000\nG3 X-100 Y0 I100 J0\nM2\n"
    t = np.linspace(0, 2 * np.pi, 400_001)
    longest = lengths(machine, 0.1 * np.stack([np.cos(t), np.sin(t), 0 * t], 1)).max()
    for offset, exceeded in ((-1e-6, True), (1e-7, False)):
        tight = machine.replace(**{"limits.length": [1.4, longest + offset], "strut.sleeve": 1.3})
        found = preflight(tight, nc(circle))
        assert (not found.passed) == exceeded
        if exceeded:
            worst = found.findings[0]
            assert (worst.line, worst.kind, worst.what) == (3, POSE, "too long")
            assert longest - 1e-6 < float(worst.value.split()[0]) <= longest + 1e-8


def test_forces_are_inverse_dynamics_and_the_friction_of_the_sheet():
    """okuma-pm600: friction without memory that no load scales, so F_c tanh(v / v_0) + f_v v by hand."""
    machine = gk.load_machine("okuma-pm600")
    rng = np.random.default_rng(1)
    x = machine.home + rng.uniform(-0.1, 0.1, (50, 6))
    xd, xdd = rng.uniform(-0.5, 0.5, (50, 6)), rng.uniform(-5, 5, (50, 6))
    demand = Demand(machine)
    qd = machine.joint_motion(x, xd, xdd)[1]
    law = machine.friction
    friction = law.coulomb * np.tanh(qd / law.smoothing) + law.viscous * qd
    np.testing.assert_allclose(
        demand.values(x, xd, xdd)[FORCE], machine.inverse_dynamics(x, xd, xdd) + friction, rtol=1e-9, atol=1e-6
    )


def test_friction_with_memory_counts_at_its_steady_value():
    machine = gk.load_machine("eth-hexaglide")
    x, zero = machine.home[None], np.zeros((1, 6))
    xd = np.array([[0.2, 0.1, 0.05, 0, 0, 0.0]])
    qd = machine.joint_motion(x, xd, zero)[1][0]
    friction = machine.friction.coulomb * np.sign(qd) + machine.friction.viscous * qd  # no Stribeck rise on the sheet
    found = Demand(machine).values(x, xd, zero)[FORCE][0]
    np.testing.assert_allclose(found - machine.inverse_dynamics(x, xd, zero)[0], friction, rtol=1e-9)


def test_both_sides_of_a_step_of_the_acceleration_are_judged(machine):
    """A line from rest to rest: joints' acceleration at its very start is g A, and nothing above it comes later."""
    found = preflight(machine, nc("G21 G90\nG1 X0.5 F9000\nM2\n"))
    x = machine.home[None]
    g = np.abs(machine.joint_motion(x, np.array([[1.0, 0, 0, 0, 0, 0]]), np.zeros((1, 6)))[1][0])
    peak = next(p for p in found.peaks if p.kind == ACCELERATION)
    assert peak.use * machine.limits.acceleration == pytest.approx(g.max() * machine.feed.acceleration, rel=2e-3)


@pytest.mark.parametrize("text", ["G21 G90\nG1 X200 F{F}\nX0\nM2\n", "G21 G90\nG3 X0 Y240 J120 I0 F{F}\nM2\n"])
def test_the_feed_that_is_called_fit_is_fit_and_a_faster_one_is_not(machine, text):
    worst = preflight(machine, nc(text.format(F=40000))).findings[0]
    assert worst.kind == SPEED and worst.advice.endswith("mm/min is fit")
    fit = float(worst.advice[1:].split()[0])
    assert preflight(machine, nc(text.format(F=fit))).passed
    assert not preflight(machine, nc(text.format(F=1.05 * fit))).passed  # where the line ends, and with it its speed


def test_no_feed_is_called_fit_where_the_controllers_own_acceleration_is_too_much():
    machine = gk.load_machine("eth-hexaglide")
    machine = machine.replace(**{"feed.acceleration": 20.0})
    found = preflight(machine, nc("G21 G90\nG1 X100 F60000\nM2\n")).findings
    refused = [one for one in found if one.advice.startswith("no F helps: an acceleration of")]
    assert refused and {one.kind for one in refused} == {FORCE}
    fit = min(float(one.advice.split()[6]) for one in refused)
    slower = machine.replace(**{"feed.acceleration": fit})
    again = preflight(slower, nc("G21 G90\nG1 X100 F60000\nM2\n")).findings
    assert not [one for one in again if one.advice.startswith("no F helps")]


def test_a_planner_with_joint_limits_drives_what_one_without_cannot(machine):
    program = nc("G21 G90\nG1 X200 F40000\nX0\nM2\n")
    assert not preflight(machine, program).passed
    found = preflight(machine, program, "joints")
    assert found.passed and found.peaks[0].use == pytest.approx(1.0, abs=1e-3)
    assert found.duration > preflight(machine, program).duration


def test_worst_comes_first_and_poses_before_what_a_feed_can_cure(machine):
    text = "G21 G90\nG1 X100 F25000\nX-100 F30000\nX0 F5000\nZ700\nM2\n"
    found = preflight(machine, nc(text))
    kinds = [one.kind for one in found.findings]
    assert kinds == sorted(kinds, key=lambda kind: kind != POSE) and POSE in kinds and SPEED in kinds
    speeds = [one.use for one in found.findings if one.kind == SPEED]
    assert speeds == sorted(speeds, reverse=True) and found.findings[len(kinds) - len(speeds)].line == 3


def test_a_leg_that_cannot_reach_is_named_with_its_line_and_by_how_much():
    found = preflight(gk.load_machine("eth-hexaglide"), nc("G21 G90\nG1 X50 F3000\nZ-900\nM2\n"))
    reach = [one for one in found.findings if "cannot reach" in one.what]
    assert reach and {one.line for one in reach} == {3} and reach[0].joint.startswith("leg ")
    assert "misses by" in reach[0].what and reach[0].advice.startswith("clamp the work elsewhere")
    assert found.least == -np.inf or found.least < 0


def test_what_the_sheet_gives_no_limit_for_is_said_not_to_be_checked():
    machine = gk.load_machine("emps")
    found = preflight(machine, nc("G21 G90\nG1 X100 F5000\nM2\n"))
    assert found.demand.unchecked == (FORCE,)
    assert "emps has no limit of its joints' force: not checked" in found.warnings


def test_a_pose_outside_the_declared_workspace_is_a_warning_and_not_a_finding(machine):
    found = preflight(machine, nc("G21 G90\nG1 X260 F3000\nM2\n"))
    assert found.passed
    assert "line 2: beyond the radius of the workspace: 0.26 m (declared 0.25 m)" in found.warnings


def test_a_motion_over_time_has_no_lines_to_judge(machine):
    program = Fourier(period=2.0, sine=[[0.0] * 3] * 2, cosine=[[0.01, 0.0, 0.0], [-0.0025, 0.0, 0.0]])
    with pytest.raises(ProgramError, match="has no path with a feed along it"):
        preflight(machine, program)


@pytest.mark.quick("nist-octahedral", "emps")
@pytest.mark.parametrize("name", ["ccu-3prs", "emps", "eth-hexaglide", "ifma-hsm", "nist-octahedral", "okuma-pm600"])
def test_every_machine_of_the_library_can_be_asked(name):
    found = preflight(gk.load_machine(name), nc("G21 G90\nG1 X40 F3000\nX0\nM2\n"))
    assert found.passed and 0 < found.least < 1 and found.found.rows > 10
    assert len(found.peaks) == len(found.demand)


def test_the_text_says_verdict_line_joint_value_and_limit(machine):
    text = str(preflight(machine, nc("G21 G90\nG1 X200 F40000\nX0\nM2\n")))
    assert "limits are exceeded, worst first:" in text and "F as written, limits of the tool alone" in text
    row = text.splitlines()[3].split()
    assert row[0] in "23" and row[1] == "strut" and "speed too high" in text and "0.3 m/s" in text


def test_times_and_rows_are_those_of_the_motion_as_planned(machine):
    program = nc("G21 G90\nG1 X200 F40000\nX0\nM2\n").replace(lead_in=0.5)
    found, plain = preflight(machine, program), preflight(machine, program.replace(lead_in=0.0))
    assert [one.time for one in found.findings] == pytest.approx([one.time + 0.5 for one in plain.findings])
    motion = planned(machine, program)
    k = int(round(found.findings[0].time / 1e-4))
    assert motion.book(k, k + 1, 1e-4).line[0] == found.findings[0].line
