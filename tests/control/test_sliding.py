"""The adaptive laws: limit cases, what is learned and what is not, and what they refuse."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

import gough as gk
from gough.control.base import Measurement
from gough.errors import ExperimentError, InputError
from gough.kernel.pack import flatten, unflatten
from gough.simulate import tick

PERIOD = 1e-3
NINE = [
    "drive.inertia",
    "friction.viscous_offset",
    "platform.mass",
    "strut.moving.mass",
    "strut.fixed.mass",
    "strut.moving.transverse + strut.fixed.transverse",
    "platform.inertia[0,0]",
    "platform.inertia[1,1]",
    "platform.inertia[2,2]",
]


@pytest.fixture(scope="module")
def nist():
    return gk.load_machine("nist-octahedral")


def scaled(machine, factor):
    """The machine with all its masses, inertias and friction times `factor`."""
    keys = ["platform.mass", "platform.inertia", "drive.inertia"]
    keys += [f"strut.{part}.{key}" for part in ("moving", "fixed") for key in ("mass", "transverse")]
    keys += [f"friction.{key}" for key in ("coulomb", "static", "viscous", "viscous_offset")]
    return machine.replace_from_file(dict.fromkeys(keys, f"{factor} x"))


def stepped(law, state, r, y):
    theta = ca.SX.sym("theta", len(law.theta))
    command, after = law.step(state, r, y, theta)
    outputs = [ca.SX(command.u), ca.SX(flatten(unflatten(state, ca.SX(flatten(after)))))]
    u, after = ca.Function("step", [theta], outputs)(law.theta)
    return np.array(u).ravel(), unflatten(state, np.array(after).ravel())


def moving(machine, law, seed=0):
    """Law, state, reference and measurement on a motion with an error: the pose of the sample before is known."""
    rng = np.random.default_rng(seed)
    x = machine.home + rng.normal(size=6) * [0.05, 0.05, 0.02, 0.05, 0.05, 0.05]
    twist = rng.normal(size=6) * [0.1, 0.1, 0.1, 0.2, 0.2, 0.2]
    rest = tick.rest_row(machine, x)
    u0 = machine.inverse_dynamics(x, np.zeros(6), np.zeros(6))
    state = law.init(rest, u0)._replace(started=np.zeros(6))
    z0 = state.observer.pose
    z1 = np.array(ca.DM(machine.normalised(machine, machine.stepped(ca.DM(z0), ca.DM(twist * law.period))))).ravel()
    p = machine  # numbers in the places of symbols
    q1 = np.array(ca.evalf(ca.SX(machine.joints_of(p, ca.SX(ca.DM(z1)))))).ravel()
    x_r = x + np.concatenate([twist[:3] * law.period, np.zeros(3)]) + rng.normal(size=6) * 1e-4
    xd, xdd = twist + rng.normal(size=6) * 1e-2, rng.normal(size=6)
    _, qd, qdd = machine.joint_motion(x_r, xd, xdd)
    r = rest._replace(x=x_r, xd=xd, xdd=xdd, qd=qd, qdd=qdd)
    return state, r, Measurement(q1, np.zeros(6)), z1, twist


def number(machine, expression):
    return np.array(ca.evalf(ca.SX(expression)))


@pytest.mark.full
def test_without_learning_and_sliding_it_is_computed_torque(nist):
    """docs/theory/sliding.md, the last section: K_D = k M(z) gives the gains L + k and k L, plus C(V) sigma."""
    machine = nist.replace(**{"friction.coulomb": 1e-12, "friction.static": 1e-12, "friction.viscous": 0.0})
    machine = machine.replace(**{"friction.viscous_offset": 0.0})
    slope, k = 90.0, 250.0
    for seed in range(5):
        law = gk.RobustAdaptive(slope=slope, damping=1.0, inertia_rate=0.0, coulomb_rate=0.0, viscous_rate=0.0).on(
            machine, PERIOD
        )
        state, r, y, z, V = moving(machine, law, seed)
        pi = {key: value for key, (value, _) in machine.inertial(machine).items()}
        zs, Vs = ca.SX(ca.DM(z)), ca.SX(ca.DM(V))
        M, h = (number(machine, e) for e in machine.mass_and_bias(machine, pi, zs, Vs))
        M = (M + M.T) / 2
        law = law.replace(K_D=k * M)
        u, _ = stepped(law, state, r, y)

        e = number(machine, machine.target(machine, r._replace(x=ca.SX(ca.DM(r.x))), zs)[0]).ravel()
        sigma = r.xd + slope * e - V
        a = r.xdd + (slope + k) * (r.xd - V) + k * slope * e
        J = number(machine, machine.jacobian_of(machine, zs))
        zero = ca.SX(6, 1)
        C_sigma = machine.passive_force(machine, pi, zs, Vs, ca.SX(ca.DM(sigma)), zero) - machine.passive_force(
            machine, pi, zs, Vs, zero, zero
        )
        computed_torque = np.linalg.solve(J.T, M @ a + h.ravel())
        rest = u - computed_torque - np.linalg.solve(J.T, number(machine, C_sigma).ravel())
        # 1e-8: the residual of the estimate's two Newton steps, 1e-14 m, over the period, times K_D
        assert np.abs(rest).max() < 1e-8 * np.abs(u).max()
        assert np.abs(u - computed_torque).max() > 1e-6 * np.abs(u).max()  # C(V) sigma is there


def test_the_nine_parameters_of_the_paper_are_all_there_are(nist):
    """f = sum of theta_j df/dtheta_j: with all nine scaled, the whole force scales, so none was forgotten."""
    law = gk.RobustAdaptive(slope=100.0, damping=300.0).on(nist, PERIOD)
    assert law.adapt == NINE
    theta, factors = ca.SX.sym("theta", len(law.theta)), ca.SX.sym("factors", 9)
    z, V, V_s, A_s = (ca.SX.sym(name, n) for name, n in (("z", 7), ("V", 6), ("V_s", 6), ("A_s", 6)))
    f = law._force(law._believed(theta, factors), z, nist.jacobian_of(law.at(theta).machine, z), V, V_s, A_s)
    found = ca.Function("f", [theta, factors, z, V, V_s, A_s], [f, ca.jacobian(f, factors)])
    rng = np.random.default_rng(1)
    for _ in range(10):
        z0 = np.concatenate([rng.normal(size=3) * 0.1, [1.0, *rng.normal(size=3) * 0.1]])
        z0[3:] /= np.linalg.norm(z0[3:])
        given = rng.uniform(0.5, 1.5, 9)
        force, Y = (np.array(x) for x in found(law.theta, given, z0, *rng.normal(size=(3, 6))))
        assert np.abs(force.ravel() - Y @ given).max() < 1e-12 * np.abs(Y).max()


@pytest.mark.full
def test_what_is_learned_is_the_power_of_the_error(nist):
    """theta' = g d(sigma' f)/dtheta, by differences of the law's own force."""
    law = gk.RobustAdaptive(slope=100.0, damping=300.0, regressor="actual", inertia_rate=0.5).on(nist, PERIOD)
    state, r, y, z, V = moving(nist, law, 3)
    u, after = stepped(law, state, r, y)
    J = number(nist, nist.jacobian_of(nist, ca.SX(ca.DM(z))))
    sigma = (
        r.xd + 100.0 * number(nist, nist.target(nist, r._replace(x=ca.SX(ca.DM(r.x))), ca.SX(ca.DM(z)))[0]).ravel() - V
    )
    still = r._replace(qd=np.zeros(6))  # friction's normal force follows the estimates too, but is no part of f
    for j in range(9):
        h = 1e-4 * (np.arange(9) == j)
        more, less = (stepped(law, state._replace(parameters=state.parameters + d), still, y)[0] for d in (h, -h))
        difference = sigma @ J.T @ (more - less) / 2e-4
        learned = (after.parameters - state.parameters)[j] / (0.5 * PERIOD)
        assert learned == pytest.approx(difference, rel=1e-5, abs=1e-7)


def test_the_drives_viscous_friction_is_pushed_through_and_learned_from_the_power_it_takes(nist):
    """The terms J' F_v J V_s of (7) and, at the reference's motion, of (11): friction takes F_v q' in each joint."""
    more = nist.replace(**{"friction.viscous_offset": nist.friction.viscous_offset + 50.0})
    law, heavy = (gk.RobustAdaptive(slope=100.0, damping=300.0, inertia_rate=0.5).on(m, PERIOD) for m in (nist, more))
    state, r, y, z, V = moving(nist, law, 5)
    (u, after), (u_more, _) = stepped(law, state, r, y), stepped(heavy, state, r, y)
    J = number(nist, nist.jacobian_of(nist, ca.SX(ca.DM(z))))
    e = number(nist, nist.target(nist, r._replace(x=ca.SX(ca.DM(r.x))), ca.SX(ca.DM(z)))[0]).ravel()
    V_s = r.xd + 100.0 * e
    # 1e-9: the residual of the estimate's two Newton steps, 1e-14 m, times the slope, and rounding of u
    np.testing.assert_allclose(u_more - u, 50.0 * J @ V_s, rtol=1e-9, atol=1e-9)
    power = (J @ (V_s - V)) @ (nist.friction.viscous_offset * (J @ r.xd))
    assert law.adapt[1] == "friction.viscous_offset"
    assert (after.parameters - state.parameters)[1] / (0.5 * PERIOD) == pytest.approx(power, rel=1e-6)


@pytest.mark.full
def test_encoder_noise_drives_the_estimates_of_the_actual_regressor_and_not_those_of_the_desired(nist):
    """4 kHz, 1 um: the square of the speed's noise has a mean, the product of noise and reference has none."""
    machine = nist.replace(**{"drive.encoder": 1e-6})
    circle = gk.Circle(radius=0.2, feed=0.05, start=np.radians(240.0), turns=0.25)
    worst = {}
    for regressor in ("desired", "actual"):
        law = gk.RobustAdaptive(slope=300.0, damping=740.0, regressor=regressor)
        log = gk.simulate(machine, law, circle, period=2.5e-4)
        assert log.dataset.attrs["status"] == "done"
        worst[regressor] = np.abs(log["controller.parameters"] - 1).max()
    assert (
        worst["desired"] < 0.05
    )  # a tenth of the way to the bound; a quarter turn with true parameters moves it 2.5 %
    assert worst["actual"] == pytest.approx(0.5)  # the bound


@pytest.mark.full
def test_the_sign_of_the_measured_speed_costs_glitches(nist):
    """The stuck strut is held where it is: largest error behind reversals, with the sign of either speed."""
    machine = nist.replace(**{"drive.encoder": 1e-6})
    circle = gk.Circle(radius=0.2, feed=0.05, start=np.radians(240.0), turns=0.25)
    worst = {}
    for speed, width in (("reference", 2e-4), ("measured", 5e-3)):
        law = gk.RobustAdaptive(slope=150.0, damping=370.0, friction_speed=speed, friction_smoothing=width)
        log = gk.simulate(scaled(machine, 0.8), law, circle, plant=machine)
        worst[speed] = log["contour_error"][log["t"] > 1.0].max()
    assert worst["measured"] > 1.5 * worst["reference"]


@pytest.mark.parametrize(
    ("options", "where", "text"),
    [
        ({"damping": 1900.0, "sliding": 400.0, "boundary": 1e-4}, "boundary", "sample time is too long"),
        ({"damping": 2500.0}, "damping", "sample time is too long"),
        ({"adapt": ["platform.mas"]}, "adapt.0", "no such number"),
        ({"adapt": ["platform.mass", "drive.lead"]}, "adapt.1", "not linear"),
        ({"adapt": ["platform.mass", "strut.fixed.mass + platform.mass"]}, "adapt.1", "platform.mass once more"),
        ({"adapt": ["platform.mass", "friction.coulomb"]}, "adapt.1", "no force depends on it"),
        ({"adapt": [""]}, "adapt.0", "got ''; there is drive.inertia, "),
        ({"slope": [100.0, 100.0]}, "slope", "one value or 6"),
    ],
)
def test_what_does_not_fit_the_machine_is_refused_by_name(nist, options, where, text):
    law = gk.RobustAdaptive(**({"slope": 100.0, "damping": 200.0} | options))
    with pytest.raises(ExperimentError, match=text) as error:
        law.on(nist, PERIOD)
    assert where in str(error.value)


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"slope": -1.0, "damping": 100.0}, "above 0"),
        ({"slope": 100.0}, "either damping or K_D"),
        ({"slope": 100.0, "damping": 100.0, "K_D": np.eye(6)}, "either damping or K_D"),
        ({"slope": 100.0, "K_D": np.diag([1.0, 1, 1, 1, 1, -2])}, "positive definite.*-2"),
        ({"slope": 100.0, "K_D": np.eye(6) + np.eye(6, k=1)}, "symmetric"),
        ({"slope": 100.0, "damping": 100.0, "bounds": [1.5, 0.5]}, "lower bound"),
        ({"slope": 100.0, "damping": 100.0, "friction_bounds": [1.2, 2.0]}, "first estimate"),
        ({"slope": 100.0, "damping": 100.0, "bounds": [-0.5, 1.5]}, "at least 0"),
        ({"slope": 100.0, "damping": 100.0, "friction_bounds": [-0.5, 1.5]}, "at least 0"),
    ],
)
def test_gains_that_are_not_positive_definite_and_bounds_the_wrong_way_round_are_refused(options, text):
    with pytest.raises(InputError, match=text):
        gk.RobustAdaptive(**options)


def test_friction_that_is_not_believed_cannot_be_scaled(nist):
    with pytest.raises(ExperimentError, match="no friction to learn"):
        gk.RobustAdaptive(slope=100.0, damping=200.0).on(nist.replace(friction=None), PERIOD)


@pytest.mark.quick("*-400.0")
@pytest.mark.parametrize("sliding", [0.0, 400.0])
@pytest.mark.parametrize("delay", [0, 1])
def test_the_slowest_period_it_takes_is_where_the_loop_goes_unstable(nist, delay, sliding):
    """The bound of the refusal is a derived one: a pure surface (no slope) at 0.98 of it decays, at 1.02 it grows."""
    from gough.simulate import stability

    machine = nist.replace(**{"drive.encoder": None, "drive.delay": float(delay)})
    boundary, limit = 5e-3, 2.0 if delay == 0 else 2 * (np.sqrt(2) - 1)

    def at(share):  # of the limit; K_D = k M - tau_0 W / eps leaves k M in the boundary layer
        k, M = share * limit / PERIOD, machine.mass_matrix(machine.home)
        l2 = np.trace(M[3:, 3:]) / np.trace(M[:3, :3])
        K_D = k * M - sliding / boundary * np.diag([1, 1, 1, l2, l2, l2])
        return gk.FuzzyFriction(
            slope=1e-3, K_D=(K_D + K_D.T) / 2, sliding=sliding, boundary=boundary, friction_rate=1.0
        )

    decays = at(0.98).on(machine, PERIOD)
    assert stability.spectral_radius(machine, decays, PERIOD, 4) < 1 + 1e-6
    with pytest.raises(ExperimentError, match="sample time"):
        at(1.02).on(machine, PERIOD)
    grows = decays.replace(K_D=at(1.02).K_D)  # past the refusal
    # 2 % above the limit z^2 - z + k Ts (z + 1) / 2 has a root 1.010, with the delay 1.0066; half of the less
    assert stability.spectral_radius(machine, grows, PERIOD, 4) > 1.0033
