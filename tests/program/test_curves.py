"""Quintics by arc length: against quadrature, dense samples and differences; chunks, speed."""

import numpy as np
import pytest
from scipy.integrate import quad

from gough.frames import rotation_of_abc_np
from gough.program.curves import Curves, hermite, restricted
from gough.program.segments import norm
from growth import growth


def corners(m, seed=0, d=1e-3, most=2.6):
    """Blends of two lines that turn by up to `most` rad, somewhere in space."""
    rng = np.random.default_rng(seed)
    phi = rng.uniform(0.01, most, m)
    t1, t2 = np.tile([1.0, 0, 0], (m, 1)), np.stack([np.cos(phi), np.sin(phi), 0 * phi], 1)
    C, none = rng.normal(size=(m, 3)) * 0.1, np.zeros((m, 3))
    return hermite(C - d * t1, C + d * t2, 2 * d * t1, 2 * d * t2, none, none)


def bends(m, seed=1):
    """Quintics of any shape with a speed well above zero: a line with some of everything else."""
    rng = np.random.default_rng(seed)
    c = rng.normal(size=(m, 6, 3)) * np.array([1.0, 0, 0.3, 0.2, 0.1, 0.1])[:, None] * 1e-2
    c[:, 1] = np.array([1.0, 0.5, -0.3]) * 2e-2
    return c


BOTH = pytest.mark.parametrize("shape", [corners, bends])


@BOTH
def test_length_and_parameter_agree_with_quadrature(shape):
    c = shape(30)
    curves = Curves(c)
    for k in range(30):

        def speed(t, c=c[k]):
            return np.linalg.norm(sum(j * c[j] * t ** (j - 1) for j in range(1, 6)))

        for t in (0.3, 1.0):
            known = sum(quad(speed, a * t / 4, (a + 1) * t / 4, epsabs=0, epsrel=1e-13)[0] for a in range(4))
            # two quadratures that each end at 1e-12 of the length or better
            assert curves.arc_length(np.array([k]), np.array([t]))[0] == pytest.approx(known, rel=3e-12)
    i, s = np.repeat(np.arange(30), 50), np.tile(np.linspace(0, 1, 50), 30)
    s = s * curves.length[i]
    # a Newton step of 1e-9 is the last: what remains is its square
    np.testing.assert_allclose(curves.arc_length(i, curves.parameter(i, s)), s, rtol=0, atol=1e-15)
    np.testing.assert_array_equal(curves.parameter(np.arange(30), curves.length), 1.0)


@BOTH
def test_tangent_and_bend_are_derivatives_by_arc_length(shape):
    curves = Curves(shape(40))
    i = np.repeat(np.arange(40), 21)
    L = curves.length[i]
    s = (0.01 + 0.98 * np.tile(np.linspace(0, 1, 21), 40)) * L
    h = 1e-4 * L  # differences of p err by h^2 p''' / 6, and by rounding 1e-16 / h
    p, T, K = curves.frame(i, s)
    (p0, T0, K0), (p1, T1, K1) = curves.frame(i, s - h), curves.frame(i, s + h)
    third = curves.third()[i]
    assert (norm((p1 - p0) / (2 * h)[:, None] - T) <= h**2 * third / 6 + 3e-16 / h).all()
    np.testing.assert_allclose(norm(T), 1, rtol=1e-14)
    # the fourth derivative of these shapes is below 50 times the third over the length
    assert (norm((T1 - T0) / (2 * h)[:, None] - K) <= h**2 * 50 * third / L + 3e-16 / h).all()
    assert np.abs((T * K).sum(1)).max() <= 1e-13 * norm(K).max()
    assert (norm(K1 - K0) / (2 * h) <= third * (1 + 1e-6)).all()


@pytest.mark.quick("bends")
@BOTH
def test_sharpest_and_third_are_never_below_the_maximum_and_at_most_a_thousandth_above(shape):
    curves = Curves(shape(100, seed=4))
    n = 4001
    i = np.repeat(np.arange(100), n)
    s = np.tile(np.linspace(0, 1, n), 100) * curves.length[i]
    bend = curves.bend(i, s).reshape(100, n, 3)
    sharpest = norm(bend).max(1)
    assert (curves.sharpest() >= sharpest).all()
    assert (curves.sharpest() <= sharpest * 1.001).all()
    h = curves.length / (n - 1)
    rate = norm(np.diff(bend, axis=1)).max(1) / h
    assert (curves.third() >= rate * (1 - 1e-9)).all()
    # at the ends, where the maximum often is, differences of the second order
    for a, b, c in ((0, 1, 2), (-1, -2, -3)):
        rate = np.maximum(rate, norm(3 * bend[:, a] - 4 * bend[:, b] + bend[:, c]) / (2 * h))
    assert (curves.third() <= rate * 1.001).all()


@pytest.mark.quick("bends")
@BOTH
def test_closest_point_agrees_with_a_dense_search(shape):
    curves = Curves(shape(20, seed=2))
    rng = np.random.default_rng(3)
    i = np.repeat(np.arange(20), 8)
    L = curves.length[i]
    p = curves.point(i, rng.uniform(0, 1, len(i)) * L) + rng.normal(size=(len(i), 3)) * L[:, None] * 0.2
    cut = np.sort(rng.uniform(0, 1, (len(i), 2)), axis=1) * L[:, None]
    cut[::2] = np.stack([0 * L, L], 1)[::2]
    s = curves.closest(i, p, cut[:, 0], cut[:, 1], cut[:, 0])
    assert ((s >= cut[:, 0]) & (s <= cut[:, 1])).all()
    found = norm(p - curves.point(i, s))
    grid = np.linspace(0, 1, 2001)
    for k in range(len(i)):
        u = cut[k, 0] + grid * (cut[k, 1] - cut[k, 0])
        dense = norm(p[k] - curves.point(np.full(2001, i[k]), u)).min()
        assert found[k] <= dense + 1e-15
        assert found[k] >= dense - (cut[k, 1] - cut[k, 0]) / 4000


def test_a_chunk_is_the_whole_bit_for_bit_and_nan_touches_no_other_row():
    curves = Curves(corners(300))
    rng = np.random.default_rng(5)
    i = rng.integers(0, 300, 9000)
    s = rng.uniform(0, 1, 9000) * curves.length[i]
    whole = curves.frame(i, s)
    for a, b in ((0, 1), (1, 4100), (4100, 9000)):
        for part, column in zip(curves.frame(i[a:b], s[a:b]), whole, strict=True):
            np.testing.assert_array_equal(part, column[a:b])
    p = whole[0] + 1e-4
    near = curves.closest(i[:500], p[:500], 0 * s[:500], curves.length[i[:500]], s[:500])
    p[7] = np.nan
    again = curves.closest(i[:500], p[:500], 0 * s[:500], curves.length[i[:500]], s[:500])
    assert np.isnan(again[7])
    np.testing.assert_array_equal(np.delete(again, 7), np.delete(near, 7))


@BOTH
def test_a_part_of_a_curve_is_that_part(shape):
    curves = Curves(shape(50))
    i = np.arange(50)
    lo, hi = 0.2 * curves.length, 0.9 * curves.length
    part = curves.cut(i, lo, hi)
    np.testing.assert_allclose(part.length, hi - lo, rtol=1e-11)
    for x in (0.0, 0.3, 1.0):
        for a, b in zip(part.frame(i, x * part.length), curves.frame(i, lo + x * (hi - lo)), strict=True):
            np.testing.assert_allclose(a, b, atol=1e-9 * np.abs(b).max())


def test_restricted_is_the_same_polynomial():
    c = bends(10)
    t0, t1 = np.full(10, 0.25), np.full(10, 0.75)
    part = restricted(c, t0, t1)
    for x in (0.0, 0.4, 1.0):
        t = 0.25 + 0.5 * x
        powers, own = t ** np.arange(6)[:, None], x ** np.arange(6)[:, None]
        np.testing.assert_allclose((part * own).sum(1), (c * powers).sum(1), rtol=1e-13)


def test_hermite_has_the_ends_it_is_given():
    rng = np.random.default_rng(6)
    ends = rng.normal(size=(6, 20, 3))
    c = hermite(*ends)
    np.testing.assert_allclose(c[:, 0], ends[0])
    np.testing.assert_allclose(c.sum(1), ends[1], atol=1e-13)
    np.testing.assert_allclose(c[:, 1], ends[2])
    np.testing.assert_allclose((c * np.arange(6)[:, None]).sum(1), ends[3], atol=1e-12)
    np.testing.assert_allclose(2 * c[:, 2], ends[4])
    np.testing.assert_allclose((c * np.array([0, 0, 2, 6, 12, 20.0])[:, None]).sum(1), ends[5], atol=1e-12)


def test_placed_curves_are_the_same_curves_moved():
    curves = Curves(bends(10))
    R, p = rotation_of_abc_np(np.array([0.3, -0.2, 1.0])), np.array([1.0, 2, 3])
    moved, i, s = curves.placed(p, R), np.arange(10), 0.3 * curves.length
    np.testing.assert_allclose(moved.point(i, s), p + curves.point(i, s) @ R.T, atol=1e-15)
    np.testing.assert_allclose(moved.bend(i, s), curves.bend(i, s) @ R.T, atol=1e-10)


@pytest.mark.full
def test_the_time_of_curves_grows_with_their_number():
    def asked(curves):
        i = np.random.default_rng(7).integers(0, len(curves.length), len(curves.length))
        curves.frame(i, curves.length[i] / 3)

    assert (
        growth(corners, Curves, 5000) < 2
    )  # 2: caches and the garbage collector's passes; anything quadratic would be 8
    assert growth(lambda n: Curves(corners(n)), asked, 5000) < 2
