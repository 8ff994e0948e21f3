"""The friction laws: their limits, LuGre's steady state and bound, and the exact step of its memory."""

from __future__ import annotations

from decimal import Decimal, getcontext

import casadi as ca
import numpy as np
import pytest
from numpy.testing import assert_allclose

from gough.errors import SheetError
from gough.machine.sheet import load_machine
from gough.mechanics.friction import LuGre, Stribeck, level

STRIBECK = {"coulomb": 300.0, "static": 400.0, "stribeck": 0.002, "viscous": 930.0}
BRISTLES = {"stiffness": 1e9, "damping": 8.85e5}
SPEEDS = np.concatenate([-np.geomspace(1e-6, 2, 40)[::-1], np.geomspace(1e-6, 2, 40)])


def force(p, v, z=0.0):
    """Friction of speeds v by a law with numbers p."""
    v = np.atleast_1d(v)
    return np.array(ca.DM(type(p).force(p, ca.DM(v), ca.DM(np.broadcast_to(z, v.shape))))).ravel()


def advance(p, v, z, h):
    return float(LuGre.advance(p, ca.DM(v), ca.DM(z), h))


def g(v):
    return 300 + 100 * np.exp(-((v / 0.002) ** 2))


# -- without memory ---------------------------------------------------------------------------------------------------


def test_smooth_friction_is_odd_and_always_opposes_motion():
    p = Stribeck(**STRIBECK, smoothing=1e-3)
    F = force(p, SPEEDS)
    assert_allclose(F, -F[::-1], rtol=1e-15)
    assert (F * SPEEDS > 0).all() and force(p, 0.0) == 0


def test_smooth_friction_becomes_coulomb_and_viscous_friction_far_from_rest():
    p = Stribeck(**STRIBECK, smoothing=1e-3)
    v = np.array([-1.5, -0.1, 0.1, 1.5])
    assert_allclose(force(p, v), 300 * np.sign(v) + 930 * v, rtol=1e-15)
    dry = Stribeck(coulomb=90.0, smoothing=1e-3)
    assert_allclose(force(dry, v), 90 * np.sign(v), rtol=1e-15)


def test_stribeck_peak_lies_between_coulomb_and_static_friction_below_the_stribeck_speed():
    p = Stribeck(coulomb=300.0, static=400.0, stribeck=0.002, smoothing=1e-5)
    v = np.linspace(0, 0.02, 20001)
    F = force(p, v)
    peak = v[F.argmax()]
    assert 395 < F.max() < 400 and 1e-5 < peak < 2e-4
    assert (np.diff(F[v > peak]) <= 1e-12).all(), "falls from the peak to the Coulomb level"
    assert p.peak == 400 and Stribeck(coulomb=300.0).peak == 300


def test_level_at_the_stribeck_speed_has_fallen_to_one_part_in_e():
    p = Stribeck(**STRIBECK)
    assert float(level(p, 0.002)) == pytest.approx(300 + 100 / np.e, rel=1e-15)


def test_each_joint_may_have_its_own_numbers():
    p = LuGre(**(STRIBECK | {"coulomb": [100.0, 200.0, 300.0], "viscous": [1.0, 2.0, 3.0]}), **BRISTLES)
    v = np.full(3, 0.5)
    z = np.array([1e-7, 2e-7, 3e-7])  # g / s0
    assert_allclose(force(p, v, z), [100.5, 201.0, 301.5], rtol=1e-12)


# -- with memory ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("v", [-1.0, -0.003, -1e-4, 1e-4, 0.002, 0.5])
def test_lugre_settles_at_level_sign_and_viscous_friction(v):
    p = LuGre(**STRIBECK, **BRISTLES)
    z = 0.0
    for _ in range(200):
        z = advance(p, v, z, 1e-3)
    assert z == pytest.approx(g(v) * np.sign(v) / 1e9, rel=1e-12)
    assert force(p, v, z)[0] == pytest.approx(g(v) * np.sign(v) + 930 * v, rel=1e-9)


def test_lugre_is_a_spring_and_a_damper_before_it_slides():
    """dF/dx = s0 and dF/dv = s1 + f_v about z = v = 0."""
    p = LuGre(**STRIBECK, **BRISTLES)
    assert_allclose(force(p, 0.0, 1e-9), 1.0, rtol=1e-12)
    assert_allclose(force(p, 1e-9, 0.0), (8.85e5 + 930) * 1e-9, rtol=1e-12)


@pytest.mark.full
def test_lugre_memory_stays_within_static_friction_for_any_step_and_speed():
    p = LuGre(**STRIBECK, **BRISTLES)
    rng = np.random.default_rng(0)
    bound, z = 400 / 1e9, 0.0
    for _ in range(5000):
        v, h = rng.choice([-1, 1]) * 10 ** rng.uniform(-9, 1), 10 ** rng.uniform(-7, 1)
        z = advance(p, v, z, h)
        assert abs(z) <= bound * (1 + 1e-15)


def test_lugre_memory_sticks_at_rest():
    """No creep: with the speed zero the memory does not move, however long."""
    p = LuGre(**STRIBECK, **BRISTLES)
    assert advance(p, 0.0, 1.23e-7, 1e6) == 1.23e-7


def exact(v, z, h):
    """Eq. (5) in fifty digits."""
    getcontext().prec = 50
    v, z, h = Decimal(v), Decimal(z), Decimal(h)
    k = Decimal(10) ** 9 * abs(v) / (300 + 100 * (-((v / Decimal(0.002)) ** 2)).exp())
    decay = (-k * h).exp()
    return float(z * decay + v * (1 - decay) / k)


@pytest.mark.parametrize("h", [1e-6, 2.5e-4, 1e-2])
def test_memory_step_is_eq_5_to_rounding_at_every_speed(h):
    """Through the series near rest and the exponential elsewhere: each digit of ten decades of speed."""
    p = LuGre(**STRIBECK, **BRISTLES)
    for v in 10.0 ** np.arange(-16, 1.1, 0.25):
        for z in (0.0, 2.5e-7, -3.9e-7):
            wanted = exact(v, z, h)
            assert abs(advance(p, v, z, h) - wanted) <= 5e-16 * (abs(wanted) + abs(z))


def test_memory_step_is_what_fine_integration_of_eq_3_gives():
    p = LuGre(**STRIBECK, **BRISTLES)
    v, h, n = 1e-3, 2.5e-4, 20_000
    z = 1e-7
    slope = lambda z: v - 1e9 * abs(v) / g(v) * z  # noqa: E731
    for _ in range(n):  # RK4: k h / n = 4e-5
        d = h / n
        k1 = slope(z)
        k2 = slope(z + d / 2 * k1)
        k3 = slope(z + d / 2 * k2)
        z += d / 6 * (k1 + 2 * k2 + 2 * k3 + slope(z + d * k3))
    assert advance(p, v, 1e-7, h) == pytest.approx(z, rel=1e-12)


def test_two_half_steps_of_the_memory_are_one():
    p = LuGre(**STRIBECK, **BRISTLES)
    for v in (1e-7, -1e-4, 0.3):
        twice = advance(p, v, advance(p, v, 1e-7, 1e-4), 1e-4)
        assert twice == pytest.approx(advance(p, v, 1e-7, 2e-4), rel=1e-13)


def test_nan_passes_through_both_laws():
    p = LuGre(**STRIBECK, **BRISTLES)
    assert np.isnan(advance(p, np.nan, 0.0, 1e-4)) and np.isnan(advance(p, 0.1, np.nan, 1e-4))
    assert np.isnan(force(p, np.nan)).all() and np.isnan(force(Stribeck(**STRIBECK), np.nan)).all()


# -- the splitting ----------------------------------------------------------------------------------------------------


def stopping(p, mass, h, duration):
    """(s, v, z) of a mass let go at 1 m/s with its bristles settled, every h: memory h/2, RK4, memory h/2.  (n, 3)."""
    y = ca.SX.sym("y", 3)
    z = LuGre.advance(p, y[1], y[2], h / 2)

    def rate(s):
        return ca.vertcat(s[1], -LuGre.force(p, s[1], z) / mass)

    s = y[:2]
    k1 = rate(s)
    k2 = rate(s + h / 2 * k1)
    k3 = rate(s + h / 2 * k2)
    s = s + h / 6 * (k1 + 2 * k2 + 2 * k3 + rate(s + h * k3))
    step = ca.Function("step", [y], [ca.vertcat(s, LuGre.advance(p, s[1], z, h / 2))])
    settled = float(level(p, 1.0)) / p.stiffness
    return np.array(step.mapaccum(round(duration / h))(ca.DM([0.0, 1.0, settled]))).T


@pytest.mark.full
def test_a_strut_stopping_from_1_m_s_is_right_to_half_a_micron_at_a_quarter_millisecond():
    """nist-octahedral: moving tube and reflected screw, 351 kg; the answer is that of steps of 1 us."""
    m = load_machine("nist-octahedral")
    mass = m.strut.moving.mass + m.drive.inertia * (2 * np.pi / m.drive.lead) ** 2
    p = LuGre(**STRIBECK, **BRISTLES)
    fine, coarse = (stopping(p, mass, h, 0.6) for h in (1e-6, 2.5e-4))
    assert np.abs(coarse[:, 0] - fine[249::250, 0]).max() < 0.5e-6
    assert np.abs(coarse[-1, 1]) < 1e-9 and coarse[-1, 0] > 0.15, "it has stopped, after a way"


def test_the_memory_inside_rk4_would_not_survive_that_step():
    """Why it is split: k = s0 |v| / g is 3.3e6 1/s at 1 m/s, a thousand times beyond what RK4 bears at 0.25 ms."""
    p = LuGre(**STRIBECK, **BRISTLES)
    y = ca.SX.sym("y", 3)

    def rate(s):
        zd = s[1] - p.stiffness * ca.fabs(s[1]) / level(p, s[1]) * s[2]
        return ca.vertcat(s[1], -LuGre.force(p, s[1], s[2]) / 351, zd)

    h = 2.5e-4
    k1 = rate(y)
    k2 = rate(y + h / 2 * k1)
    k3 = rate(y + h / 2 * k2)
    step = ca.Function("step", [y], [y + h / 6 * (k1 + 2 * k2 + 2 * k3 + rate(y + h * k3))])
    out = np.array(step.mapaccum(100)(ca.DM([0.0, 1.0, 2.9e-7])))
    assert not np.isfinite(out).all()


# -- what a sheet may say ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("numbers", "message"),
    [
        ({"coulomb": -1.0}, r"^coulomb: must be at least 0 N, got -1 N$"),
        ({"viscous": -930.0}, r"^viscous: must be at least 0 N s/m, got -930 N s/m$"),
        ({"static": 200.0}, r"static friction must be at least the Coulomb friction, got 200.0 N against 300.0 N"),
        ({"stribeck": 0.0}, r"^stribeck: must be above 0 m/s, got 0 m/s$"),
        ({"stribeck": None}, "static and stribeck belong together; give both or neither"),
        ({"stiffness": 0.0}, r"^stiffness: must be above 0 N/m, got 0 N/m$"),
        ({"damping": -1.0}, r"^damping: must be at least 0 N s/m, got -1 N s/m$"),
        ({"coulomb": 0.0, "static": None, "stribeck": None}, "coulomb friction must be above 0 N under LuGre"),
        ({"coulomb": [[1.0, 2.0]]}, "coulomb: must have shape"),
        ({"coulomb": float("nan")}, "coulomb: must be finite"),
    ],
)
def test_p4_friction_that_cannot_be_is_refused(numbers, message):
    with pytest.raises(SheetError, match=message) as caught:
        LuGre(**(STRIBECK | BRISTLES | numbers))
    assert caught.value.exit_status == 2


def test_smoothing_must_be_above_zero():
    with pytest.raises(SheetError, match=r"^smoothing: must be above 0 m/s"):
        Stribeck(coulomb=90.0, smoothing=0.0)
