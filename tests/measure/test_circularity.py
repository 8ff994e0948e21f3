"""Circular tests on circles whose errors are known."""

import numpy as np
import pytest

from gough.errors import LogError
from gough.frames import rotation_of_abc_np
from gough.measure import bidirectional_error, circularity

CIRCLE = {
    "id": 1, "line": 4, "center": [0.1, 0.2, -1.0], "radius": 0.05, "normal": [0, 0, 1], "feed": 0.04, "ccw": True
}  # fmt: skip
ANGLE = np.linspace(0, 2 * np.pi, 2001)


def run(radial, shift=(0, 0), circle=CIRCLE, angle=ANGLE):
    """Tool positions with a radial error over the angle, on a circle moved in the plane."""
    r = circle["radius"] + radial(angle)
    flat = np.stack([r * np.cos(angle) + shift[0], r * np.sin(angle) + shift[1], 0 * angle], 1)
    return flat + circle["center"]


def test_a_circle_too_large_has_a_radius_error_and_no_circular_error():
    found = circularity(run(lambda a: 3e-6 + 0 * a), CIRCLE)
    assert found.mean_radial_error == pytest.approx(3e-6, rel=1e-9)
    assert found.radius_error == pytest.approx(3e-6, rel=1e-9)
    assert found.circular_error == pytest.approx(0, abs=1e-15)


def test_a_circle_beside_its_place_has_a_centre_error_and_no_circular_error():
    found = circularity(run(lambda a: 0 * a, (2e-6, -1e-6)), CIRCLE)
    np.testing.assert_allclose(found.center_error, (2e-6, -1e-6), rtol=1e-6)
    assert found.circular_error < 1e-11
    assert found.largest_radial_error == pytest.approx(np.hypot(2e-6, 1e-6), rel=1e-4)
    assert found.smallest_radial_error == pytest.approx(-np.hypot(2e-6, 1e-6), rel=1e-4)


@pytest.mark.parametrize("waves", [2, 3, 5])
def test_a_wave_around_the_circle_is_its_circular_error(waves):
    found = circularity(run(lambda a: 4e-6 * np.cos(waves * a)), CIRCLE)
    assert found.circular_error == pytest.approx(8e-6, rel=1e-3)  # the wave moves the fit by second-order terms
    assert found.mean_radial_error == pytest.approx(0, abs=1e-9)


def test_a_tool_that_lingers_does_not_weigh_more():
    """Half the samples on a tenth of the circle, where the radius is 10 um too large."""
    slow = np.concatenate([np.linspace(0, 0.2 * np.pi, 1001), np.linspace(0.2 * np.pi, 2 * np.pi, 1001)[1:]])
    found = circularity(run(lambda a: np.where(a < 0.2 * np.pi, 10e-6, 0.0), angle=slow), CIRCLE)
    assert found.mean_radial_error == pytest.approx(1e-6, rel=0.01)


def test_a_circle_in_any_plane_is_judged_alike():
    R = rotation_of_abc_np(np.array([0.4, -0.6, 0.0]))
    flat = run(lambda a: 4e-6 * np.cos(2 * a)) - CIRCLE["center"]
    tilted = {**CIRCLE, "normal": list(R[:, 2])}
    a, b = circularity(flat + CIRCLE["center"], CIRCLE), circularity(flat @ R.T + CIRCLE["center"], tilted)
    assert b.circular_error == pytest.approx(a.circular_error, rel=1e-9)
    np.testing.assert_allclose(b.radial_error, a.radial_error, atol=1e-15)


def test_clockwise_and_counter_clockwise_share_their_angles():
    p = run(lambda a: 0 * a)
    left = circularity(p, CIRCLE)
    right = circularity(p[::-1], {**CIRCLE, "normal": [0, 0, -1], "ccw": False})
    np.testing.assert_allclose(right.angle[::-1], left.angle, atol=1e-9)
    assert left.angle[250] == pytest.approx(ANGLE[250], abs=1e-12)  # from x towards y


def test_the_bidirectional_error_sees_what_each_way_alone_does_not():
    """Backlash of a kind: clockwise the circle is 2 um larger than counter-clockwise."""
    wide, narrow = (circularity(run(lambda a, e=e: e + 0 * a), CIRCLE) for e in (1e-6, -1e-6))
    assert wide.circular_error < 1e-15
    assert narrow.circular_error < 1e-15
    assert bidirectional_error([wide, narrow]) == pytest.approx(2e-6, rel=1e-6)


@pytest.mark.parametrize("p", [np.zeros((2, 3)), np.full((10, 3), np.nan)])
def test_too_few_or_wrong_positions_are_refused(p):
    with pytest.raises(LogError, match="three or more finite positions"):
        circularity(p, CIRCLE)
