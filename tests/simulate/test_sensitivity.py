"""Sensitivities of a run: the derivative of what the machine code computes, and what has none is refused by name."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

import gough as gk
from gough import kernel as kernels
from gough.errors import ExperimentError, InputError
from gough.kernel import Schedule, Signal, Task
from gough.kernel.sensitivity import moving, named, with_sensitivities
from gough.simulate.sensitivity import contour_gradient

PROGRAM = gk.Circle(radius=0.02, feed=0.15, settle=0.05)


@pytest.fixture(scope="module")
def sheet():
    return gk.load_machine("nist-octahedral")


@pytest.fixture(scope="module")
def smooth(sheet):
    """Encoders that do not count, drives without an end, friction that fades through zero speed."""
    bare = sheet.replace(**{"drive.encoder": None, "drive.torque_limit": None})
    curve = {"coulomb": 300.0, "static": 400.0, "stribeck": 2e-3, "viscous": 930.0}
    return bare.replace(
        friction={"kind": "stribeck", **curve, "smoothing": 1e-3}, joints=sheet.joints.replace(friction=None)
    )


def test_the_sensitivity_of_a_recursion_is_its_derivative_by_hand():
    """x+ = a x + u, twice a tick by sub-steps, y = x^2: dx/da = sum of products, here carried out."""
    a, x, u = ca.SX.sym("a"), ca.SX.sym("x"), ca.SX.sym("u")
    step = ca.Function("step", [a, x, u], [a * x + u])
    square = ca.Function("square", [x], [x**2])
    plain = Schedule(
        [Signal("a", 1, "parameter"), Signal("u", 1, "input"), Signal("x", 1, "state"), Signal("y", 1, "wire")],
        (Task("square", square, ("x",), ("y",)),), (Task("step", step, ("a", "x", "u"), ("x",)),), 2, log=("x", "y"),
    )  # fmt: skip
    assert moving(plain, "a") == {"a", "x", "y"}
    schedule = with_sensitivities(plain, "a", 2, log=("x", "y"))
    kernel = kernels.compile(schedule, lanes=1, cache=False)
    states = {"x": [2.0], named("x"): [0.0, 1.0]}  # the second direction: a held, x(0) moved
    run = kernel.start({"a": [0.9], named("a"): [1.0, 0.0]}, states, runs=1)
    rows = run.advance(5, {"u": np.arange(5.0)})[:, 0]
    value, by_a, by_start = 2.0, 0.0, 1.0
    for k, row in enumerate(rows):
        found = {name: row[where] for name, where in kernel.columns.items()}
        np.testing.assert_allclose(found["x"], value, rtol=1e-15)
        np.testing.assert_allclose(found[named("x")], [by_a, by_start], rtol=1e-14, atol=0)
        np.testing.assert_allclose(found[named("y")], [2 * value * by_a, 2 * value * by_start], rtol=1e-14, atol=0)
        for _ in range(2):
            value, by_a, by_start = 0.9 * value + k, value + 0.9 * by_a, 0.9 * by_start


@pytest.mark.full
def test_the_gradient_of_computed_torque_is_that_of_finite_differences_of_second_order(sheet, smooth):
    """Central differences err by h^2: each half of a step divides the distance by 4, until rounding of rms / h."""
    laws = {h: gk.ComputedTorque(bandwidth=16.0 + h) for h in (-1.0, -0.5, -0.25, 0.0, 0.25, 0.5, 1.0)}

    def rms(h):
        return gk.simulate(sheet, laws[h], PROGRAM, smooth).metrics["contour_error"]["rms"]

    found = contour_gradient(sheet, laws[0.0], PROGRAM, smooth)
    # the same tick, compiled with more beside it: rounding of 1e-12 of metres against 4 um
    assert found.rms == pytest.approx(rms(0.0), rel=1e-7)
    away = [(rms(h) - rms(-h)) / (2 * h) / found.by_gain[0] - 1 for h in (1.0, 0.5, 0.25)]
    assert abs(away[2]) < 1e-3
    # the next term of the series, h^4, is a share of some h^2 / 16^2 of this one
    assert away[0] / away[1] == pytest.approx(4, rel=0.02) and away[1] / away[2] == pytest.approx(4, rel=0.02)


@pytest.mark.slow
def test_several_gains_of_a_joint_loop_and_bristles_have_a_gradient_too(sheet, smooth):
    """PID with three gains, LuGre friction: kinks of |v|, no jumps."""
    bristles = {"kind": "lugre", "coulomb": 300.0, "static": 400.0, "stribeck": 2e-3, "viscous": 930.0}
    plant = smooth.replace(friction={**bristles, "stiffness": 1e7, "damping": 1e4})
    own = {"bandwidth": 10.0, "speed_ratio": 3.0, "acceleration_feedforward": 0.5}
    found = contour_gradient(sheet, gk.PID(**own), PROGRAM, plant, tuple(own))
    for i, name in enumerate(own):
        h = 1e-3 * own[name]
        up, down = (
            gk.simulate(sheet, gk.PID(**{**own, name: own[name] + sign * h}), PROGRAM, plant) for sign in (1, -1)
        )
        slope = (up.metrics["contour_error"]["rms"] - down.metrics["contour_error"]["rms"]) / (2 * h)
        # h^2 / 6 of a third derivative of size f / g^3, and kinks that a step of 0.1 % moves across samples
        assert found.by_gain[i] == pytest.approx(slope, rel=1e-3)


@pytest.mark.full
@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({}, "plant.drive.encoder: has no gradient: the run is not smooth, got an encoder that counts; write"),
        ({"drive.encoder": None, "drive.torque_limit": 3.0}, "not smooth: a drive is at its limit, got at t = "),
    ],
)  # fmt: skip
def test_what_is_not_smooth_is_refused_by_name(sheet, smooth, change, said):
    plant = smooth.replace(**change) if change else sheet
    with pytest.raises(ExperimentError) as caught:
        contour_gradient(sheet, gk.PID(bandwidth=8.0), PROGRAM, plant)
    assert said in str(caught.value)


@pytest.mark.full
def test_a_gain_that_is_none_is_refused_by_name(sheet, smooth):
    with pytest.raises(ExperimentError, match="controller.poles: is no single number of the law"):
        contour_gradient(sheet, gk.PID(bandwidth=8.0), PROGRAM, smooth, ("poles",))


def test_a_task_that_takes_a_sign_is_refused_by_name_and_one_that_does_not_move_is_left_alone():
    a, x = ca.SX.sym("a"), ca.SX.sym("x")
    rough = ca.Function("rough", [a, x], [ca.sign(x) * a])
    signals = [Signal("a", 1, "parameter"), Signal("b", 1, "parameter"), Signal("x", 1, "state")]
    schedule = Schedule(signals, (Task("coulomb", rough, ("a", "x"), ("x",)),), log=("x",))
    with pytest.raises(InputError, match=r"task coulomb: has no derivative: it rounds or takes a sign, got sign"):
        with_sensitivities(schedule, "a", 1)
    assert with_sensitivities(schedule, "b", 1).tasks == schedule.tasks
    with pytest.raises(InputError, match="no such parameter, got c; one of a, b"):
        with_sensitivities(schedule, "c", 1)
