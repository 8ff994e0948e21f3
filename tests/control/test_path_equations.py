"""Contour errors from equations: the forms of a conic, the path's own frame, and motions that do not fit."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest
from numpy.testing import assert_allclose

import gough as gk
from gough.control.path_equations import Conic, Frame, PathEquations, carried, frame_at, local, second_order
from gough.errors import ExperimentError, InputError

CENTER = [0.01, -0.02, 0.3]


def evaluated(conic, p):
    """F and F_p at points (n, 3)."""
    tip = ca.SX.sym("tip", 3)
    F = conic.equations(conic, tip)
    f = ca.Function("F", [tip], [F, ca.jacobian(F, tip)]).map(len(p))
    F, F_p = (np.array(out) for out in f(p.T))
    return F.T, F_p.reshape(2, len(p), 3).transpose(1, 0, 2)


def ellipse(a, b, phi):
    return np.stack([CENTER[0] + a * np.cos(phi), CENTER[1] + b * np.sin(phi), np.full(len(phi), CENTER[2])], -1)


def test_the_area_form_of_a_circle_is_that_of_the_paper():
    p = np.random.default_rng(0).normal(size=(50, 3)) * 0.1
    F, _ = evaluated(Conic(center=CENTER, semi=[0.05, 0.05], form="area"), p)
    X, Y, Z = (p - CENTER).T
    assert_allclose(F[:, 0], X**2 + Y**2 - 0.05**2, rtol=0, atol=1e-16)
    assert_allclose(F[:, 1], Z, rtol=0, atol=1e-16)


def test_forms_differ_by_factors_and_vanish_on_the_same_points():
    phi = np.linspace(0, 6, 40)
    on, off = ellipse(0.05, 0.03, phi), ellipse(0.052, 0.033, phi)
    found = {form: evaluated(Conic(center=CENTER, semi=[0.05, 0.03], form=form), off)[0][:, 0]
             for form in ("dimensionless", "area", "distance")}  # fmt: skip
    assert_allclose(found["area"], found["dimensionless"] * 0.05 * 0.03, rtol=1e-12)
    assert (found["distance"] > 0).all() and np.ptp(found["distance"] / found["area"]) > 1
    for form in found:
        assert np.abs(evaluated(Conic(center=CENTER, semi=[0.05, 0.03], form=form), on)[0]).max() < 1e-15


def test_the_distance_form_has_gradient_one_and_is_the_distance_to_first_order():
    phi = np.linspace(0, 6, 40)
    conic, on = Conic(center=CENTER, semi=[0.05, 0.03], form="distance"), ellipse(0.05, 0.03, phi)
    _, F_p = evaluated(conic, on)
    assert_allclose(np.linalg.norm(F_p[:, 0], axis=1), 1, rtol=0, atol=1e-14)
    for step in (1e-4, 5e-5):  # outside +
        F, _ = evaluated(conic, on + step * F_p[:, 0])
        # f / |f_p| is off by the square of the step times half the sharpest curvature, 56 1/m, and |f_pp| as much
        assert np.abs(F[:, 0] - step).max() < 60 * step**2


def test_second_derivatives_are_those_along_a_motion():
    rng, tip, h = np.random.default_rng(3), ca.SX.sym("tip", 3), 3e-4
    conic = Conic(center=CENTER, semi=[0.05, 0.03], form="distance")
    F = conic.equations(conic, tip)
    p0, v, a = ellipse(0.05, 0.03, np.array([0.7]))[0] + 1e-3, rng.normal(size=3) * 0.3, rng.normal(size=3) * 2
    E = second_order(F, tip, ca.DM(p0), ca.DM(v))
    rate, drift, gradient = (np.array(ca.DM(ca.evalf(part))) for part in E[1:])
    f = ca.Function("F", [tip], [F])
    near = np.array([np.array(f(p0 + k * h * v + (k * h) ** 2 / 2 * a)).ravel() for k in range(-3, 4)])
    first = np.tensordot(np.array([-1, 9, -45, 0, 45, -9, 1]) / 60 / h, near, 1)
    second = np.tensordot(np.array([2, -27, 270, -490, 270, -27, 2]) / 180 / h**2, near, 1)
    # h^6 times the 7th and 8th derivatives of what turns at some 20 rad/s: 7e-22 x 1e9 x 0.1
    assert_allclose(rate.ravel(), first, rtol=0, atol=1e-10)
    assert_allclose(drift.ravel() + gradient @ a, second, rtol=0, atol=1e-7)


# -- the path's own frame -----------------------------------------------------------------------------------------


def carry(tangents):
    frame, out = frame_at(tangents[0]), []
    t, m1, m2, new = (ca.SX.sym(name, 3) for name in "tmno")
    step = ca.Function("step", [t, m1, m2, new], [*carried(Frame(t, m1, m2), new)])
    for tangent in tangents:
        frame = Frame(*(np.array(part).ravel() for part in step(*frame, tangent)))
        out.append(np.array(frame))
    return np.array(out)


def test_the_frame_stays_square_and_turns_with_a_plane_curve_as_the_curve_does():
    phi = np.linspace(0, 30, 3001)
    tangents = np.stack([np.cos(phi), np.sin(phi), 0 * phi], -1)
    frames = carry(tangents)
    assert_allclose(frames @ np.swapaxes(frames, 1, 2), np.broadcast_to(np.eye(3), (3001, 3, 3)), rtol=0, atol=1e-14)
    normal = np.stack([-np.sin(phi), np.cos(phi), 0 * phi], -1)
    along = np.einsum("kij,kj->ki", frames, normal)
    assert_allclose(along, np.broadcast_to(along[0], along.shape), rtol=0, atol=1e-12)


def test_the_frame_has_no_jump_where_a_curve_bends_the_other_way_or_the_path_turns_back():
    phi = np.concatenate([np.linspace(0, 1, 200), np.linspace(1, 0, 200)])
    tangents = np.stack([np.cos(phi), np.sin(phi), 0 * phi], -1)
    across = carry(tangents)[:, 1:]
    assert np.abs(np.diff(across, axis=0)).max() < 0.01
    back = carry(np.array([[1.0, 0, 0], [1.0, 0, 0], [-1.0, 0, 0], [-1.0, 0, 0]]))
    assert_allclose(back[2, 1], back[1, 1], rtol=0, atol=1e-15)


def test_at_rest_without_a_direction_the_frame_stays():
    frames = carry(np.array([[0, 1.0, 0], [0, 0, 0], [0, 0, 0]]))
    assert_allclose(frames[2], frames[0], rtol=0, atol=1e-15)


def test_the_local_errors_vanish_on_the_touching_circle_and_are_its_distance_to_first_order():
    radius, angle = 0.04, np.linspace(-0.4, 0.4, 9)
    p_r, t, n = np.zeros(3), np.array([1.0, 0, 0]), np.array([0, 1.0, 0])
    tip = ca.SX.sym("tip", 3)
    frame = Frame(*(ca.SX(ca.DM(part)) for part in (t, np.array([0, 0, 1.0]), -n)))
    f = ca.Function("F", [tip], [local(tip, frame, ca.SX(ca.DM(p_r)), ca.SX(ca.DM(n / radius)))])
    for a in angle:
        for outward in (0.0, 1e-5):
            p = radius * n + (radius + outward) * np.array([np.sin(a), -np.cos(a), 0])
            found = np.array(f(p + [0, 0, 2e-5])).ravel()
            # m_2 = -n points outward; (r + o)^2 / 2 r - r / 2 = o + o^2 / 2 r, and as much of the height
            assert found[0] == pytest.approx(2e-5, abs=1e-18)
            assert found[1] == pytest.approx(outward, abs=(outward**2 + 4e-10) / radius)


# -- what is refused ----------------------------------------------------------------------------------------------


class Squared(PathEquations):
    """A circle whose equation has no gradient on it."""

    def equations(self, view, p):
        return ca.vertcat((p[0] ** 2 + (p[1] - 0.1745) ** 2 - 0.05**2) ** 2, p[2] + 1.4)


class Twice(PathEquations):
    """Two equations that say the same."""

    def equations(self, view, p):
        F = p[0] ** 2 + (p[1] - 0.1745) ** 2 - 0.05**2
        return ca.vertcat(F, 3 * F)


CIRCLE = gk.Circle(radius=0.05, feed=0.1)
ON = {"center": [-0.05, 0.1745, -1.4], "semi": [0.05, 0.05]}


@pytest.fixture(scope="module")
def ccu():
    return gk.load_machine("ccu-3prs")


def refused(ccu, law, program=CIRCLE):
    with pytest.raises(ExperimentError) as caught:
        law.on(ccu, 1e-3).check_motion(program.plan(ccu), 1e-3)
    return caught.value.problems[0]


def placed(ccu):
    """The circle about the machine's home."""
    return gk.Circle(radius=0.05, feed=0.1, origin=[*ccu.home, 0.0, 0.0, 0.0])


def test_equations_without_a_gradient_on_the_path_are_refused_with_the_time(ccu):
    problem = refused(ccu, gk.EquivalentError(path=Squared()), placed(ccu))
    assert problem.key == "path" and problem.where.startswith("t = 0 s")
    assert problem.rule == "equation 1 of the path is degenerate here: it has no gradient"


def test_two_equations_that_say_the_same_are_refused(ccu):
    problem = refused(ccu, gk.EquivalentError(path=Twice()), placed(ccu))
    assert "lie in one plane" in problem.rule and problem.value.startswith("volume")


def test_equations_of_another_path_are_refused_with_how_far_it_is_off(ccu):
    wrong = Conic(center=[0.0, 0.1745, -1.4], semi=[0.05, 0.048])
    problem = refused(ccu, gk.EquivalentError(path=wrong), placed(ccu))
    assert problem.rule == "equation 1 of the path does not hold on the programmed path" and problem.limit == "1e-06 m"


def test_the_papers_tangential_error_is_refused_where_the_reference_rests(ccu):
    good = Conic(center=[0.0, 0.1745, -1.4], semi=[0.05, 0.05])
    problem = refused(ccu, gk.EquivalentError(path=good, tangential="power"), placed(ccu))
    assert problem.rule == "the tangential error is degenerate here: the reference rests"
    assert problem.cure == 'tangential = "distance"' and problem.where == "t = 0 s"


def test_equations_of_the_programmed_path_are_accepted(ccu):
    good = Conic(center=[0.0, 0.1745, -1.4], semi=[0.05, 0.05])
    gk.EquivalentError(path=good).on(ccu, 1e-3).check_motion(placed(ccu).plan(ccu), 1e-3)


def test_axes_that_are_not_square_are_refused():
    with pytest.raises(InputError, match="both axes must have length 1 and be square to each other"):
        Conic(center=CENTER, semi=[0.05, 0.05], second=[1.0, 0.0, 0.0])
