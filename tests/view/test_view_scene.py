"""What is drawn of a run is what the log says, and nothing is drawn of a log that does not say it."""

from __future__ import annotations

import numpy as np
import pytest

import gough as gk
from gough.errors import LogError
from gough.frames import rotation_of_quaternion_np
from gough.report.prepare import tip
from gough.view.page import legend
from gough.view.scene import machine_of, scene_of
from gough.view.stage import error_colours, force_colour, turned


@pytest.fixture(scope="module")
def scene(run_log):
    return scene_of(run_log)


def test_the_path_drawn_once_as_large_is_beside_the_tool_only_along_it(scene, run_log):
    """On a circle the closest point is across the path: what is left is the lag, and second order in it."""
    driven = scene.magnified(1.0)
    apart = np.linalg.norm(driven - scene.programmed, axis=1)
    np.testing.assert_allclose(apart, run_log["contour_error"][scene.path], atol=1e-15)
    np.testing.assert_allclose(driven, tip(run_log)[scene.path], atol=1e-15)


def test_the_programmed_path_is_the_circle(scene, run_log):
    """Within what the direction of the deviation can be wrong by: the lag's square over the diameter."""
    centre = np.asarray(run_log.info["circles"][0]["center"])
    radius = np.linalg.norm((scene.programmed - centre)[:, :2], axis=1)
    moving = run_log["counted"][scene.path] > 0
    worst = np.nanmax(run_log["contour_error"]) ** 2 / 0.05 + np.nanmax(np.abs(run_log["lag"])) ** 2 / 0.1
    assert np.abs(radius[moving] - 0.05).max() < 2 * worst + 1e-9


def test_deviations_are_drawn_as_many_times_as_large_as_asked(scene):
    once, many = (scene.magnified(times) - scene.programmed for times in (1.0, 250.0))
    np.testing.assert_allclose(many, 250 * once, rtol=1e-9, atol=1e-12)
    assert scene.fitting * np.linalg.norm(scene.deviation, axis=1).max() <= 0.1 * 0.1 * 1.01


def test_the_machine_is_drawn_where_it_is(scene, run_log):
    row = scene.row(0.5 * scene.duration)
    drawn = dict(zip([part.name for part in scene.parts], scene.at(row), strict=True))
    np.testing.assert_allclose(drawn["tool"][-1], run_log["x"][row, :3], atol=1e-15)
    lengths = [np.linalg.norm(drawn[name][1] - drawn[name][0]) for name in run_log.joint_names]
    np.testing.assert_allclose(lengths, run_log["q"][row], atol=1e-9)


def test_a_time_finds_the_nearest_row(scene):
    step = scene.t[1] - scene.t[0]
    assert [scene.row(scene.t[7] + share * step) for share in (-0.4, 0, 0.4, 0.6)] == [7, 7, 7, 8]
    assert (scene.row(-1), scene.row(1e9)) == (0, len(scene.t) - 1)


@pytest.mark.parametrize(
    "name, coloured",
    [
        ("nist-octahedral", 6),
        ("okuma-pm600", 6),
        ("eth-hexaglide", 12),  # carriages and their legs
        ("ccu-3prs", 6),
        ("ifma-hsm", 3),  # its link 2 is no leg of drive 2
        ("emps", 1),
    ],
)
def test_every_machine_of_the_library_has_its_parts_by_joint(name, coloured):
    from gough.view import scene as module

    machine = gk.load_machine(name)
    drawn = machine.drawing(machine.home)
    points = [np.asarray(part["points"], float) for part in drawn]
    parts = module._parts(machine, [part["name"] for part in drawn], points)
    found = [part.joint for part in parts if part.joint is not None]
    assert len(found) == coloured
    assert set(found) == set(range(machine.joints_count))


def test_the_machine_of_a_log_is_the_one_that_was_believed(run_log):
    assert machine_of(run_log) == gk.load_machine("nist-octahedral")


@pytest.mark.parametrize("direction", [(0, 0, 2), (0, 0, -3), (1, 2, 3), (-1e-9, 0, -1), (0.3, 0, 0), (0, -2, 0)])
def test_cylinders_are_turned_to_their_direction(direction):
    direction = np.asarray(direction, float)
    axis = rotation_of_quaternion_np(turned(direction)) @ [0, 0, 1]
    np.testing.assert_allclose(axis, direction / np.linalg.norm(direction), atol=2e-9)


def test_forces_that_pull_are_blue_and_those_that_push_are_red():
    pull, rest, push = (force_colour(share) for share in (-1, 0, 1))
    assert pull[2] > pull[0] and push[0] > push[2] and max(rest) - min(rest) < 15
    assert force_colour(np.nan) == rest and force_colour(7.0) == push


def test_colours_of_errors_are_the_reports_and_an_unknown_error_is_the_darkest():
    colours = error_colours(np.array([0.0, 1.0, np.nan]))
    assert [f"#{r:02x}{g:02x}{b:02x}" for r, g, b in colours] == ["#c5d3e0", "#5e0b18", "#5e0b18"]


def test_the_legend_says_what_colours_mean_and_escapes_names(scene):
    from dataclasses import replace

    text = legend(replace(scene, title="<script>x"), 200.0)
    assert "&lt;script&gt;x" in text and "<script" not in text
    assert "drawn 200 times as large" in text and "force of a strut" in text


def test_logs_that_cannot_be_drawn_are_refused_by_name(run_log, tmp_path):
    machine, program = gk.load_machine("nist-octahedral"), gk.Circle(radius=0.05, feed=0.3)
    batch = gk.simulate(machine, gk.PID(bandwidth=12.0), program, seed=[0, 1], log_every=50)
    with pytest.raises(LogError, match="holds a batch of runs"):
        scene_of(batch)
    bare = gk.simulate(machine, gk.PID(bandwidth=12.0), program, signals=["x"], log_every=50)
    with pytest.raises(LogError, match="holds nothing to draw.*run.signals"):
        scene_of(bare)
