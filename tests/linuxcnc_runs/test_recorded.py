"""Recorded motions as programs, without LinuxCNC: the recording is made as its planner's spline makes it."""

from __future__ import annotations

import numpy as np
import pytest

import gough as gk
from gough.errors import ExperimentError
from gough.linuxcnc import RecordedProgram, Recording
from gough.linuxcnc.motion import LATE
from gough.program.nc import NCProgram

MACHINE = gk.load_machine("nist-octahedral")
TEXT = "G21 G90 G61\nG1 F6000 X30\nG1 Y20 A4\nG3 X10 Y40 I-20\nG1 C8\nG0 X0 Y0 A0 C0\nM2\n"
T = 1e-3


def recorded(text=TEXT, machine=MACHINE):
    """A program, and a recording of gough's own motion of it: waypoints, spline of (1, 4, 1) / 6, two periods late."""
    program = NCProgram(text=text, name="part.ngc")
    motion = program.plan(machine)
    row, book = motion.sample(0, motion.count(T), T), motion.book(0, motion.count(T), T)
    q = np.concatenate([np.repeat(row.q[:1], LATE + 1, 0), row.q, row.q[-1:]])
    joint = (q[:-2] + 4 * q[1:-1] + q[2:]) / 6
    rate, acceleration = (q[2:] - q[:-2]) / (2 * T), (q[2:] - 2 * q[1:-1] + q[:-2]) / T**2
    zero = np.asarray(machine.program_zero)[: row.x.shape[1]]
    axis = np.concatenate([row.x, np.repeat(row.x[-1:], LATE, 0)]) - zero
    line = np.concatenate([book.line, np.repeat(book.line[-1:], LATE)])
    recording = Recording(T, axis, joint, rate, acceleration, line, {}, 0, ())
    return program, motion, RecordedProgram.of(program, recording, machine)


@pytest.fixture(scope="module")
def made():
    program, own, wrapped = recorded()
    return own, wrapped.plan(MACHINE)


def test_the_tool_stays_as_near_to_the_path_as_a_spline_through_its_samples_does(made):
    own, motion = made
    n = motion.count(T) - 300
    x = motion.sample(0, n, T).x
    late = own.sample(0, n, T).x
    # a spline of (1, 4, 1) / 6 misses its waypoint by T^2 a / 6: 0.1 m/s, 2 m/s2 and corners that stop: 0.4 um
    assert np.abs(x[LATE:, :3] - late[: n - LATE, :3]).max() < 1e-6
    assert np.abs(x[LATE:, 3:] - late[: n - LATE, 3:]).max() < 1e-5


def test_places_on_the_path_are_those_of_the_motion_it_was_made_of(made):
    own, motion = made
    n = motion.count(T) - 300
    book, true = motion.book(0, n, T), own.book(0, n, T)
    assert (np.diff(book.s) >= 0).all()
    moving = true.counted[: n - LATE]
    # the closest point: within what a corner of samples 0.1 mm apart leaves open
    assert np.abs(book.s[LATE:] - true.s[: n - LATE])[moving].max() < 1e-4
    same = book.line[LATE:] == true.line[: n - LATE]
    assert same[moving].mean() > 0.995  # rows at the junctions belong to either
    turning = true.line[: n - LATE] == 5  # at rest, C alone
    assert np.abs(book.u[LATE:] - true.u[: n - LATE])[turning & same].max() < 1e-4
    assert (book.counted[LATE:] == true.counted[: n - LATE]).mean() > 0.995


def test_speeds_and_accelerations_are_the_derivatives_of_what_is_commanded(made):
    _, motion = made
    k, h = 700, 1e-5
    fine = motion.sample(int(k * T / h) - 1, int(k * T / h) + 2, h)  # within the spline's pieces about knot k
    assert np.allclose((fine.q[2] - fine.q[0]) / (2 * h), fine.qd[1], atol=1e-9)
    assert np.allclose((fine.x[2] - fine.x[0])[:3] / (2 * h), fine.xd[1, :3], atol=1e-8)
    assert np.allclose((fine.xd[2] - fine.xd[0]) / (2 * h), fine.xdd[1], atol=2e-4)  # q''' jumps at a knot
    jacobian = MACHINE.velocity_jacobian(fine.x[1])
    assert np.allclose(jacobian @ fine.xd[1], fine.qd[1], atol=1e-14)


def test_a_finer_period_runs_through_the_same_knots(made):
    _, motion = made
    knots, fine = motion.sample(0, 400, T), motion.sample(0, 1600, T / 4)
    for name in ("x", "xd", "xdd", "q", "qd", "qdd", "s"):
        assert np.allclose(getattr(fine, name)[::4], getattr(knots, name), atol=1e-9), name
    assert np.abs(np.diff(fine.q, 2, axis=0)).max() < 4e-6 * T * 1e3  # smooth between them: 20 m/s2 at most


def test_a_recording_is_of_one_machine():
    _, _, program = recorded("G21 G90\nG1 F600 X1\nM2\n")
    other = gk.load_machine("okuma-pm600")
    with pytest.raises(ExperimentError, match="LinuxCNC ran the program on another machine"):
        program.plan(other)


def test_laws_follow_a_recorded_motion_as_they_do_gough_s_own():
    program, _, wrapped = recorded("G21 G90 G61\nG1 F3000 X10\nG1 Y5\nM2\n")
    law = gk.ComputedTorque(bandwidth=10.0)
    errors = [gk.simulate(MACHINE, law, one).metrics["contour_error"]["max"] for one in (program, wrapped)]
    assert errors[1] == pytest.approx(errors[0], rel=0.05)


def test_what_was_recorded_is_told_in_the_log():
    _, _, program = recorded("G21 G90\nG1 F600 X1\nM2\n")
    told = program.to_file()
    assert told["planner"].startswith("LinuxCNC") and told["servo_period"] == T and len(told["joints"]) == 64
