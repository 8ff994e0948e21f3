"""Flexible feedforward: its filter, its limits, and what it is worth on a machine that gives way."""

from __future__ import annotations

from types import SimpleNamespace

import casadi as ca
import numpy as np
import pytest
from numpy.testing import assert_allclose

import gough as gk
from gough.control.bending import bends_of, shift
from gough.control.computed_torque import ComputedTorque
from gough.control.elastic_map import ElasticMap
from gough.control.flexible_feedforward import Filter, FlexibleFeedforward
from gough.control.gravity_compensation import GravityCompensation
from gough.errors import ExperimentError
from gough.program import Line
from gough.simulate import tick


@pytest.fixture(scope="module")
def hexapod():
    m = gk.load_machine("nist-octahedral").frictionless()
    return m.replace(drive=m.drive.perfect())


@pytest.fixture(scope="module")
def hybrid():
    m = gk.load_machine("ifma-hsm")
    return m.replace(drive=m.drive.perfect())


def nothing(machine, value=0.0):
    """A map of a machine that gives way by `value` m along its first coordinate, everywhere, and not by motion."""
    d = len(machine.task)
    sag = np.zeros((d, 1))
    sag[0] = value
    return ElasticMap(
        degree=0, center=np.zeros(d), half=np.ones(d), sag=sag, motion=np.zeros((d * (d + d * (d + 1) // 2), 1))
    )


def test_forces_of_a_motion_bend_the_drives_by_their_compliance_times_the_force(hexapod):
    """q_c = q + c f, f of the whole machine less what is on the motors' side: two derivations of the same springs."""
    flexible, rng = hexapod.flexible(), np.random.default_rng(0)
    bends = bends_of(hexapod, 6, True)
    theta = ca.SX.sym("theta", len(bends.theta))
    x, xd, xdd = (ca.SX.sym(s, 6) for s in ("x", "xd", "xdd"))
    f = ca.Function("d", [theta, x, xd, xdd], [shift(hexapod, bends, bends.at(theta), x, xd, xdd)])
    pose = hexapod.home + np.array([0.02, 0.03, -0.01, 0.0, 0.0, 0.0])
    rate, acc = 0.2 * rng.normal(size=6), 2.0 * rng.normal(size=6)
    d = np.array(f(bends.theta, pose, rate, acc)).ravel()
    u = hexapod.inverse_dynamics(pose, rate, acc)
    _, _, qdd = hexapod.joint_motion(pose, rate, acc)
    p, th = flexible.symbols
    z = flexible.stiff.coordinates(pose)
    c = np.array(ca.Function("c", [th], [flexible.in_series(p, ca.SX(ca.DM(z))).compliance])(flexible.theta)).ravel()
    pi = {key: value for key, (value, _) in hexapod.inertial(hexapod).items()}
    mass, weight, _ = hexapod.motor_load(hexapod, pi)
    mass, weight = (np.array(ca.evalf(ca.SX(part))).ravel() * np.ones(6) for part in (mass, weight))
    stretch = c * (u - mass * qdd + weight)
    # to first order in d, which is 0.1 mm: a place off by d^2 over a leg of 1 m, 1e-8 m
    assert_allclose(hexapod.jacobian(pose) @ d, stretch, rtol=0, atol=1e-3 * np.abs(stretch).max())


def test_the_filter_lags_a_steady_rate_by_nothing_and_its_rates_are_its_own(hybrid):
    law = FlexibleFeedforward(law=ComputedTorque(bandwidth=5.0), takeover=1e-3, bandwidth=100.0)
    law = law.replace(law=law.law.on(hybrid, 1e-4), machine=hybrid, period=1e-4)
    # sag along x of 1e-3 x: with x = v t + a t^2 / 2 the displacement is known in closed form
    slope = ElasticMap(degree=1, center=np.zeros(3), half=np.ones(3), sag=np.zeros((3, 4)), motion=np.zeros((27, 4)))
    sag = np.zeros((3, 4))
    sag[0, 3] = 1e-3  # products in the order 1, z, y, x
    law = law.replace(bends=slope.replace(sag=sag))
    theta = ca.SX.sym("theta", len(law.theta))
    own = [ca.SX.sym(f"own{i}", 3) for i in range(3)]
    x, xd, xdd = (ca.SX.sym(s, 3) for s in ("x", "xd", "xdd"))
    r = tick.rest_row(hybrid, hybrid.home)._replace(x=x, xd=xd, xdd=xdd)
    out, after = law.moved(law.at(theta), Filter(*own), r, (ca.SX(1), ca.SX(0), ca.SX(0)))
    f = ca.Function("moved", [theta, *own, x, xd, xdd], [out.x - x, out.xd - xd, out.xdd - xdd, *after])
    v, a, state = np.array([0.5, 0, 0]), np.array([4.0, 0, 0]), [np.zeros(3)] * 3
    for k in range(1, 2001):
        t = k * 1e-4
        at = v * t + a * t * t / 2  # from y = 1.2 on, of which the map knows nothing
        found = f(law.theta, *state, at + np.array([0, 1.2, 0]), v + a * t, a)
        d, dd, ddd, *state = (np.array(part).ravel() for part in found)
    b = 2 * np.pi * 100.0
    # d'' / b^2; of what samples add the largest is b Ts^2 / 12 of d', 7e-10 m
    assert d[0] == pytest.approx(1e-3 * at[0] - 1e-3 * a[0] / b**2, abs=2e-9)
    assert dd[0] == pytest.approx(1e-3 * (v + a * t)[0], rel=1e-3)
    assert ddd[0] == pytest.approx(1e-3 * a[0], rel=1e-3)


def test_where_nothing_gives_way_the_law_is_the_one_inside_to_rounding(hybrid):
    inner = ComputedTorque(bandwidth=10.0)
    law = FlexibleFeedforward(law=inner)
    law = law.replace(law=inner.on(hybrid, 1e-3), machine=hybrid, period=1e-3, bends=nothing(hybrid))
    r = tick.rest_row(hybrid, hybrid.home)._replace(xd=np.array([0.1, 0.2, -0.3]), xdd=np.array([1.0, 2.0, 3.0]))
    r = r._replace(**dict(zip(("q", "qd", "qdd"), hybrid.joint_motion(r.x, r.xd, r.xdd), strict=True)))
    u0 = hybrid.inverse_dynamics(hybrid.home, *np.zeros((2, 3)))
    y = SimpleNamespace(q=r.q - 1e-5, u=u0)

    def force(one, state):
        theta = ca.SX.sym("theta", len(one.theta))
        return np.array(ca.Function("u", [theta], [one.step(state, r, y, theta)[0].u])(one.theta)).ravel()

    alone = inner.on(hybrid, 1e-3)
    state = law.init(r, u0)._replace(clock=np.array([0.2]))
    assert_allclose(force(law, state), force(alone, alone.init(r, u0)), rtol=1e-11)


@pytest.mark.full
def test_the_stiffer_the_machine_the_less_is_fed_forward(hexapod):
    """Ten times as stiff, a tenth: the displacement in a run is linear in the compliance."""
    size = []
    for factor in (1.0, 10.0):
        m = hexapod.replace(
            compliance=[one.replace(stiffness=np.multiply(one.stiffness, factor)) for one in hexapod.compliance]
        )
        bends = bends_of(m, 6, True)
        theta = ca.SX.sym("theta", len(bends.theta))
        f = ca.Function("d", [theta], [shift(m, bends, bends.at(theta), ca.SX(m.home), ca.SX.ones(6), ca.SX.ones(6))])
        size.append(np.array(f(bends.theta)).ravel())
    assert_allclose(size[0], 10 * size[1], rtol=1e-3, atol=1e-9)


@pytest.mark.full
def test_on_the_elastic_machine_the_tip_errs_less_than_a_fifth_of_what_gravity_compensation_leaves(hybrid):
    """A line of 0.3 m in 0.4 s, its ramps a period of the first mode: the rest is what samples cost the law inside."""
    way = np.array([-0.1, 0.25, 0.1])
    program = Line(
        to=way, feed=1.0, acceleration=10.0, profile="jerk_limited", jerk=400.0, lead_in=0.25, settle=0.2,
    )  # fmt: skip
    inner, plant = ComputedTorque(bandwidth=10.0), gk.Plant(machine=hybrid, flexible=True)
    worst = []
    for law in (GravityCompensation(law=inner), FlexibleFeedforward(law=inner)):
        log = gk.simulate(hybrid, law, program, plant=plant, period=1e-4)
        gap = (log.dataset.x - log.dataset.x_r).values[log.dataset.t.values >= 0.25]
        worst.append(np.abs(gap).max())
    assert worst[0] > 50e-6
    assert worst[1] < 0.2 * worst[0]


@pytest.mark.parametrize(
    ("period", "text"), [(2e-3, "bandwidth: is too fast for the sample time, got 100 Hz at 0.002 s")]
)
def test_a_filter_faster_than_its_samples_is_refused(hexapod, period, text):
    with pytest.raises(ExperimentError, match=text):
        FlexibleFeedforward(law=ComputedTorque(bandwidth=5.0)).on(hexapod, period)


def test_a_law_in_plain_numpy_is_not_wrapped(hexapod):
    class Plain(gk.PID):
        symbolic = False

    with pytest.raises(ExperimentError, match="only a law in CasADi's operations can be wrapped"):
        FlexibleFeedforward(law=Plain(bandwidth=5.0)).on(hexapod, 1e-3)


def test_states_of_the_inner_law_are_told_as_its_own(hexapod):
    law = FlexibleFeedforward(law=gk.DesiredTorqueAdaptive(pole=50.0)).on(hexapod, 1e-3)
    assert law.state_told("inner.parameters") == law.law.states["parameters"]
    assert law.state_told("own.y")[0] == "task"
    assert law.learns("inner.parameters") and not law.learns("inner.force") and not law.learns("parameters")
    assert [task.name for task in law.tasks()] == [task.name for task in law.law.tasks()] != []
