"""Stability lobes: the published solution, its check step by step, and what no depth can shake."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from cutting.mills import SHARP, SPEED, mill
from gough.cutting import force
from gough.cutting.lobes import Modes, directional, lobes, multiplier
from gough.cutting.numeric import ARRAYS
from gough.errors import ExperimentError

# a mode in x and one in y, as of a slender tool: stiffness m w^2 = 1e7 and 1.4e7 N/m at 1 kg
FREQUENCY = np.array([3.16e3, 3.74e3]) / (2 * np.pi)
MODES = Modes(FREQUENCY, np.array([0.02, 0.025]), np.eye(2))
GRID = np.linspace(0.3 * FREQUENCY[0], 3 * FREQUENCY[1], 6_000)
SLOT = (0.0, np.pi)


def border(first, last, teeth=4):
    return lobes(GRID, MODES.response(GRID), SHARP, teeth, first, last)


def test_the_coefficients_are_those_of_the_force():
    """A averaged against force.py: a chip (a, b) of one tooth, straight flutes, over its angles."""
    first, last = 0.4, 2.2
    nodes, weights = np.polynomial.legendre.leggauss(30)
    angles = (first + last) / 2 + (last - first) / 2 * nodes
    tool, K = mill(1, 0.0), SHARP.replace(axial=0.0)
    found = np.zeros((2, 2))
    for column, (a, b) in enumerate(((1e-6, 0.0), (0.0, 1e-6))):
        F = [force.force(ARRAYS, tool, K, 1, 1.0, [[(a, 0.0, *SLOT)]], angle, b)[:2] for angle in angles]
        found[:, column] = (last - first) / 2 * weights @ np.array(F) / (1e-6 * K.tangential / 2)
    assert_allclose(found, directional(K, first, last), rtol=1e-5)  # _STRAIGHT turns 1e-6 rad over a metre


def test_at_the_border_the_loop_keeps_itself_up():
    """det(1 - (a K_t N / 4 pi) (1 - exp(-i w T)) A H) = 0 at every point, put in anew."""
    found = border(*SLOT)
    H = MODES.response(found.frequency[::297])
    w, T = 2 * np.pi * found.frequency[::297], 2 * np.pi / (4 * found.speed[::297])
    gain = found.depth[::297] * SHARP.tangential * 4 / (4 * np.pi) * (1 - np.exp(-1j * w * T))
    for g, h in zip(gain, H, strict=True):
        assert abs(np.linalg.det(np.eye(2) - g * directional(SHARP, *SLOT) @ h)) < 1e-9


def test_a_full_slot_turned_by_a_quarter_shakes_at_the_same_depth():
    """A of a full slot commutes with turns about the tool, so x and y of the response may change places."""
    turned = MODES.response(GRID)[:, ::-1, ::-1] * np.array([[1, -1], [-1, 1]])
    assert_allclose(lobes(GRID, turned, SHARP, 4, *SLOT).least, border(*SLOT).least, rtol=1e-9)


@pytest.mark.full
@pytest.mark.parametrize(
    "immersion, low, high",
    [
        # the coefficients of a full slot cut by three or more even teeth are constant: the zeroth order leaves nothing
        # out, and 30 steps a tooth are worth 2 %
        (SLOT, 0.97, 1.03),
        # of half a slot harmonics are left out; six teeth keep them small, and the border stands too low
        ((np.pi / 2, np.pi), 0.97, 1.25),
    ],
)
def test_step_by_step_the_border_is_where_it_stands(immersion, low, high):
    found = border(*immersion, teeth=6)
    for speed in np.array([3_000, 5_000, 9_000]) * 2 * np.pi / 60:
        limit = float(found.limit(speed))
        sizes = [multiplier(MODES, SHARP, 6, *immersion, speed, share * limit, steps=30) for share in (low, high)]
        assert sizes[0] < 1 < sizes[1], (speed, limit, sizes)


def test_without_a_cut_a_mode_dies_by_its_own_damping():
    """Multiplier of no depth: exp(-zeta w_n T)."""
    T = 2 * np.pi / (4 * SPEED)
    found = multiplier(MODES, SHARP, 4, *SLOT, SPEED, 0.0, steps=40)
    assert_allclose(found, np.exp(-(MODES.damping * 2 * np.pi * FREQUENCY).min() * T), rtol=1e-6)


def test_twice_as_stiff_cuts_twice_as_deep():
    stiff = lobes(GRID, MODES.response(GRID) / 2, SHARP, 4, *SLOT)
    assert_allclose(stiff.least, 2 * border(*SLOT).least, rtol=1e-12)


def test_less_of_the_tool_in_the_stock_cuts_deeper():
    least = [border(np.pi - angle, np.pi).least for angle in (0.3, 0.8, 1.5, 3.0)]
    assert (np.diff(least) < 0).all()


def test_every_lobe_comes_down_to_the_depth_that_is_always_stable():
    found = border(*SLOT)
    speeds = np.linspace(2_000, 20_000, 400) * 2 * np.pi / 60
    limits = found.limit(speeds)
    assert (limits >= found.least * (1 - 1e-9)).all()
    assert limits.min() < 1.02 * found.least < limits.max() / 2


@pytest.mark.parametrize(
    "change, message",
    [
        ({"response": np.zeros((5, 2))}, "response: needs n frequencies and n x 2 x 2 responses, got .5, 2."),
        ({"frequency": [0.0, 1, 2, 3, 4]}, "frequency: frequencies must rise from above 0 Hz, got .0.0, 1.0. ..."),
        ({"response": np.full((5, 2, 2), np.nan)}, "response: must be finite"),
        ({"teeth": 0}, "teeth: must be at least 1, got 0"),
        ({"first": 3.0, "last": 3.0}, "first: no chip: a tooth must be in the stock from an angle to a later one"),
    ],
)
def test_a_response_that_is_none_is_refused(change, message):
    given = {"frequency": [1.0, 2, 3, 4, 5], "response": np.ones((5, 2, 2)), "teeth": 2, "first": 1.0, "last": 3.0}
    with pytest.raises(ExperimentError, match=message):
        lobes(K=SHARP, **(given | change))
