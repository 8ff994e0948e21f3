"""LinuxCNC runs programs on exported machines: what it commands is what our kinematics and planner's spline say."""

from __future__ import annotations

import re
import sys

import numpy as np
import pytest

from gough.frames import abc_of_rotation_np, rotation_of_abc_np
from gough.kernel.pack import flatten
from gough.kernel.rows import compile_rows
from gough.linuxcnc.channels import hal_of
from gough.linuxcnc.motion import LATE
from gough.observe.disturbance import DisturbanceObserver
from gough.observe.tasks import function_of

from .machines import machine_of, needs_linuxcnc, run

pytestmark = [pytest.mark.full, needs_linuxcnc]

RUNS = [
    ("default-hexapod", "turned"), ("ccu-3prs", "line"),
    *(pytest.param(one, marks=pytest.mark.slow)
      for one in (("nist-octahedral", "corners"), ("turned-home", "tilted"), ("eth-hexaglide", "line"))),
]  # fmt: skip
EXACT = 1e-12  # m; of the issue: lengths of 1 m have 2e-16


@pytest.fixture(scope="module", params=RUNS, ids="-".join)
def made(request):
    name, part = request.param
    return machine_of(name), run(name, part)


def waypoints(machine, axis):
    """Joints (N, n) m of poses (N, d) of the program's frame."""
    return machine.inverse_kinematics(in_W(machine, axis))


def in_W(machine, axis):
    """Poses (N, d) of the program's frame, m and rad, in W."""
    zero = np.asarray(machine.program_zero)
    R_WO = rotation_of_abc_np(zero[3:])
    p = zero[:3] + axis[:, :3] @ R_WO.T
    return p if axis.shape[1] == 3 else np.c_[p, abc_of_rotation_np(R_WO @ rotation_of_abc_np(axis[:, 3:]))]


def test_joint_commands_are_the_spline_through_our_inverse_kinematics_two_periods_late(made):
    machine, found = made
    q = waypoints(machine, found.axis)
    T, n = found.period, len(found.axis) - 2 - LATE
    spline = (q[:-2] + 4 * q[1:-1] + q[2:]) / 6
    rate, acceleration = (q[2:] - q[:-2]) / (2 * T), (q[2:] - 2 * q[1:-1] + q[:-2]) / T**2
    behind = slice(1 + LATE, 1 + LATE + n)
    assert np.abs(found.joint[behind] - spline[:n]).max() < EXACT
    # differences of joints that are right to EXACT
    assert np.abs(found.joint_rate[behind] - rate[:n]).max() < EXACT / T
    assert np.abs(found.joint_acceleration[behind] - acceleration[:n]).max() < 4 * EXACT / T**2
    assert np.ptp(found.joint, axis=0).max() > 5e-3  # it did move


def test_the_pose_that_linuxcnc_sees_is_the_one_its_joints_have(made):
    machine, found = made
    rows = found.rows
    assert rows["failures"][-1] == 0 and not rows["tripped"].any() and not rows["status"][found.first :].any()
    scale = np.array([1e-3] * 3 + [np.pi / 180] * 3)[: rows["pose"].shape[1]]
    seen = waypoints(machine, rows["pose"][found.first :] * scale)
    assert np.abs(seen - rows["read"][found.first :] * 1e-3).max() < 1e-10  # m: residual that the C header promises


def test_at_the_end_the_machine_stands_where_it_was_told_to(made):
    _, found = made
    # mm and degrees; the angles are those of joints right to 1e-10 m on levers of 0.1 m and more, so 1e-7 deg
    assert np.abs(found.rows["pose"][-1] - found.rows["axis"][-1]).max() < 1e-7


def test_the_observer_in_linuxcnc_gives_the_bits_of_the_one_lane_kernel(made):
    machine, found = made
    observer = DisturbanceObserver().on(machine, found.period)
    step = compile_rows(function_of(observer), lanes=1)
    rows, state = found.rows, np.ravel(flatten(observer.init(machine.home)))
    most = min(len(rows["homed"]), found.first + 1500)  # from the start of the thread, through homing, into the program
    wrench, held = np.empty((most, 6)), np.empty(most)
    q, u, good = rows["read"] / 1000.0, rows["force"], rows["homed"]
    for k in range(most):
        out, after = step(observer.theta, state, q[k], u[k], good[k : k + 1])
        wrench[k], held[k], state = out[0, :6], out[0, 12], after[0]
    assert (held == 0).sum() > 1000
    assert np.array_equal(rows["held"][:most], held)
    assert np.array_equal(rows["wrench"][:most], wrench)


def test_the_feedforward_is_our_inverse_dynamics_of_the_commanded_motion(made):
    from gough.declare import Shape
    from gough.linuxcnc.motion import _rates

    machine, found = made
    part = slice(found.first + LATE, found.first + len(found.axis), 7)
    rows = found.rows
    q = rows["joint"][part] * 1e-3
    x = machine.forward_kinematics(q, near=in_W(machine, found.axis)[::7][: len(q)])
    xd, xdd = _rates(Shape(machine))(
        machine.theta, machine.coordinates(x), rows["joint_rate"][part] * 1e-3, rows["joint_acceleration"][part] * 1e-3
    )
    force = machine.inverse_dynamics(x, xd, xdd)
    # poses agree to 1e-10 m, forces of some kN change by less than 1 MN/m
    assert np.abs(force - rows["force"][part]).max() < 1e-4


def test_supervision_trips_at_the_first_sample_at_which_gough_s_law_does(monkeypatch):
    from gough.linuxcnc import record as recorder

    from .machines import program_of

    # joint 2 follows as through a low pass, some 20 periods late; LinuxCNC's own supervision looks away
    lag = "loadrt lowpass\naddf lowpass.0 servo-thread\nunlinkp joint.2.motor-pos-fb\nsetp lowpass.0.gain 0.05\n"
    lag += "net joint2-motor => lowpass.0.in\nnet lagging lowpass.0.out => joint.2.motor-pos-fb\n"
    module = sys.modules["gough.linuxcnc.record"]
    headless = module._headless
    monkeypatch.setattr(module, "hal_of", lambda channels: hal_of(channels) + lag)
    monkeypatch.setattr(module, "_headless", lambda *ini: re.sub(r"FERROR = .*", "FERROR = 50", headless(*ini)))
    machine, least, ferror = machine_of("nist-octahedral"), 0.1e-3, 0.9e-3
    found = recorder(program_of("corners"), machine, timeout=60, ferror=ferror, min_ferror=least)
    rows, slope = found.rows, ferror / machine.limits.speed
    asked, speed = rows["joint"][:-1], np.abs(rows["joint_rate"][:-1])
    allowed = np.maximum(slope * speed, least * 1e3)
    assert np.array_equal(rows["allowed"][1:], allowed[:, 0])
    beyond = (np.abs(asked - rows["read"][1:]) > allowed) & (rows["homed"][1:, None] != 0)
    first = int(np.argmax(beyond.any(1)))
    assert beyond.any() and np.flatnonzero(rows["tripped"])[0] == first + 1
    assert rows["tripped"][first + 1 :].all()  # latched
    assert rows["tripped_joint"][-1] == np.flatnonzero(beyond[first])[0] == 2


def test_two_runs_are_the_same_to_the_last_bit_whatever_the_speed():
    from gough.linuxcnc import record

    from .machines import program_of

    first = run("nist-octahedral", "corners")
    again = record(program_of("corners"), machine_of("nist-octahedral"), speed=4, timeout=120)
    assert np.array_equal(first.axis, again.axis)
    assert np.array_equal(first.joint, again.joint)
    assert np.array_equal(first.joint_acceleration, again.joint_acceleration)
