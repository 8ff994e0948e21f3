"""Friction in proportion to a load: its limits are the laws without one, and it takes energy whatever the load does."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest
from numpy.testing import assert_allclose

from gough.errors import SheetError
from gough.mechanics.friction import LuGre, Stribeck
from gough.mechanics.load_friction import LoadLuGre, LoadStribeck

MU = {"coulomb": 0.18, "static": 0.24, "stribeck": 0.002, "viscous": 0.5}
FREE = {"coulomb_offset": 20.0, "viscous_offset": 94.0}
BRISTLES = {"stiffness": 1e9, "damping": 8.85e5}
SPEEDS = np.concatenate([-np.geomspace(1e-6, 2, 30)[::-1], [0.0], np.geomspace(1e-6, 2, 30)])
PAIRS = {"smooth": (LoadStribeck, Stribeck, {"smoothing": 1e-3}), "memory": (LoadLuGre, LuGre, BRISTLES)}


def col(value):
    return ca.DM(np.atleast_1d(np.asarray(value, float)))


def flat(value):
    return np.array(ca.DM(value)).ravel()


@pytest.mark.parametrize("law", PAIRS)
@pytest.mark.parametrize("load", [1.0, 890.0, 2870.0])
def test_under_a_constant_load_it_is_the_law_without_one(law, load):
    """Force, memory rate and memory step, at F_c = F_0 + mu_c N, F_s = F_0 + mu_s N, f_v = f_0 + mu_v N."""
    loaded, constant, numbers = PAIRS[law]
    p = loaded(**MU, **FREE, **numbers)
    q = constant(coulomb=20 + 0.18 * load, static=20 + 0.24 * load, stribeck=0.002, viscous=94 + 0.5 * load, **numbers)
    z, N = col(np.full(SPEEDS.shape, 1.3e-7)), col(np.full(SPEEDS.shape, load))
    v = col(SPEEDS)
    assert_allclose(flat(p.force(p, v, z, N)), flat(q.force(q, v, z)), rtol=1e-13)
    assert_allclose(flat(p.memory_rate(p, v, z, N)), flat(q.memory_rate(q, v, z)), rtol=1e-11)
    assert_allclose(flat(p.advance(p, v, z, 1e-4, N)), flat(q.advance(q, v, z, 1e-4)), rtol=1e-11)


@pytest.mark.parametrize("law", PAIRS)
def test_with_coefficients_of_zero_the_load_does_not_count(law):
    loaded, _, numbers = PAIRS[law]
    p = loaded(coulomb=0.0, coulomb_offset=300.0, viscous=0.0, viscous_offset=930.0, **numbers)
    z, v = col(np.full(SPEEDS.shape, 1e-7)), col(SPEEDS)
    small, large = (flat(p.force(p, v, z, col(np.full(SPEEDS.shape, N)))) for N in (0.0, 1e5))
    assert (small == large).all()


def test_without_offsets_friction_is_proportional_to_the_load():
    p = LoadStribeck(**MU)
    v = col(SPEEDS)
    F1, F3 = (flat(p.force(p, v, v * 0, v * 0 + N)) for N in (1000.0, 3000.0))
    assert_allclose(F3, 3 * F1, rtol=1e-13)
    assert flat(p.force(p, col(1.0), col(0.0), col(1000.0))) == pytest.approx(0.18 * 1000 + 0.5 * 1000)


@pytest.mark.parametrize("v", [-0.5, -0.002, 1e-4, 0.003, 1.0])
@pytest.mark.parametrize("load", [900.0, 2900.0])
def test_steady_sliding_with_bristles_is_the_scaled_stribeck_curve(v, load):
    p = LoadLuGre(**MU, **FREE, **BRISTLES)
    z = 0.0
    for _ in range(200):
        z = float(p.advance(p, col(v), col(z), 1e-3, col(load)))
    g = 20 + load * (0.18 + 0.06 * np.exp(-((v / 0.002) ** 2)))
    assert z == pytest.approx(g * np.sign(v) / 1e9, rel=1e-12)
    F = flat(p.force(p, col(v), col(z), col(load)))[0]
    assert pytest.approx(g * np.sign(v) + (94 + 0.5 * load) * v, rel=1e-9) == F


def test_breakaway_comes_after_a_way_in_proportion_to_the_load():
    """At rest the bristles hold F_s and no more; the deflection there is F_s / s0."""
    p = LoadLuGre(**MU, **BRISTLES)
    ways = []
    for load in (1000.0, 2000.0):
        z = 0.0
        for _ in range(1000):  # 10 s at 1 um/s: far below v_s
            z = float(p.advance(p, col(1e-6), col(z), 1e-2, col(load)))
        ways.append(z)
    assert_allclose(ways, [240e-9, 480e-9], rtol=1e-5)


@pytest.mark.full
def test_bristles_give_no_energy_back_whatever_the_load_does():
    """Passive from speed to force: the work of F over any motion is at least what is left in the bristles, s0 z^2 / 2.

    d(s0 z^2 / 2) = s0 z z' dt <= F v dt for every N(t), as long as s1 |v| <= 4 g (docs/theory/friction.md): here 1 N
    against 72 N and more; the load jumps by a factor of 30.
    """
    p = LoadLuGre(coulomb=0.18, static=0.24, stribeck=0.002, stiffness=1e7, damping=1e2)
    rng, h, z, work = np.random.default_rng(3), 1e-5, 0.0, 0.0
    for k in range(1500):
        if k % 50 == 0:
            load, v = rng.uniform(100, 3000), rng.uniform(-0.01, 0.01)
        middle = float(p.advance(p, col(v), col(z), h / 2, col(load)))
        work += flat(p.force(p, col(v), col(middle), col(load)))[0] * v * h
        z = float(p.advance(p, col(v), col(z), h, col(load)))
        assert work - 1e7 * z * z / 2 > -1e-9 * max(work, 1.0)


def test_the_memory_survives_a_load_that_vanishes():
    """Contact lost for a moment: the level falls to that of the offset, and nothing is divided by zero."""
    p = LoadLuGre(**MU, coulomb_offset=1.0, **BRISTLES)
    z = float(p.advance(p, col(0.1), col(2e-7), 1e-4, col(0.0)))
    assert z == pytest.approx(1.0 / 1e9, rel=1e-9)
    assert np.isnan(flat(p.force(p, col(0.1), col(0.0), col(np.nan)))).all(), "a load that is no number is not hidden"


def test_what_no_load_scales_is_told_for_the_regressor():
    assert LoadLuGre(**MU, **FREE, **BRISTLES).unloaded == (20.0, 94.0)
    assert LuGre(coulomb=300.0, viscous=930.0, **BRISTLES).unloaded == (300.0, 930.0)


@pytest.mark.parametrize(
    ("numbers", "message"),
    [
        ({"coulomb": -0.1}, r"^coulomb: must be at least 0, got -0.1$"),
        ({"coulomb": "360 N"}, r"^coulomb: must be a number, without quotes, got '360 N'$"),
        ({"static": 0.1}, "static coefficient must be at least the Coulomb coefficient, got 0.1 against 0.18"),
        ({"stribeck": None}, "static and stribeck belong together; give both or neither"),
        (
            {"coulomb": 0.0, "static": None, "stribeck": None},
            "coulomb or coulomb_offset must be above 0 under LuGre; leave",
        ),
        ({"viscous_offset": float("inf")}, "viscous_offset: must be finite"),
    ],
)
def test_p4_coefficients_that_cannot_be_are_refused(numbers, message):
    with pytest.raises(SheetError, match=message) as caught:
        LoadLuGre(**(MU | BRISTLES | numbers))
    assert caught.value.exit_status == 2
