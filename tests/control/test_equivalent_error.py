"""Equivalent errors: the error dynamics, the law that inverts them, and what is estimated of dependent coordinates."""

from __future__ import annotations

from functools import lru_cache

import casadi as ca
import numpy as np
import pytest
from numpy.testing import assert_allclose

import gough as gk
from gough.control.base import Measurement
from gough.control.equivalent_error import EquivalentError
from gough.control.path_equations import Conic, frame_at
from gough.errors import ExperimentError
from gough.kernel.pack import flatten
from gough.machine.workspace import random_poses
from gough.observe import forward

PERIOD = 1e-3
NAMES = ["ccu-3prs", "nist-octahedral", "eth-hexaglide"]
load = lru_cache(gk.load_machine)


def circle(machine):
    return gk.Circle(radius=0.05, feed=0.3, origin=[*machine.home[:3], 0.0, 0.0, 0.0], center=[0.0, 0.0, 0.0])


def conic(machine, form="area"):
    return Conic(center=machine.home[:3], semi=[0.05, 0.05], form=form)


LAWS = {
    "local": lambda m: EquivalentError(bumpless=False),
    "conic": lambda m: EquivalentError(path=conic(m), tangential="power", bumpless=False, strength=26.0, boundary=0.1),
    "linear": lambda m: EquivalentError(coordinates="linear", bumpless=False),
}


@pytest.fixture(params=NAMES, scope="module")
def machine(request):
    return load(request.param)


@pytest.fixture(params=LAWS, scope="module")
def law(request, machine):
    return LAWS[request.param](machine).on(machine, PERIOD)


@pytest.fixture(scope="module")
def rows(machine):
    """The reference at constant feed, and its sample period."""
    motion = circle(machine).plan(machine)
    k = round(0.5 * motion.duration / 1e-3)
    table = motion.sample(k - 8, k + 9, 1e-3)
    return [type(table)(*(column[i] for column in table)) for i in range(17)]


def state_near(machine, row, rng):
    """Coordinates and velocities some micrometres and mm/s beside the reference."""
    d = len(machine.task)
    x = row.x + rng.normal(size=d) * 5e-6
    xd = row.xd + rng.normal(size=d) * 5e-3
    speed = np.linalg.solve(machine.velocity_jacobian(x), machine.jacobian(x) @ xd)
    return x, xd, machine.coordinates(x), speed


@pytest.mark.quick("*-nist-octahedral")
def test_error_dynamics_have_at_most_20000_operations(law, rows):
    assert law.error_dynamics(rows[0]).n_instructions() <= 20_000


@pytest.mark.quick("linear-ccu-3prs", "local-nist-octahedral", "conic-eth-hexaglide")
def test_the_errors_change_as_their_dynamics_say(law, machine, rows):
    """E along the machine's own motion under constant forces, by differences, against W + G u.

    What is left out is of the order of the distance to the reference, 10 um, times the change of the path, 36 1/s2,
    where the local frame is used; with the equations of the path nothing is.
    """
    rng, dynamics, mid = np.random.default_rng(5), law.error_dynamics(rows[0]), 8
    x, xd, z, v = state_near(machine, rows[mid], rng)
    u = machine.inverse_dynamics(x, xd, rows[mid].xdd + rng.normal(size=len(x)) * 0.1)
    frame = flatten(frame_at(rows[mid].tangent))
    before = (rows[mid].xdd[:3] - PERIOD * jerk_of(rows, mid)).ravel()
    W, G, _, rate = (np.array(out) for out in dynamics(law.theta, z, v, flatten(rows[mid]), frame, before))
    E = []
    motion = moved(machine, x, xd, u)
    for k in range(-3, 4):
        row = rows[mid + k]
        at, speed = motion(k * 1e-3)
        turned = flatten(turned_frame(frame, rows[mid].tangent, row.tangent))
        V = np.linalg.solve(machine.velocity_jacobian(at), machine.jacobian(at) @ speed)
        out = dynamics(law.theta, machine.coordinates(at), V, flatten(row), turned, row.xdd[:3])
        E.append(np.array(out[2]).ravel())
    first = np.tensordot(np.array([-1, 9, -45, 0, 45, -9, 1]) / 60 / 1e-3, E, 1)
    second = np.tensordot(np.array([2, -27, 270, -490, 270, -27, 2]) / 180 / 1e-6, E, 1)
    assert_allclose(rate.ravel(), first, rtol=0, atol=2e-6)
    assert_allclose((W + G @ u[:, None]).ravel(), second, rtol=0, atol=2e-3)
    assert np.abs(second).max() > 0.02


def jerk_of(rows, k):
    return (rows[k + 1].xdd[:3] - rows[k - 1].xdd[:3]) / (2 * PERIOD)


def moved(machine, x, xd, u):
    """Poses and task rates under constant forces u, forwards and backwards: RK4 of forward dynamics in a b c."""
    from gough.frames import abc_rate_matrix_np

    d = len(x)

    def rate(x, xd):
        speed = xd.copy()
        if d == 6:
            speed[3:] = np.linalg.solve(abc_rate_matrix_np(x[3:]), xd[3:])
        return speed, machine.forward_dynamics(x, xd, u)

    def at(t):
        y, s, h = x.copy(), xd.copy(), t / 8
        for _ in range(8):
            k1 = rate(y, s)
            k2 = rate(y + h / 2 * k1[0], s + h / 2 * k1[1])
            k3 = rate(y + h / 2 * k2[0], s + h / 2 * k2[1])
            k4 = rate(y + h * k3[0], s + h * k3[1])
            y = y + h / 6 * (k1[0] + 2 * k2[0] + 2 * k3[0] + k4[0])
            s = s + h / 6 * (k1[1] + 2 * k2[1] + 2 * k3[1] + k4[1])
        return y, s

    return at


def turned_frame(flat, t_old, t_new):
    """A plane path: the frame turned as the tangent turns."""
    axis, c = np.cross(t_old, t_new), t_old @ t_new
    K = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    R = np.eye(3) + K + K @ K / (1 + c)
    return type(frame_at(np.zeros(3)))(*(R @ flat[k : k + 3] for k in (0, 3, 6)))


@pytest.mark.quick("linear-eth-hexaglide", "local-nist-octahedral", "conic-nist-octahedral")
def test_the_command_is_what_inverting_the_error_dynamics_gives(law, machine, rows):
    """u = G^-1 (-W - b E' - c E - K sat(s / delta)), eq. (9), without the inverse dynamics that the law uses."""
    rng, row = np.random.default_rng(9), rows[8]
    x, _, z, v = state_near(machine, row, rng)
    q = machine.inverse_kinematics(x)
    qd = machine.velocity_jacobian(x) @ v
    state = law.init(row, np.zeros(machine.joints_count))
    integral = rng.normal(size=len(machine.task)) * 1e-6
    state = state._replace(joints=q - qd * PERIOD, before=q - 2 * qd * PERIOD, integral=integral)
    if law.coordinates == "linear":
        z = np.array(ca.DM(ca.evalf(linear_estimate(machine, row, q)))).ravel()
    theta = ca.SX.sym("theta", len(law.theta))
    command, _ = law.step(state, row, Measurement(q, np.zeros(machine.joints_count)), theta)
    u = np.array(ca.Function("u", [theta], [command.u])(law.theta)).ravel()
    J = np.array(ca.DM(ca.evalf(machine.jacobian_of(machine.at(ca.SX(ca.DM(machine.theta))), ca.SX(ca.DM(z))))))
    out = law.error_dynamics(row)(
        law.theta, z, np.linalg.solve(J, qd), flatten(row), flatten(frame_at(row.tangent)), state.change
    )
    W, G, E, Ed = (np.array(part) for part in out)
    s = Ed.ravel() + law.damping * E.ravel() + law.stiffness * integral
    wanted = -law.damping * Ed.ravel() - law.stiffness * E.ravel() - law.strength * np.clip(s / law.boundary, -1, 1)
    assert_allclose(u, np.linalg.solve(G, wanted - W.ravel()), rtol=0, atol=1e-7 * np.abs(u).max())


def linear_estimate(machine, row, q):
    p = machine.at(ca.SX(ca.DM(machine.theta)))
    z_r = ca.SX(ca.DM(machine.coordinates(row.x)))
    return machine.stepped(z_r, machine.newton_step(p, z_r, ca.SX(ca.DM(q))))


def test_the_linear_estimate_is_that_of_the_paper_and_its_error_falls_with_the_square_of_the_distance():
    """b^ = b_r - phi_b^-1 phi_a (a - a_r), eqs. (18)-(20), against the exact Newton solution."""
    m, rng = load("ccu-3prs"), np.random.default_rng(2)
    x_r = random_poses(m, 40, rng)
    way = rng.normal(size=(40, 3))
    p, theta = m.symbols
    z = ca.SX.sym("z", 6)
    c = m.closed(p, z)
    gains = ca.Function("gains", [theta, z], [c.phi_a, c.phi_b])
    worst = []
    for size in (1e-3, 5e-4):
        off = []
        for row, d in zip(x_r, size * way / np.linalg.norm(way, axis=1)[:, None], strict=True):
            exact, z_r = m.coordinates(row + d), m.coordinates(row)
            A_1, A_2 = (np.array(part) for part in gains(m.theta, z_r))
            paper = z_r[3:] - np.linalg.solve(A_2, A_1 @ (exact[:3] - z_r[:3]))
            row_r = type("Row", (), {"x": row})
            found = np.array(ca.DM(ca.evalf(linear_estimate(m, row_r, exact[:3])))).ravel()
            assert_allclose(found[3:], paper, rtol=0, atol=1e-13)
            off.append(np.abs(found[3:] - exact[3:]).max())
        worst.append(max(off))
    assert worst[0] / worst[1] == pytest.approx(4, rel=0.02)
    assert worst[0] < 1e-5  # rad, of 1 mm


@pytest.mark.full
def test_contour_errors_know_nothing_of_the_tangential_error():
    """A tool that starts 0.2 mm ahead on the path comes back along it: it overshoots, its integral returns to zero."""
    m = load("ccu-3prs")
    m = m.replace(drive=m.drive.perfect())
    place = {"origin": [*m.home, 0.0, 0.0, 0.0], "center": [0.0, 0.0, 0.0]}
    program = gk.Circle(radius=0.05, feed=0.1, start=0.3, lead_in=0.3, **place)
    first = program.sample(1e-3, m).x[0]
    along = 0.3 + 2e-4 / 0.05  # ahead by 0.2 mm
    there = m.home + 0.05 * np.array([np.cos(along), np.sin(along), 0.0])
    plant = gk.Plant(machine=m, offset=there - first)
    log = gk.simulate(m, EquivalentError(path=conic(m, "distance")), program, plant=plant)
    assert abs(log["lag"][0] + 2e-4) < 1e-6 and abs(log["lag"][290]) < 1e-7
    d = (log["x"] - m.home)[log.t < 0.3]
    # of 0.2 mm along the path: what the sample time leaves of the changing speed
    assert np.abs(np.hypot(d[:, 0], d[:, 1]) - 0.05).max() < 2e-8 and np.abs(d[:, 2]).max() < 2e-8


@pytest.mark.full
def test_without_a_bump_the_weight_that_the_model_does_not_know_is_held_and_without_it_falls():
    m = load("ccu-3prs")
    heavy = gk.Plant(machine=m.replace(**{"platform.mass": 60.0}))
    still = gk.Circle(radius=0.02, feed=0.02, lead_in=0.2)
    falls = {}
    for bumpless in (True, False):
        log = gk.simulate(m, EquivalentError(bumpless=bumpless), still, plant=heavy)
        falls[bumpless] = np.abs(log["x"] - log["x_r"])[log.t < 0.2].max()
    assert falls[True] < 2e-7 and falls[False] > 2e-6


def test_a_boundary_layer_too_thin_for_the_period_is_refused():
    m = load("ccu-3prs")
    with pytest.raises(ExperimentError, match=r"too long for the boundary layer, got b \+ K / delta = 2640 1/s"):
        EquivalentError(boundary=0.1).on(m, 1e-3)
    with pytest.raises(ExperimentError, match="must be one value or 3"):
        EquivalentError(strength=[1.0, 2.0]).on(m, 1e-3)


def test_the_observer_of_both_estimates_meets_the_exact_coordinates():
    m, x = load("ccu-3prs"), load("ccu-3prs").home + [0.03, -0.02, 0.01]
    p = m.at(ca.SX(ca.DM(m.theta)))
    z, _, _ = forward.estimate(m, p, forward.Pose(ca.SX(ca.DM(m.coordinates(m.home + [0.0299, -0.02, 0.01])))),
                               ca.SX(ca.DM(m.inverse_kinematics(x))), 1e-3)  # fmt: skip
    assert_allclose(np.array(ca.DM(ca.evalf(z))).ravel(), m.coordinates(x), rtol=0, atol=1e-12)
