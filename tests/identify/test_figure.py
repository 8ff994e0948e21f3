"""The figure of a fit: what it draws are errors of rows that their prediction has not seen, at their time and speed."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from numpy.testing import assert_allclose

import gough as gk
from gough.errors import ExperimentError
from gough.identify import figure
from gough.identify.fit import Fit
from gough.identify.regress import FOLDS, estimate
from gough.identify.rows import rows_of_log
from gough.log.build import LogBuilder


@pytest.fixture(scope="module")
def emps():
    return gk.load_machine("emps")


@pytest.fixture(scope="module")
def log(emps):
    """20 s of an axis with a force that its law of friction does not know: 30 N s/m more in one direction."""
    t = np.arange(0, 20, 2e-3)
    x = 0.15 + 0.08 * np.sin(2 * t) * np.cos(0.3 * t)
    v = np.gradient(x, t)
    u = 95 * np.gradient(v, t) + 20 * np.sign(v) + 200 * v + 30 * np.abs(v)
    u += np.random.default_rng(0).normal(size=len(t))
    builder = LogBuilder(t, emps.task, 1)
    builder.add("q_m", x[:, None])
    builder.add("u", u[:, None])
    return builder.build({})


@pytest.fixture(scope="module")
def fit(emps, log):
    return gk.identify(log, emps)


def curve(ax, name):
    (line,) = (line for line in ax.lines if line.get_label() == name)
    return np.array(line.get_data())


def test_what_is_drawn_as_held_out_is_predicted_by_least_squares_that_have_not_seen_it(fit):
    """Derived again: leave a fifth out, solve the normal equations of one joint, predict the fifth."""
    rows, found = fit.estimate.rows, fit.estimate.held_out[:, 0]
    edges = np.linspace(0, len(rows.u), FOLDS + 1).astype(int)
    for a, b in zip(edges[:-1], edges[1:], strict=True):
        inside = np.zeros(len(rows.u), bool)
        inside[a:b] = True
        Y, u, used = rows.Y[:, 0], rows.u[:, 0], rows.used[:, 0]
        learn, test = used & ~inside, used & inside
        pi = np.linalg.solve(Y[learn].T @ Y[learn], Y[learn].T @ u[learn])
        assert_allclose(found[test], u[test] - Y[test] @ pi, rtol=0, atol=1e-8)
    assert np.isnan(found[~rows.used[:, 0]]).all()
    assert fit.estimate.held_out_rms == pytest.approx(np.sqrt(np.nanmean(found**2)), rel=1e-12)


def test_every_point_stands_at_the_time_and_speed_of_its_row(fit, log):
    rows, (time, speed) = fit.estimate.rows, figure.draw(fit).axes[:2]
    drawn = curve(time, "held out")
    places = np.searchsorted(rows.t, drawn[0])
    assert_allclose(drawn[1], fit.estimate.held_out[places, 0], rtol=0, atol=0)
    truth = np.interp(rows.t, log.t, np.gradient(log["q_m"][:, 0], log.t))
    assert_allclose(rows.speed[:, 0], truth, rtol=0, atol=2e-3 * np.abs(truth).max())
    cloud = np.array(speed.lines[0].get_data())
    assert set(np.round(cloud[0], 12)) <= set(np.round(rows.speed[:, 0], 12))


def test_friction_that_differs_by_direction_shows_as_a_mean_that_bends_at_0(fit):
    """30 |v| is even in v: a line and a step, which are odd, take none of its bend."""
    v, mean = curve(figure.draw(fit).axes[1], "mean")
    fast = np.abs(v) > 0.5 * np.abs(v).max()
    assert mean[fast].min() > mean[~fast].max()


def test_joints_that_take_no_part_have_no_row_and_unseen_names_stand_below(fit):
    drawn = figure.draw(fit)
    assert len(drawn.axes) == 2
    text = drawn.get_supxlabel()
    assert text.startswith(f"{fit.estimate.held_out_rms:.3g} N rms held out")
    okuma = gk.load_machine("okuma-pm600")
    t = np.arange(0, 3, 2e-3)
    x = np.repeat(okuma.home[None], len(t), 0)
    x[:, 2] += 0.02 * np.sin(3 * t)
    builder = LogBuilder(t, okuma.task, 6)
    q = okuma.inverse_kinematics(x)
    builder.add("q_m", q)
    builder.add("u", np.full_like(q, 100.0))
    rows = rows_of_log(builder.build({}), okuma, friction=())
    some = dataclasses.replace(rows, used=rows.used & (np.arange(6) < 2))
    shown = Fit(okuma, estimate(some, ["platform.m"]), ())
    drawn = figure.draw(shown)
    assert [ax.get_title(loc="left") for ax in drawn.axes[::2]] == ["okuma-pm600: strut 1", "strut 2"]


def test_only_the_formats_that_are_named_are_drawn(fit, tmp_path):
    with pytest.raises(ExperimentError) as caught:
        figure.save(fit, tmp_path / "fit.jpg")
    assert str(caught.value) == ("--plot: is no figure that gough draws, got 'fit.jpg'; end it in .png, .svg, .pdf")
    assert figure.save(fit, tmp_path / "fit.svg").read_text().startswith("<?xml")


@pytest.mark.full
def test_the_command_draws_and_does_not_replace(gough, log, tmp_path):
    log.save(tmp_path / "log.nc")
    command = ["identify", "log.nc", "-m", "emps", "--map", "map.toml", "--plot", "fit.png"]
    (tmp_path / "map.toml").write_text(
        'schema = "gough-log-map-1"\n[time]\ncolumn = "t"\nperiod = "2 ms"\n'
        '[joints]\ncolumns = ["q_m"]\nunit = "m"\n[forces]\ncolumns = ["u"]\nunit = "N"\n'
    )
    done = gough(*command)
    assert done.status == 0, done.err
    assert done.out.splitlines()[-1] == "figure: fit.png"
    assert (tmp_path / "fit.png").read_bytes()[:4] == b"\x89PNG"
    again = gough(*command)
    assert (again.status, again.err.strip()) == (
        2, "fit.png: there is a file already; choose another name, or add --force",
    )  # fmt: skip
