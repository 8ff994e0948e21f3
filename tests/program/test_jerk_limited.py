"""Jerk-limited profiles: closed forms, limits on random cells, and how far from the least time."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gough.errors import ProgramError
from gough.program.blocks import Arc, Block, Line, Rest
from gough.program.feed import Feed, Limits
from gough.program.path import Path
from gough.program.profiles.jerk_limited import jerk_limited
from gough.program.profiles.phases import Cells
from gough.program.profiles.trapezoid import trapezoid
from growth import growth

from .test_feed import chain, random_path

LIMITS = Limits(rapid=0.3, acceleration=2.0, angular_rate=1.0, angular_acceleration=5.0, jerk=50.0)


def cells_of(length, speed, acceleration=2.0, jerk=50.0, stop=(), pause=0.0):
    """Cells with these columns, numbers standing for all; `stop`: inner ends at which the feed stops."""
    length = np.asarray(length, float)
    n = len(length)
    columns = [np.broadcast_to(np.asarray(c, float), n) for c in (speed, acceleration, jerk, pause)]
    stops = np.isin(np.arange(n + 1), [0, n, *stop])
    return Cells(np.arange(n), np.zeros(n), length, *columns, stops)


def duration(*args, **more):
    return jerk_limited(cells_of(*args, **more)).times[-1]


def check_limits(cells, profile):
    """Caps, limits, jerk and continuity, at nine times of each phase; allowances are the rounding of absolute time."""
    phases, T = profile.phases, profile.times[-1]
    ulp = 4e-16 * max(T, 1e-9)
    begin, end = phases.times[:-1], phases.times[1:]
    t = begin[:, None] + (end - begin)[:, None] * np.linspace(0, 1, 9)
    k = np.repeat(np.arange(len(begin)), 9)
    x, v, a, j = phases.at(k, t.ravel())
    near = [np.clip(np.searchsorted(profile.times, t.ravel() + d, "right") - 1, 0, len(cells.length) - 1)
            for d in (-1e3 * ulp, 0, 1e3 * ulp)]  # fmt: skip
    speed, acceleration = (np.max([column[c] for c in near], 0) for column in (cells.speed, cells.acceleration))
    assert (v >= -1e-9 * speed).all()
    assert (v <= speed * (1 + 1e-9) + ulp * acceleration).all()
    # J T 1e-16 is what the rounding of time does to an acceleration
    assert (np.abs(a) <= acceleration * (1 + 1e-9) + 10 * ulp * cells.jerk[near[1]]).all()
    assert (np.abs(j) <= cells.jerk[near[1]] * (1 + 1e-12)).all()
    x, v, a = (q.reshape(-1, 9) for q in (x, v, a))
    moving = np.abs(begin[1:] - end[:-1]) <= ulp
    np.testing.assert_allclose(
        v[1:, 0][moving], v[:-1, -1][moving], rtol=1e-9, atol=1e-12 + 10 * ulp * acceleration.max()
    )
    np.testing.assert_allclose(
        a[1:, 0][moving], a[:-1, -1][moving], rtol=1e-9, atol=1e-12 + 20 * ulp * cells.jerk.max()
    )
    assert (x[:, -1] - x[:, 0]).sum() == pytest.approx(cells.length.sum(), rel=1e-12, abs=1e3 * ulp * cells.speed.max())
    assert np.all(np.diff(profile.times) >= 0)


# -- one line, rest to rest: the closed forms of docs/theory/feed.md, section 5 ----------------------------------


@pytest.mark.parametrize(
    "L, V, A, J, T",
    [
        (1.0, 0.1, 2.0, 50.0, 1.0 / 0.1 + 0.1 / 2.0 + 2.0 / 50.0),  # all seven phases
        (0.004, 10.0, 2.0, 1e3, 2.0 / 1e3 + np.sqrt((2.0 / 1e3) ** 2 + 4 * 0.004 / 2.0)),  # A, not V
        (0.1, 0.05, 2.0, 50.0, 0.1 / 0.05 + 2 * np.sqrt(0.05 / 50.0)),  # V, not A
        (1e-4, 0.1, 2.0, 50.0, 4 * (1e-4 / 100.0) ** (1 / 3)),  # neither
    ],
)
def test_time_of_one_line_is_the_closed_form(L, V, A, J, T):
    assert duration([L], V, A, J) == pytest.approx(T, rel=1e-14)


def test_a_line_cut_into_ten_thousand_takes_the_time_of_one():
    rng = np.random.default_rng(0)
    cut = rng.dirichlet(np.ones(10_000)) * 0.3
    assert duration(cut, 0.1) == pytest.approx(duration([0.3], 0.1), rel=1e-12)


def test_a_line_of_ten_thousand_faster_and_faster_cells_takes_the_time_of_one_that_binds_nowhere():
    """Caps above what the profile comes to change nothing, however many there are."""
    cut = np.full(10_000, 1e-6)
    free = 4 * (0.01 / 100.0) ** (1 / 3)
    assert duration(cut, 10 + np.random.default_rng(1).random(10_000), 1e3) == pytest.approx(free, rel=1e-12)


def test_pauses_and_stops_add_up():
    one = duration([0.1], 0.05)
    cells = cells_of([0.1, 0, 0.1, 0.1], [0.05, 0, 0.05, 0.05], stop=(1, 2, 3), pause=[0, 0.5, 0, 0])
    profile = jerk_limited(cells)
    np.testing.assert_allclose(profile.times, np.cumsum([0, one, 0.5, one, one]), rtol=1e-14)


# -- where the optimum is known -----------------------------------------------------------------------------------


def ramp(v0, v1, A=2.0, J=50.0):
    """Time and way between two speeds, a = 0 at both."""
    dv = abs(v1 - v0)
    t = dv / A + A / J if dv >= A * A / J else 2 * np.sqrt(dv / J)
    return t, (v0 + v1) / 2 * t


@pytest.mark.parametrize("slow, fast", [(0.02, 0.05), (0.05, 0.3), (0.001, 0.5)])
@pytest.mark.parametrize("way", [1, -1])
def test_two_feeds_on_one_line_join_by_one_ramp_in_the_faster_part(slow, fast, way):
    t0, d0 = ramp(0, slow)
    t1, d1 = ramp(slow, fast)
    t2, d2 = ramp(fast, 0)
    expected = t0 + (0.3 - d0) / slow + t1 + (0.5 - d1 - d2) / fast + t2
    assert duration([0.3, 0.5][::way], [slow, fast][::way]) == pytest.approx(expected, rel=1e-13)


@pytest.mark.parametrize("width", [1e-4, 1e-2])
def test_a_slow_window_in_a_line_is_run_at_its_feed_and_the_ramps_lie_outside(width):
    t0, d0 = ramp(0, 0.2)
    t1, d1 = ramp(0.2, 0.03)
    expected = 2 * t0 + 2 * t1 + 2 * (0.4 - d0 - d1) / 0.2 + width / 0.03
    assert duration([0.4, width, 0.4], [0.2, 0.03, 0.2]) == pytest.approx(expected, rel=1e-13)


def test_a_window_too_near_its_neighbour_is_left_with_one_peak_between():
    """Between the windows the profile is the symmetric one that rises and falls by jerk alone: 2 sqrt(dv / J) each."""
    d, v = 1e-3, 0.05
    profile = jerk_limited(cells_of([0.2, 1e-3, d, 1e-3, 0.2], [0.3, v, 0.3, v, 0.3]))
    t = profile.times[3] - profile.times[2]
    dv = 50.0 * (t / 4) ** 2
    assert (v + v + dv) / 2 * t == pytest.approx(d, rel=1e-12)


@pytest.mark.parametrize("seed", range(8))
def test_without_a_limit_of_jerk_it_is_the_trapezoid(seed):
    """The trapezoid is the least time of all without a jerk limit; with one, a ramp takes A / J longer.

    There is at most one ramp up and one down in a cell.
    """
    rng = np.random.default_rng(seed)
    n = 60
    cells = cells_of(10 ** rng.uniform(-3, -1, n), 10 ** rng.uniform(-2, -0.5, n), 10 ** rng.uniform(-0.5, 1, n), 1e6)
    fast, smooth = trapezoid(cells).times[-1], jerk_limited(cells).times[-1]
    assert fast <= smooth <= fast + 4 * n * cells.acceleration.max() / 1e6


@pytest.mark.parametrize("seed", range(8))
def test_a_path_driven_backwards_takes_the_same_time(seed):
    """Nothing in the limits knows a direction; the method, which goes backwards first, must not either."""
    rng = np.random.default_rng(seed)
    n = 30
    length, speed = 10 ** rng.uniform(-5, -2, n), 0.02 + 0.2 * rng.random(n)
    assert duration(length, speed) == pytest.approx(duration(length[::-1], speed[::-1]), rel=1e-9)


def test_higher_limits_never_take_longer_on_a_staircase_of_caps():
    rng = np.random.default_rng(5)
    length, speed = 10 ** rng.uniform(-4, -2, 30), 0.02 + 0.2 * rng.random(30)
    times = [duration(length, speed, 2.0, J) for J in (10, 30, 100, 300, 1e3, 1e4)]
    assert np.all(np.diff(times) < 0)


def numerical_optimum(cells, count=900, rounds=30):
    """Least time by linear programs on b = v^2 over a grid, |b''| sqrt(b) <= 2 J linearised where the last one was.

    From rest with the jerk J, b = (6 s / J)^(4/3) J^2 / 4 is the most there is; the grid does not see that by itself.
    Good to 2e-3: on one line it gives 0.2896 s for 0.29 s with 400 points, 0.2902 s with 1600.
    """
    import scipy.sparse as sp
    from scipy.optimize import linprog

    J, L = cells.jerk[0], cells.length.sum()
    X = np.concatenate([[0], np.cumsum(cells.length)])
    q = np.linspace(0, 1, count + 1)
    dense = np.minimum(np.minimum(q, 1 - q) / 0.06, 1) ** 2 + 1e-3
    s = np.concatenate([[0], np.cumsum((dense[1:] + dense[:-1]) / 2)])
    s = np.union1d(s / s[-1] * L, X)
    s = s[np.concatenate([[True], np.diff(s) > 1e-12 * L])]
    n, ds = len(s) - 1, np.diff(s)
    cell = [np.clip(np.searchsorted(X, s, side) - 1, 0, len(cells.length) - 1) for side in ("left", "right")]
    cap = np.minimum(*(cells.speed[c] for c in cell)) ** 2
    for d in (s, L - s):
        cap = np.minimum(cap, (6 * d / J) ** (4 / 3) * J * J / 4)
    A = cells.acceleration[np.searchsorted(X, (s[1:] + s[:-1]) / 2, "right") - 1]
    b = cap.copy()
    for i in range(n):
        b[i + 1] = min(b[i + 1], b[i] + 2 * A[i] * ds[i])
    for i in reversed(range(n)):
        b[i] = min(b[i], b[i + 1] + 2 * A[i] * ds[i])
    D = sp.diags([-1 / ds, 1 / ds], [0, 1], shape=(n, n + 1)).tocsr()
    h = (ds[1:] + ds[:-1]) / 2
    D2 = (sp.diags([-1 / h, 1 / h], [0, 1], shape=(n - 1, n)) @ D).tocsr()
    trust, T = 1.0, np.inf
    for k in range(rounds):
        ref = np.maximum(b, 1e-14)
        most = 3 * J / np.sqrt(ref[1:-1])
        G = sp.diags(J / ref[1:-1] ** 1.5) @ sp.eye(n + 1, format="csr")[1:-1]
        scale = np.concatenate([1 / most, 1 / most, 1 / (2 * A), 1 / (2 * A)])
        rows = sp.diags(scale) @ sp.vstack([D2 + G, -D2 + G, D, -D]).tocsr()
        low = 0 * b if k == 0 else b * (1 - trust)
        high = cap if k == 0 else np.minimum(cap, b * (1 + trust))
        v = np.sqrt(ref)
        w = ds / (v[1:] + v[:-1]) ** 2
        gain = np.concatenate([[0], w / v[1:]]) + np.concatenate([w / v[:-1], [0]])
        gain[[0, -1]] = 0
        found = linprog(-gain / gain.max(), rows, np.ones(len(scale)), bounds=np.stack([low, high], 1), method="highs")
        if found.status != 0:
            trust /= 2
            continue
        b = np.maximum(found.x, 0)
        v = np.sqrt(b)
        last, T = T, (2 * ds / (v[1:] + v[:-1])).sum()
        if k > 3:
            trust = max(trust * 0.8, 0.02)
        if abs(T - last) < 1e-6 * T:
            break
    return T


# the programs of linprog that come to an end; with other seeds its scaling fails
STAIRS = {3: 0.027, 7: 0.014, 10: 0.006, 13: 0.013, 15: 0.031, 18: 0.019, 25: 0.007, 28: 0.015, 31: 0.008, 32: 0.017}


@pytest.mark.slow
@pytest.mark.parametrize("seed, excess", STAIRS.items())
def test_staircases_of_cells_shorter_than_ramps_take_a_little_longer_than_the_numerical_optimum(seed, excess):
    """The optimum slows down before a rising step, to leave it with a > 0; ours does not.  Pinned: what that costs."""
    rng = np.random.default_rng(seed)
    n = rng.integers(2, 12)
    speed = 0.02 + 0.15 * rng.random(n)
    if seed % 3 == 1:
        speed = np.sort(speed)
    cells = cells_of(10 ** rng.uniform(-3.5, -2, n), speed)
    assert jerk_limited(cells).times[-1] / numerical_optimum(cells) - 1 == pytest.approx(excess, abs=2e-3)


# -- limits -----------------------------------------------------------------------------------------------------


def decades(low, high):
    return st.floats(np.log10(low), np.log10(high)).map(lambda p: 10.0**p)


CELL = st.tuples(decades(1e-9, 1.0), decades(1e-4, 3.0), decades(1e-2, 1e2), st.integers(0, 9))


@pytest.mark.full
@settings(max_examples=80, deadline=None)
@given(st.lists(CELL, min_size=1, max_size=40), decades(1.0, 1e5))
def test_limits_hold_on_any_cells(rows, jerk):
    length, speed, acceleration, stop = np.array(rows, float).T
    cells = cells_of(length, speed, acceleration, jerk, stop=np.flatnonzero(stop[1:] == 0) + 1)
    check_limits(cells, jerk_limited(cells))


@pytest.mark.full
@settings(max_examples=80, deadline=None)
@given(st.lists(st.tuples(decades(1e-5, 1e-2), st.floats(-0.03, 0.03)), min_size=2, max_size=80), decades(10, 1e4))
def test_limits_hold_on_staircases_that_are_shorter_than_their_ramps(rows, jerk):
    length, step = np.array(rows).T
    cells = cells_of(length, 0.03 + np.abs(np.cumsum(step)), 2.0, jerk)
    check_limits(cells, jerk_limited(cells))


@pytest.mark.parametrize("seed", range(4))
def test_limits_hold_through_thousands_of_cells(seed):
    rng = np.random.default_rng(seed)
    n = 5000
    shape = [
        0.02 + 0.1 * rng.random(n),
        0.06 + 0.04 * np.sin(np.arange(n) / 50) + 0.002 * rng.random(n),
        np.where(np.arange(n) % 2, 0.03, 0.1),
        np.where(rng.random(n) < 0.02, 0.001, 0.1),
    ][seed]
    cells = cells_of(rng.uniform(1e-4, 1e-3, n), shape, 1.5 + np.sin(np.arange(n) / 7), 50.0)
    check_limits(cells, jerk_limited(cells))


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(10))
def test_limits_hold_on_many_random_cells(seed):
    rng = np.random.default_rng(1000 + seed)
    for _ in range(200):
        n = rng.integers(1, 60)
        low = 10 ** rng.uniform([-9, -4, -2], [-1, 0, 1])
        length, speed, acceleration = (
            10 ** rng.uniform(np.log10(a), b, n) for a, b in zip(low, (0, 0.5, 2), strict=True)
        )
        cells = cells_of(length, speed, acceleration, 10 ** rng.uniform(0, 5), np.flatnonzero(rng.random(n) < 0.05))
        check_limits(cells, jerk_limited(cells))


@pytest.mark.full
def test_the_time_of_a_profile_grows_with_the_cells_half_of_them_valleys():
    def cells(n):
        rng = np.random.default_rng(0)
        return cells_of(rng.uniform(1e-4, 1e-3, n), np.where(np.arange(n) % 2, 0.02 + 0.02 * rng.random(n), 0.1))

    assert (
        growth(cells, jerk_limited, 5000) < 2
    )  # 2: caches and the garbage collector's passes; anything quadratic would be 8


# -- on paths ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("corner", ["stop", "constant"])
def test_position_speed_and_acceleration_are_each_others_derivatives(seed, corner):
    path = random_path(seed)
    feed = Feed(path, LIMITS, corner, "jerk_limited")
    t = np.linspace(0, feed.duration, 20_001)
    i, u, ud, udd, uddd = feed.at(t)
    assert (ud >= 0).all()
    assert (ud <= feed.speed[i] * (1 + 1e-9)).all()
    assert (np.abs(udd) <= feed.acceleration[i] * (1 + 1e-9)).all()
    assert (np.abs(uddd) <= feed.jerk[i] * (1 + 1e-9)).all()
    whole = np.concatenate([[0], np.cumsum(path.extent)])[i] + u
    step = t[1] - t[0]
    # in one phase the speed is a parabola: Simpson's rule, with the middle by the jerk, is exact
    within = (i[1:] == i[:-1]) & (feed.profile.phases.find(t[1:]) == feed.profile.phases.find(t[:-1]))
    assert within.mean() > 0.8
    middle = (ud[1:] + ud[:-1]) / 2 - uddd[:-1] * step**2 / 8
    way = (ud[1:] + 4 * middle + ud[:-1]) / 6 * step
    np.testing.assert_allclose(np.diff(whole)[within], way[within], atol=1e-13)
    np.testing.assert_allclose(np.diff(ud)[within], ((udd[1:] + udd[:-1]) / 2 * step)[within], atol=1e-12)
    np.testing.assert_allclose(np.diff(udd)[within], (uddd[:-1] * step)[within], atol=1e-10)


def test_every_block_begins_and_ends_at_its_times():
    path = random_path(4)
    feed = Feed(path, LIMITS, "constant", "jerk_limited")
    begin = feed.at(feed.times[:-1])
    np.testing.assert_array_equal(begin.block, np.arange(len(path)))
    np.testing.assert_allclose(begin.u, 0, atol=1e-12)
    end = feed.at(feed.times[1:] - 1e-12)
    np.testing.assert_array_equal(end.block, np.arange(len(path)))
    np.testing.assert_allclose(end.u, path.extent, atol=2e-12)


def test_a_row_depends_on_its_own_time_alone():
    feed = Feed(random_path(2), LIMITS, None, "jerk_limited")
    t = np.linspace(-0.1, feed.duration + 0.1, 3001)
    whole = feed.at(t)
    for column, *parts in zip(whole, feed.at(t[:777]), feed.at(t[777:778]), feed.at(t[778:]), strict=True):
        assert column.tobytes() == np.concatenate(parts).astype(column.dtype).tobytes()


def test_a_circle_takes_the_closed_form_at_its_lowest_limit():
    """Radius 5 mm: v^2 / r <= 2 m/s2 gives 0.1 m/s, v^3 / r^2 <= 50 m/s3 gives 0.1077 m/s."""
    path = Path([Block(Arc((0.005, 0, 0), (0, 0, 0), (0, 0, 1), 6.0), feed=0.3)])
    feed = Feed(path, LIMITS, None, "jerk_limited")
    assert feed.speed[0] == pytest.approx(0.1, rel=1e-14)
    assert feed.duration == pytest.approx(0.03 / 0.1 + 0.1 / 2.0 + 2.0 / 50.0, rel=1e-13)


def test_the_feed_on_a_small_arc_is_bounded_by_the_jerk_of_steady_motion():
    path = Path([Block(Arc((5e-4, 0, 0), (0, 0, 0), (0, 0, 1), 6.0), feed=0.3)])
    assert Feed(path, LIMITS, None, "jerk_limited").speed[0] == pytest.approx((50.0 * 5e-4**2) ** (1 / 3), rel=1e-13)
    # a trapezoid has no jerk to keep
    assert Feed(path, LIMITS, None, "trapezoid").speed[0] == pytest.approx(np.sqrt(2.0 * 5e-4), rel=1e-14)


def test_a_turn_at_rest_has_the_jerk_in_the_ratio_of_its_accelerations():
    path = Path([Block(Rest((0, 0, 0)), (0, 0, 0), (0.3, 0, 0), feed=0.2)])
    J = 50.0 * 5.0 / 2.0
    assert Feed(path, LIMITS, None, "jerk_limited").duration == pytest.approx(
        0.3 / 0.2 + 2 * np.sqrt(0.2 / J), rel=1e-13
    )


def test_a_jerk_limited_profile_without_a_jerk_says_what_to_write():
    with pytest.raises(ProgramError) as error:
        Feed(chain([(0, 0, 0), (1, 0, 0)]), LIMITS._replace(jerk=None), None, "jerk_limited")
    assert str(error.value) == (
        'jerk: a jerk-limited profile needs a jerk; write jerk = "50 m/s3" in [program], or in [feed] of the machine'
    )


# -- junctions by tolerance -------------------------------------------------------------------------------------


STRAIGHT = [(0, 0, 0), (0.1, 0, 0), (0.2, 0, 0)]


@pytest.mark.parametrize("profile", ["trapezoid", "jerk_limited"])
@pytest.mark.parametrize(
    "tolerance, corner, stop", [(-1, None, True), (0, None, False), (1e-5, None, False), (-1, "constant", False)]
)
def test_an_exact_stop_stops_on_a_straight_line_too(tolerance, corner, stop, profile):
    feed = Feed(chain(STRAIGHT, tolerance=tolerance), LIMITS, corner, profile)
    assert (feed.at(feed.times[1:2]).ud[0] == 0) == stop


@pytest.mark.parametrize("tolerance, stop", [(0, True), (1e-5, False)])
def test_a_rapid_runs_into_a_feed_move_only_where_a_tolerance_lets_it(tolerance, stop):
    blocks = [
        Block(Line(STRAIGHT[0], STRAIGHT[1]), rapid=True, tolerance=tolerance),
        Block(Line(STRAIGHT[1], STRAIGHT[2]), feed=0.05),
    ]
    feed = Feed(Path(blocks), LIMITS)
    assert feed.at(feed.times[1:2]).ud[0] == (0 if stop else 0.05)


def test_a_corner_that_no_blend_took_away_stops_the_feed_whatever_its_tolerance():
    feed = Feed(chain([(0, 0, 0), (0.1, 0, 0), (0.1, 0.1, 0)], tolerance=1e-3), LIMITS)
    assert feed.at(feed.times[1:2]).ud[0] == 0


def test_another_tool_stops_the_feed():
    blocks = [
        Block(Line((0, 0, 0), (0.1, 0, 0)), feed=0.05),
        Block(Line((0.1, 0, -0.01), (0.2, 0, -0.01)), feed=0.05, tool=(0, 0, 0.01)),
    ]
    feed = Feed(Path(blocks), LIMITS)
    assert feed.at(feed.times[1:2]).ud[0] == 0
