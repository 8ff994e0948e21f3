"""Where a formula is taken by its series: just inside, at rounding, so that a wrong sign of the last term is seen."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest
from numpy.testing import assert_allclose

from gough import frames
from gough.mechanics.friction import LuGre

# the series are used below half^2 = 1e-8; their last terms are then 1e-9 of the answer, rounding is 1e-16
ANGLE = 2 * np.sqrt(0.9e-8)
CLOSE = 1e-14


@pytest.mark.parametrize("axis", [(1.0, 0.0, 0.0), (0.6, 0.0, -0.8), (-0.48, 0.6, 0.64)])
def test_quaternion_and_rotation_vector_of_a_small_turn_are_those_of_sine_and_cosine(axis):
    r = ANGLE * np.array(axis)
    exact = np.concatenate([[np.cos(ANGLE / 2)], np.sin(ANGLE / 2) * np.array(axis)])
    assert_allclose(np.array(frames.quaternion_of_rotation_vector(ca.DM(r))).ravel(), exact, rtol=CLOSE, atol=0)
    for quaternion in (exact, -exact):  # one rotation
        found = np.array(frames.rotation_vector_of_quaternion(ca.DM(quaternion))).ravel()
        assert_allclose(found, r, rtol=CLOSE, atol=0)


@pytest.mark.parametrize("speed", [1e-3, -1e-3])
def test_bristles_bend_over_a_short_way_as_the_exponential_says(speed):
    law = LuGre(coulomb=300.0, stiffness=1e6, damping=0.0)
    h = 0.9e-8 * 300.0 / (1e6 * abs(speed))  # so that x = s0 |v| h / g = 0.9e-8, just inside the series
    z0 = 1e-4
    found = float(ca.evalf(ca.SX(law.advance(law, ca.DM(speed), ca.DM(z0), h))))
    # a change of 1e-12 m on 1e-4 m, whose rounding is 1e-20 m
    assert_allclose(found - z0, z0 * np.expm1(-0.9e-8) - speed * h * np.expm1(-0.9e-8) / 0.9e-8, rtol=1e-7)
    fresh = float(ca.evalf(ca.SX(law.advance(law, ca.DM(speed), ca.DM(0.0), h))))
    assert_allclose(fresh, -speed * h * np.expm1(-0.9e-8) / 0.9e-8, rtol=CLOSE)
