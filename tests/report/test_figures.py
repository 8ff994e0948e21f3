"""Figures show what the log holds, with units, and touch nothing that others use."""

import sys
from concurrent.futures import ThreadPoolExecutor

import matplotlib
import numpy as np
import pytest

from conftest import TASK, make_log
from gough.errors import LogError
from gough.log.build import LogBuilder
from gough.report import figures, style
from gough.report.figures import circle, contour_error, forces, path, save_all, tracking, velocities
from gough.report.prepare import force_range

ALL = {
    "contour_error": contour_error,
    "path": path,
    "circle": circle,
    "forces": forces,
    "velocities": velocities,
    "tracking": tracking,
}


@pytest.mark.parametrize("figure", ALL.values(), ids=ALL)
def test_a_figure_draws_into_the_axes_it_is_given_and_labels_have_units(figure, short):
    ax = style.new_axes()
    assert figure(short, ax=ax) is ax
    for label in (ax.get_xlabel(), ax.get_ylabel()):
        assert label.endswith("]") and "[" in label
    assert ax.get_title(loc="left")


def test_the_line_of_contour_error_holds_the_largest_error(logs):
    ax = contour_error(logs)
    for line, log in zip(ax.lines[:2], logs, strict=True):
        assert line.get_ydata().max() * 1e-6 == pytest.approx(log["contour_error"].max(), rel=1e-12)
        assert len(line.get_xdata()) <= 4000
    assert "[µm]" in ax.get_ylabel()


def test_the_nc_line_of_the_largest_counted_contour_error_stands_at_its_place(logs):
    ax = contour_error(logs)
    for text, log in zip(ax.texts, logs, strict=True):
        error = log.metrics["contour_error"]
        assert text.get_text().strip() == f"NC line {error['line']:.0f}"
        assert text.xy == pytest.approx((error["at"], 1e6 * error["max"]), rel=1e-12)


def test_velocity_reversals_are_marked_at_their_times(logs):
    ax = contour_error(logs)
    times = [entry["time"] for entry in logs[1].info["reversals"]]
    np.testing.assert_array_equal(np.sort(ax.lines[3].get_xdata()), np.sort(times))
    assert ax.lines[3].get_color() == ax.lines[1].get_color()


def test_lines_of_forces_velocities_and_tracking_are_those_of_the_log(short):
    np.testing.assert_allclose(forces(short).lines[4].get_ydata(), short["u"][:, 4])
    np.testing.assert_allclose(tracking(short).lines[2].get_ydata(), 1e6 * (short["q_r"] - short["q"])[:, 2])
    # central differences of q over 20 ms, in mm/s
    q = 1e3 * short["q"][:, 1]
    np.testing.assert_allclose(velocities(short).lines[1].get_ydata()[5], (q[6] - q[4]) / 0.02, rtol=1e-9)


def test_a_circle_says_its_magnification_and_draws_outside_as_outside(logs):
    ax = circle(logs, 1)
    title = ax.get_title(loc="left")
    assert "× 2000" in title and "outside +" in title
    drawn = {line.get_label(): np.hypot(*line.get_data()) for line in ax.lines}
    assert drawn["programmed circle"] == pytest.approx(100)
    rows = logs[0]["circle"] == 1
    # 100 mm, and 2000 times the largest radial error; the angle is that of the true tip
    assert drawn["PID"].max() == pytest.approx(100 + 2000 * 1e3 * logs[0]["radial_error"][rows].max(), rel=1e-9)


def test_a_circle_that_is_not_there_is_an_error_with_those_that_are(logs):
    with pytest.raises(LogError, match="got 7; there is 1, 2"):
        circle(logs, 7)


def test_the_path_is_coloured_by_the_larger_error_of_each_piece(logs):
    (pieces,) = path(logs[0]).collections
    error = logs[0]["contour_error"][logs[0]["counted"] == 1]
    assert pieces.get_array().max() * 1e-6 == pytest.approx(error.max(), rel=1e-12)


def test_what_is_not_counted_is_not_coloured():
    log = make_log(seconds=30.0)
    log.dataset["counted"].values[5000:9000] = 0
    log.dataset["contour_error"].values[5000:9000] = 1.0
    (pieces,) = path(log).collections
    assert pieces.get_array().max() < 100  # um


def test_figures_of_forces_can_share_what_their_axes_show(short, logs):
    span = force_range([short, logs[1]])
    assert span == (min(log["u"].min() for log in (short, logs[1])), max(log["u"].max() for log in (short, logs[1])))
    ends = [forces(log, span=span).get_ylim() for log in (short, logs[1])]
    assert ends[0] == ends[1] and ends[0][0] < span[0] < span[1] < ends[0][1]


def test_log_plot_leads_to_the_figures(short):
    assert "Contour error" in short.plot.contour().get_title(loc="left")
    assert "Circle 1" in short.plot.circle().get_title(loc="left")
    assert "[N]" in short.plot.forces().get_ylabel()


def test_figures_leave_pyplot_and_the_shared_settings_alone(short, monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib.pyplot", None)  # importing it is an error now
    names = set(matplotlib.rcParams) - {"backend"}  # reading that one imports pyplot
    before = {name: matplotlib.rcParams[name] for name in names}
    for figure in ALL.values():
        figure(short)
    assert {name: matplotlib.rcParams[name] for name in names} == before


@pytest.mark.full
def test_figures_can_be_drawn_in_threads(short, tmp_path):
    with ThreadPoolExecutor(2) as pool:
        done = list(pool.map(lambda k: save_all(short, tmp_path / str(k)), range(2)))
    assert [p.read_bytes() for p in done[0]] == [p.read_bytes() for p in done[1]]


@pytest.mark.full
def test_no_picture_is_blank(logs, tmp_path):
    from matplotlib.image import imread

    paths = save_all(logs, tmp_path)
    assert [p.name for p in paths] == [
        "contour_error.png",
        "circle_1.png",
        "circle_2.png",
        "path_pid.png",
        "forces_pid.png",
        "velocities_pid.png",
        "tracking_pid.png",
        "path_computed_torque.png",
        "forces_computed_torque.png",
        "velocities_computed_torque.png",
        "tracking_computed_torque.png",
    ]
    for p in paths:
        image = imread(p)[..., :3]
        assert image.shape[1] >= 6 * figures.DPI
        middle = image[image.shape[0] // 5 : -image.shape[0] // 5, image.shape[1] // 5 : -image.shape[1] // 5]
        # an empty diagram has only its grid, whose channels differ by 8 / 255; those of the palest curve by 27 / 255
        assert (np.ptp(middle, axis=2) > 17 / 255).sum() > 300, p


def test_a_long_reason_of_a_failure_leaves_the_picture_its_room(tmp_path, recwarn):
    reason = "NC line 4: strut 4: too long, got 1.9000238 m (limit 1.9 m); " + "move the work, " * 9
    log = make_log(seconds=2.0, failed=reason)
    for draw in (path, contour_error):
        ax = draw(log)
        ax.figure.savefig(tmp_path / "a.png")
        text = next(one for one in ax.texts if "FAILED" in one.get_text())
        assert " ".join(text.get_text().split()).startswith("FAILED: NC line 4: strut 4: too long")
        assert text.get_window_extent().x1 < ax.figure.bbox.x1
        assert ax.get_position().width > 0.6
    assert not [str(one.message) for one in recwarn]


@pytest.mark.quick("0")
@pytest.mark.parametrize("rows", [0, 1, 2])
def test_a_run_that_failed_at_once_is_drawn_and_marked(rows, tmp_path):
    log = make_log(seconds=rows / 1000, failed="strut 3 is too long")
    assert save_all(log, tmp_path)
    assert any("FAILED: strut 3 is too long" in text.get_text() for text in contour_error(log).texts)


@pytest.mark.full
def test_a_log_with_nan_is_drawn(tmp_path):
    log = make_log(seconds=2.0, failed="no longer finite")
    for name in ("x", "q", "u", "contour_error", "radial_error"):
        log.dataset[name].values[1500:] = np.nan
    assert len(save_all(log, tmp_path)) == 6


@pytest.mark.full
def test_a_name_with_dollars_or_slashes_is_only_a_name(tmp_path):
    log = make_log("../$\\frac{$<b>", seconds=1.0, rate=100, failed="$x_{")
    names = {p.name for p in save_all([log, log], tmp_path)}
    assert {p.name for p in tmp_path.iterdir()} == names
    assert len(names) == 2 + 2 * 4  # contour error, circle; four figures each


def test_a_log_without_a_signal_gets_the_figures_it_has_data_for(short, tmp_path):
    from gough.log import Log

    some = Log(short.dataset[["u", "line"]])
    assert [p.name for p in save_all(some, tmp_path)] == ["forces_pid.png"]
    with pytest.raises(LogError, match="contour_error"):
        contour_error(some)


def test_colours_are_those_of_the_style_file():
    cycle = matplotlib.rc_params_from_file(style.PATH, use_default_template=False)["axes.prop_cycle"]
    assert tuple("#" + entry["color"].lstrip("#") for entry in cycle) == style.COLOURS
    with matplotlib.rc_context():
        matplotlib.rcParams.update(matplotlib.rc_params_from_file(style.PATH, use_default_template=False))


def test_the_colours_of_error_darken_steadily():
    """Lightness alone must tell the order: relative luminance of sRGB, IEC 61966-2-1."""

    def luminance(colour):
        rgb = np.array([int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)])
        linear = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
        return linear @ [0.2126, 0.7152, 0.0722]

    assert np.all(np.diff([luminance(colour) for colour in style.ERROR_COLOURS]) < 0)


def make_batch(errors, failed):
    """A batch without rows: largest contour errors m, rms half of them, and which runs failed."""
    builder = LogBuilder(np.zeros(0), TASK, 6, runs=len(errors))
    builder.add_runs([{"contour_error": {"max": e, "rms": None if e is None else e / 2}} for e in errors], failed)
    return builder.build({"controller_kind": "pid"}, "failed" if any(failed) else "done", "one" if any(failed) else "")


def test_the_spread_of_a_batch_has_a_step_for_every_run_that_came_to_its_end():
    log = make_batch([3e-6, 1e-6, 2e-6, 9e-6, None], [0, 0, 0, 1, 0])
    ax = log.plot.contour()
    most, rms = ax.lines
    assert most.get_xdata().tolist() == pytest.approx([1, 1, 2, 3]) and rms.get_xdata()[-1] == pytest.approx(1.5)
    assert most.get_ydata().tolist() == pytest.approx([0, 100 / 3, 200 / 3, 100])
    assert ax.get_title(loc="left") == "5 runs under PID, 1 failed" and ax.get_xlabel() == "contour error [µm]"


def test_a_batch_of_which_nothing_is_left_has_no_spread():
    with pytest.raises(LogError, match=r"^metrics.contour_error: no run of the batch has a contour error"):
        make_batch([1e-6, None], [1, 0]).plot.spread()


def test_a_single_run_has_no_spread(short):
    with pytest.raises(LogError, match=r"^run: the log holds one run; log.plot.contour\(\) draws it over time"):
        short.plot.spread()


@pytest.mark.parametrize("name", ["path", "circle", "forces", "velocities", "tracking"])
def test_figures_of_one_run_are_refused_for_a_batch_by_name(name):
    with pytest.raises(LogError, match=r"^run: holds a batch of runs; pick one: log.run\(0\).plot; log.plot.spread"):
        getattr(make_batch([1e-6, 2e-6], [0, 0]).plot, name)()
