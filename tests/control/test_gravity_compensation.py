"""Gravity compensation: how far the tool gives way, by closed form and by polynomials, and what the law makes of it."""

from __future__ import annotations

from types import SimpleNamespace

import casadi as ca
import numpy as np
import pytest
from numpy.testing import assert_allclose

import gough as gk
from gough.control import elastic_map
from gough.control.bending import bends_of, shift_along, shift_at
from gough.control.bending_check import away, check_places, target_shift
from gough.control.computed_torque import ComputedTorque
from gough.control.elastic_map import exponents, fitted, given_way, products
from gough.control.gravity_compensation import GravityCompensation
from gough.control.pid import PID
from gough.control.shifted import shifted
from gough.control.wrapping import faded, ramp
from gough.declare import Shape
from gough.errors import ExperimentError, KinematicsError, WorkspaceError
from gough.frames import abc_of_rotation_np, rotation_of_abc_np, rotation_of_vector_np, rotation_vector_np
from gough.machine.elastic_drives import ElasticDrives
from gough.machine.vibration import small_motions
from gough.machine.workspace import random_poses
from gough.program import Line
from gough.simulate import tick

END = np.array([-0.315, 1.83, 0.55])
LEGGED = ["nist-octahedral", *(pytest.param(name, marks=pytest.mark.full) for name in ("eth-hexaglide", "ccu-3prs"))]


@pytest.fixture(scope="module")
def hybrid():
    m = gk.load_machine("ifma-hsm")
    return m.replace(drive=m.drive.perfect())


@pytest.mark.parametrize("name", LEGGED)
def test_legs_give_way_in_closed_form_as_newtons_method_on_the_exact_statics_says(name):
    m = gk.load_machine(name)
    bends, flexible = bends_of(m, 6, False), m.flexible()
    assert isinstance(bends, ElasticDrives)
    x = np.array([m.home, *random_poses(m, 3, np.random.default_rng(3))])
    for place, d in zip(x, shift_at(m, bends, x), strict=True):
        exact = away(m.forward_kinematics(flexible.targets(place), near=place), place)
        # f c' / 2 of f is left out: 1 kN and a compliance that changes by 1e-7 m/kN over a metre, 5e-5 of it
        assert_allclose(d, exact, rtol=0, atol=5e-5 * np.abs(exact).max() + 1e-13)


def test_products_of_polynomials_are_as_many_as_their_total_degree_allows_and_chebyshevs():
    assert len(exponents(3, 6)) == 84  # 9 over 3
    y = np.array([0.3, -0.7])
    found = dict(zip(exponents(2, 3), products(list(y), 3), strict=True))
    for (a, b), value in found.items():
        assert value == pytest.approx(np.cos(a * np.arccos(y[0])) * np.cos(b * np.arccos(y[1])), abs=1e-14)


@pytest.mark.full
def test_each_degree_brings_the_map_nearer_to_the_statics_and_the_sixth_to_a_micrometre(hybrid):
    flexible, places = hybrid.flexible(), random_poses(hybrid, 25, np.random.default_rng(8))
    places = places[fitted(flexible, 3, False).inside(places)]
    exact = np.array([hybrid.forward_kinematics(flexible.targets(x), near=x) - x for x in places])
    worst = [np.abs(fitted(flexible, degree, False).sag_at(places) - exact).max() for degree in (2, 3, 4, 5, 6)]
    assert (np.diff(worst) < 0).all()
    assert worst[-1] < 1e-6  # the law's default tolerance


@pytest.mark.full
def test_what_a_motion_bends_is_a_quadratic_form_of_the_force_of_any_motion(hybrid):
    """given_way() takes it apart by unit motions; here one motion in one piece, eq. (2)."""
    flexible, rng = hybrid.flexible(), np.random.default_rng(4)
    one = small_motions(flexible, END)
    parts = given_way(flexible, one, END)
    forces = elastic_map._forces(Shape(flexible))
    for _ in range(3):
        xd, xdd = rng.normal(size=3) * 2, rng.normal(size=3) * 20
        _, qd, qdd = hybrid.joint_motion(END, xd, xdd)
        v, vd = (np.concatenate([part, np.zeros(9)]) for part in (qd, qdd))
        there, back, rest = (forces(flexible.theta, one.z, *way) for way in ((v, vd), (-v, vd), (0 * v, 0 * v)))
        f = np.array((there + back) / 2 - rest).ravel()
        N = np.eye(12)[:, 3:]  # the joints are the first three velocities
        bent = -N @ np.linalg.solve(N.T @ one.K @ N, N.T @ f)
        told = parts @ np.concatenate([xdd, [xd[j] * xd[k] for j in range(3) for k in range(j, 3)]])
        assert_allclose(told, -(one.W.T @ bent)[:3], rtol=1e-8, atol=1e-12)


@pytest.mark.parametrize("name", ["nist-octahedral", pytest.param("ifma-hsm", marks=pytest.mark.full)])
def test_rates_of_the_displacement_are_those_of_its_differences_along_a_curve(name):
    m = gk.load_machine(name)
    bends = bends_of(m, 3, False)
    rng = np.random.default_rng(2)
    d = len(m.task)
    x0, a, b = m.home + 0.02, 0.3 * rng.normal(size=d), rng.normal(size=d)
    if d == 6:
        a[3:] = b[3:] = 0.0  # a curve of angles has no twist of its own here
    theta = ca.SX.sym("theta", len(bends.theta))
    x, xd, xdd = (ca.SX.sym(s, d) for s in ("x", "xd", "xdd"))
    f = ca.Function("d", [theta, x, xd, xdd], list(shift_along(m, bends, bends.at(theta), x, xd, xdd)))

    def at(t):
        parts = f(bends.theta, x0 + a * t + b * t * t / 2, a + b * t, b)
        return np.array([np.array(part).ravel() for part in parts])

    h = 1e-3
    before, now, after = at(-h), at(0.0), at(h)
    scale = np.abs(now).max(1)
    # h^2 / 6 of the next derivatives, that are as large as the first on the scale of a second
    assert_allclose((after[0] - before[0]) / (2 * h), now[1], atol=1e-4 * scale[1])
    assert_allclose((after[1] - before[1]) / (2 * h), now[2], atol=1e-4 * scale[2])


def test_a_shifted_reference_is_a_motion_of_its_own_twist_and_joints():
    """Its places differentiated give its rates, its joints are those of its poses, with a turn of 3 mrad."""
    m = gk.load_machine("nist-octahedral")
    p, theta = m.symbols
    rng = np.random.default_rng(1)
    x0, way = m.home + np.array([0.03, -0.02, 0.01, 0.05, -0.1, 0.2]), 0.1 * rng.normal(size=6)
    size, rate = np.array([1e-3] * 3 + [3e-3] * 3), rng.normal(size=6)

    def row(t):
        x = x0 + np.concatenate([way[:3] * t + way[:3] * t * t, np.zeros(3)])
        turn = rotation_of_abc_np(x0[3:])
        w = way[3:]  # a steady turn
        angle = np.linalg.norm(w) * t
        x[3:] = abc_of_rotation_np(rotation_of_vector_np(w / np.linalg.norm(w) * angle) @ turn)
        xd, xdd = np.concatenate([way[:3] * (1 + 2 * t), w]), np.concatenate([2 * way[:3], np.zeros(3)])
        d = [size * np.sin(rate * t + 1), size * rate * np.cos(rate * t + 1), -size * rate**2 * np.sin(rate * t + 1)]
        q = m.inverse_kinematics(x)
        return tick.rest_row(m, x)._replace(xd=xd, xdd=xdd, q=q), d

    def told(t):
        r, d = row(t)
        out = shifted(m, p, r, *(ca.SX(one) for one in d))
        f = ca.Function("r", [theta], [out.x, out.xd, out.xdd, out.q, out.qd, out.qdd])
        return [np.array(part).ravel() for part in f(m.theta)]

    h = 1e-4
    before, now, after = told(-h), told(0.0), told(h)
    assert_allclose(now[3], m.inverse_kinematics(now[0]), atol=1e-14)
    linear = (after[0][:3] - before[0][:3]) / (2 * h)
    turn = rotation_vector_np(rotation_of_abc_np(after[0][3:]) @ rotation_of_abc_np(before[0][3:]).T) / (2 * h)
    # |d_w|^2 of the rate is left out: 1e-5 of it, and a second derivative loses 1e-16 / h^2
    assert_allclose(np.concatenate([linear, turn]), now[1], atol=3e-7)
    assert_allclose((after[1] - before[1]) / (2 * h), now[2], atol=3e-6)
    assert_allclose((after[3] - before[3]) / (2 * h), now[4], atol=3e-7)
    assert_allclose((after[4] - before[4]) / (2 * h), now[5], atol=3e-6)


def test_the_ramp_has_two_continuous_derivatives_and_they_are_its_own():
    s = ca.SX.sym("s")
    f = ca.Function(
        "ramp", [s], [*ramp(s, 4.0), ca.jacobian(ramp(s, 4.0)[0], s) * 4, ca.jacobian(ramp(s, 4.0)[1], s) * 4]
    )
    for share in (0.1, 0.37, 0.9):
        value, rate, bend, slope, curve = (float(one) for one in f(share))
        assert (rate, bend) == pytest.approx((slope, curve))
    for share, end in ((-0.5, 0), (0, 0), (1, 1), (1.5, 1)):
        assert [float(one) for one in f(share)[:3]] == [end, 0, 0]


def test_a_product_of_a_ramp_and_a_displacement_has_the_rates_of_a_product():
    t = ca.SX.sym("t")
    w, d = ca.sin(t), ca.exp(2 * t)
    own = [(one, ca.jacobian(one, t), ca.jacobian(ca.jacobian(one, t), t)) for one in (w, d)]
    found = ca.vertcat(*faded(*own))
    whole = ca.vertcat(w * d, ca.jacobian(w * d, t), ca.jacobian(ca.jacobian(w * d, t), t))
    assert_allclose(np.array(ca.Function("f", [t], [found - whole])(0.3)), 0, atol=1e-14)


def test_near_the_target_the_weight_is_one_and_from_the_distance_on_none(hybrid):
    law = GravityCompensation(law=PID(bandwidth=5.0), where="target", target=END, distance=0.1).on(hybrid, 1e-3)
    theta = ca.SX.sym("theta", len(law.theta))
    x, xd, xdd = (ca.SX.sym(s, 3) for s in ("x", "xd", "xdd"))
    near = ca.Function("near", [theta, x, xd, xdd], list(law._near(law.at(theta), x, xd, xdd)))

    def at(way, v=(0, 0, 0), a=(0, 0, 0)):
        return [float(one) for one in near(law.theta, END + np.asarray(way), v, a)]

    assert at([0, 0, 0]) == [1, 0, 0]
    assert at([0, 0.1, 0]) == at([0.3, 0.1, 0]) == [0, 0, 0]
    v, a, h = np.array([0.4, -0.5, 0.1]), np.array([3.0, 1.0, -2.0]), 1e-5
    x0 = np.array([0.03, 0.02, -0.04])
    steps = [at(x0 + v * t + a * t * t / 2, v + a * t, a) for t in (-h, 0, h)]
    assert 0 < steps[1][0] < 1
    assert (steps[2][0] - steps[0][0]) / (2 * h) == pytest.approx(steps[1][1], rel=1e-6)
    assert (steps[2][1] - steps[0][1]) / (2 * h) == pytest.approx(steps[1][2], rel=1e-6)


def test_where_nothing_gives_way_the_law_is_the_one_inside_to_rounding(hybrid):
    inner = ComputedTorque(bandwidth=10.0)
    law = GravityCompensation(law=inner, where="target", target=END).on(hybrid, 1e-3)
    law = law.replace(aside=np.zeros(3))
    r = tick.rest_row(hybrid, END)._replace(xd=np.array([0.1, 0.2, -0.3]), xdd=np.array([1.0, 2.0, 3.0]))
    r = r._replace(**dict(zip(("q", "qd", "qdd"), hybrid.joint_motion(r.x, r.xd, r.xdd), strict=True)))
    u0 = hybrid.inverse_dynamics(END, *np.zeros((2, 3)))
    y = SimpleNamespace(q=r.q - 1e-5, u=u0)
    state = law.init(r, u0)._replace(clock=np.array([0.2]))

    def force(one, state):
        theta = ca.SX.sym("theta", len(one.theta))
        return np.array(ca.Function("u", [theta], [one.step(state, r, y, theta)[0].u])(one.theta)).ravel()

    alone = inner.on(hybrid, 1e-3)
    assert_allclose(force(law, state), force(alone, alone.init(r, u0)), rtol=1e-11)


@pytest.mark.full
@pytest.mark.parametrize("where", ["target", "path"])
def test_the_tool_of_the_flexible_machine_stands_within_a_micrometre_of_its_target(hybrid, where):
    way = np.array([-0.05, 0.05, 0.05])
    target = hybrid.home + way
    law = GravityCompensation(
        law=ComputedTorque(bandwidth=20.0), where=where, target=target if where == "target" else None
    )
    program = Line(to=way, feed=0.5, acceleration=5.0, lead_in=0.2, settle=0.6)
    plant = gk.Plant(machine=hybrid, flexible=True)
    logs = [gk.simulate(hybrid, one, program, plant=plant, period=2e-4) for one in (law.law, law)]
    off = [np.abs((log.dataset.x - log.dataset.x_r).values[-50:, :3]).max() for log in logs]
    assert off[0] > 30e-6  # the sag
    assert off[1] < 1e-6


@pytest.mark.full
def test_a_legged_machine_is_compensated_along_its_path_to_a_tenth_of_a_micrometre():
    m = gk.load_machine("nist-octahedral").frictionless()
    m = m.replace(drive=m.drive.perfect())
    program = Line(to=np.array([0.02, 0.01, 0.0]), feed=0.1, settle=0.3)
    off = []
    for law in (ComputedTorque(bandwidth=10.0), GravityCompensation(law=ComputedTorque(bandwidth=10.0), takeover=0.1)):
        log = gk.simulate(m, law, program, plant=gk.Plant(machine=m, flexible=True), period=2.5e-4)
        off.append(np.abs((log.dataset.x - log.dataset.x_r).values[-1, :3]).max())
    assert off[0] > 5e-6
    assert off[1] < 1e-7


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"where": "target"}, "target: belong together"),
        ({"target": END}, "target: belong together"),
        ({"law": None}, "law"),
        ({"degree": 0}, "degree"),
    ],
)
def test_what_is_wrong_with_the_law_is_said(options, text):
    with pytest.raises(ExperimentError, match=text):
        GravityCompensation(**{"law": PID(bandwidth=5.0), **options})


def test_a_machine_that_gives_way_nowhere_is_refused_by_name(hybrid):
    with pytest.raises(ExperimentError, match=r"ifma-hsm has no \[\[compliance\]\]"):
        GravityCompensation(law=PID(bandwidth=5.0)).on(hybrid.replace(compliance=None), 1e-3)


def test_a_target_of_other_coordinates_is_refused(hybrid):
    with pytest.raises(ExperimentError, match="target: must have as many numbers as the task of the machine, got 2"):
        target_shift(hybrid, np.zeros(2))


@pytest.mark.full
def test_a_target_that_gravity_keeps_the_joints_from_is_refused_by_name(hybrid):
    soft = hybrid.replace(compliance=[one.replace(stiffness=one.stiffness * 2e-3) for one in hybrid.compliance])
    with pytest.raises((WorkspaceError, KinematicsError), match="under gravity"):
        target_shift(soft, END)


@pytest.mark.full
def test_polynomials_that_miss_the_statics_are_refused_with_what_is_left(hybrid):
    law = GravityCompensation(law=PID(bandwidth=5.0), degree=1).on(hybrid, 1e-3)
    motion = Line(to=np.array([-0.3, 0.6, 0.5]), feed=1.0).plan(hybrid)
    with pytest.raises(KinematicsError, match=r"no convergence to the exact statics.*m left.*tolerance 1e-06 m"):
        law.check_motion(motion, 1e-3)
    assert check_places(hybrid, law.bends, motion, 1e-3, 1.0) > 1e-6
    outside = Line(to=np.array([0.6, 0.0, 0.0]), feed=1.0).plan(hybrid)
    with pytest.raises(WorkspaceError, match="outside of the places for which gravity is known"):
        law.check_motion(outside, 1e-3)
