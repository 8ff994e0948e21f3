"""Thinning keeps what matters, units read well, circles are drawn where they were."""

import numpy as np
import pytest

from conftest import make_log
from gough.errors import LogError
from gough.log import Log
from gough.report import prepare


@pytest.mark.parametrize("n", [0, 1, 3999, 4000, 4001, 10_007, 123_456])
def test_thinning_keeps_first_last_and_extremes_within_the_limit(n):
    rng = np.random.default_rng(n)
    y = rng.standard_normal(n)
    rows = prepare.thin(y)
    assert len(rows) <= prepare.LIMIT and np.all(np.diff(rows) > 0)
    if n:
        assert rows[0] == 0 and rows[-1] == n - 1
        assert y[rows].max() == y.max() and y[rows].min() == y.min()


def test_thinning_keeps_a_peak_of_one_sample_wherever_it_is():
    for place in np.random.default_rng(0).integers(0, 50_000, 200):
        y = np.zeros(50_000)
        y[place] = 1.0
        assert place in prepare.thin(y)


def test_beside_every_sample_one_at_least_as_large_is_drawn():
    y = np.abs(np.random.default_rng(3).standard_normal(80_000))
    rows = prepare.thin(y)
    width = -(-80_000 // ((prepare.LIMIT - 4) // 3))  # of a bin, 61 rows
    drawn = np.zeros_like(y)
    drawn[rows] = y[rows]
    for k in range(0, 80_000, 7):
        assert drawn[max(0, k - width) : k + width + 1].max() >= y[k]


def test_thinning_leaves_a_gap_where_there_is_nan_and_all_nan_is_no_error():
    y = np.ones(50_000)
    y[20_000:20_100] = np.nan
    rows = prepare.thin(y)
    assert np.isnan(y[rows]).any() and np.isfinite(y[rows]).any()
    assert np.isnan(np.full(50_000, np.nan)[prepare.thin(np.full(50_000, np.nan))]).all()


def test_the_rows_of_a_path_hold_its_largest_error_and_no_long_stretch_is_left_out():
    error = np.zeros(60_000)
    error[31_234] = 1.0
    rows = prepare.path_rows(error)
    assert 31_234 in rows and len(rows) <= prepare.LIMIT
    assert np.diff(rows).max() <= 60_000 / (prepare.LIMIT // 2) + 1


@pytest.mark.parametrize(
    ("values", "unit", "shown"),
    [
        ([3.2e-6], "m", "µm"),
        ([0.9999e-3, 1e-9], "m", "mm"),
        ([-0.5], "m", "mm"),
        ([450.0], "N", "N"),
        ([4500], "N", "kN"),
        ([0.037], "m/s", "mm/s"),
        ([2e-6], "rad", "µrad"),
        ([0.0], "m", "m"),
        ([np.nan], "m", "m"),
        ([], "N", "N"),
    ],
)
def test_the_unit_shown_is_the_one_in_which_the_largest_value_is_at_least_one(values, unit, shown):
    assert prepare.scale_for(values, unit).unit == shown


def test_a_value_times_its_scale_is_the_value_in_that_unit():
    assert prepare.scale_for([3.2e-6], "m").times * 3.2e-6 == pytest.approx(3.2, rel=1e-15)


@pytest.mark.parametrize("largest", [1e-7, 3.3e-6, 1e-4, 0.04])
def test_the_magnification_is_a_round_number_and_fills_the_picture(largest):
    times = prepare.magnification(0.1, [np.array([0.0, -largest, np.nan])])
    assert float(f"{times:e}"[0]) in (1, 2, 5) and f"{times:.0e}" == f"{times:e}".replace(".000000", "")
    # the steps 1 2 5 are at most 2.5 apart
    assert 0.3 / 2.5 < times * largest / 0.1 <= 0.3 * (1 + 1e-12)


@pytest.mark.parametrize(
    ("normal", "axes", "right", "up"),
    [
        ([0, 0, 1], ("+x", "+y"), 0, 1),
        ([0, 0, -1], ("+x", "+y"), 0, 1),
        ([1, 0, 0], ("+y", "+z"), 1, 2),
        ([0, 1, 0], ("-x", "+z"), 0, 2),
    ],
)
def test_a_bump_of_a_circle_is_drawn_on_its_own_side(normal, axes, right, up):
    phi = np.linspace(0, 2 * np.pi, 721)[:-1]
    sign = -1 if axes[0][0] == "-" else 1
    p = np.zeros((720, 3))
    p[:, right], p[:, up] = 0.05 * np.cos(phi) * sign, 0.05 * np.sin(phi)
    error = np.where(np.arange(720) == 60, 1e-5, 0)  # 30 degrees from right to up
    task = tuple((name, "m") for name in "xyz")
    info = {"circles": [{"id": 1, "line": 3, "center": [0, 0, 0], "radius": 0.05, "normal": normal, "feed": 0.05}]}
    values = {"x": p, "circle": np.ones(720, int), "radial_error": error}
    log = Log.build(np.arange(720.0), values, task=task, joints=3, info=info)
    (circle,) = prepare.circles(log)
    x, y = prepare.magnified(circle, 1000)
    assert circle.axes == axes and circle.full
    assert np.argmax(np.hypot(x, y)) == 60
    # 0.05 m + 1000 times 10 um, at 30 degrees
    np.testing.assert_allclose([x[60], y[60]], [0.06 * np.cos(np.pi / 6), 0.06 * 0.5], atol=1e-15)


def test_an_arc_is_drawn_only_where_there_is_no_full_circle():
    log = make_log(seconds=20.0, rate=100)  # ends in the second circle
    first, second = prepare.circles(log)
    assert first.full and not second.full
    assert prepare.circle_numbers([log]) == [1]
    arc = make_log(seconds=5.0, rate=100)
    assert prepare.circle_numbers([arc]) == [1]


def test_a_path_is_seen_from_where_it_extends_least():
    p = np.random.default_rng(0).uniform(-1, 1, (100, 3))
    for flat, label in ((0, "yz"), (1, "xz"), (2, "xy")):
        q = p.copy()
        q[:, flat] *= 0.01
        q[5, flat] = np.nan
        assert prepare.plane_of([q]).label == label
    assert prepare.plane_of([np.zeros((4, 3))]).label == "xy"


def test_spans_are_the_times_where_the_flag_holds():
    t = np.arange(6.0)
    assert prepare.spans(np.array([1, 1, 0, 0, 1, 1]), t) == [(0.0, 2.0), (4.0, 5.0)]
    assert prepare.spans(np.zeros(6), t) == []
    assert prepare.spans(np.zeros(0), np.zeros(0)) == []


def test_logs_of_one_controller_are_told_apart(short):
    assert prepare.labels([short]) == ["pid"]
    assert prepare.labels([short, short]) == ["pid_1", "pid_2"]
    assert prepare.human("pid_1") == "PID 1" and prepare.human("computed_torque") == "computed torque"


def test_no_log_and_a_batch_of_runs_are_refused():
    with pytest.raises(LogError, match="no log"):
        prepare.as_logs([])
    batch = Log.build(np.arange(2.0), {"lag": np.zeros((2, 3))}, task=(), joints=0, info={}, runs=3)
    with pytest.raises(LogError, match=r"log\.run\(0\)"):
        prepare.as_logs(batch)
