"""Figures of maps and envelopes show the numbers they are made of."""

from __future__ import annotations

import re

import numpy as np
import pytest

import gough as gk
from gough.plan.findings import findings
from gough.plan.maps import machine_map
from gough.report.envelope import envelope_figure
from gough.report.map_figures import map_figure


@pytest.fixture(scope="module")
def hybrid():
    return gk.load_machine("ifma-hsm")


def test_an_image_holds_the_values_of_the_map_with_x_across(hybrid):
    found = machine_map(hybrid, "feed", points=(5, 4))
    figure = map_figure(found, "feed")
    image = figure.axes[0].collections[0].get_array()
    np.testing.assert_allclose(image.reshape(4, 5), found["feed"].values.T)
    worst = findings(found)["worst"]["feed"]["value"]
    assert figure.get_suptitle() == f"ifma-hsm at z 250 mm: least {worst:.4g} m/s (o)"
    assert figure.axes[-1].get_ylabel() == "feed in the worst direction [m/s]"
    assert figure.axes[0].get_xlabel() == "x [mm]" and figure.axes[0].get_ylabel() == "y [mm]"
    # x across and y up: the worst pose is marked where the table has it
    line = figure.axes[0].lines[0]
    pose = findings(found)["worst"]["feed"]["pose"]
    assert (line.get_xdata()[0], line.get_ydata()[0]) == pytest.approx((1e3 * pose["x"], 1e3 * pose["y"]))


def test_a_map_of_three_coordinates_is_drawn_in_slices_that_say_where_they_are(hybrid):
    found = machine_map(hybrid, ["workspace", "gravity"], over=("x", "y", "z"), points=(3, 3, 9))
    names = [ax.get_title(loc="left") for ax in map_figure(found, "gravity").axes[:-1]]
    worst = findings(found)["worst"]["holding_share"]["pose"]["z"]
    assert len(names) == 6 and f"z {1e3 * worst:.4g} mm" in names
    assert {"z -100 mm", "z 600 mm"} <= {*names, f"z {1e3 * worst:.4g} mm"}
    assert len(map_figure(found, "workspace").axes) == 7  # three slices, twice, and a scale


@pytest.mark.full
def test_of_more_coordinates_those_slices_are_drawn_that_show_the_worst_pose():
    found = machine_map(gk.load_machine("nist-octahedral"), "dexterity", over=("x", "y", "z", "a", "b"), points=7)
    pose = findings(found)["worst"]["condition"]["pose"]
    figure = map_figure(found, "dexterity")
    marked = [ax for ax in figure.axes[:-1] if ax.lines]
    told = f"z {1e3 * pose['z']:.4g} mm, a {np.degrees(pose['a']):.4g} deg, b {np.degrees(pose['b']):.4g} deg"
    assert [ax.get_title(loc="left") for ax in marked] == [told]


def test_a_map_of_one_coordinate_is_a_line():
    found = machine_map(gk.load_machine("emps"), points=5)
    line = map_figure(found, "workspace").axes[0].lines[0]
    np.testing.assert_allclose(line.get_xydata(), np.stack([1e3 * found["x"].values, found["reserve"].values], 1))


def test_the_limits_that_are_nearest_somewhere_are_in_the_legend(hybrid):
    found = machine_map(hybrid, over={"x": (-1.2, 1.2), "y": (0.3, 2.5)}, points=15)
    legend = map_figure(found, "workspace").axes[1].get_legend()
    names = found["limit"].attrs["flags"].split("; ")
    there = {re.sub(r" \d", "", names[n]) for n in np.unique(found["limit"].values) if n >= 0}
    assert {text.get_text().replace("\n", " ") for text in legend.get_texts()} == there and len(there) > 2


def test_an_envelope_is_drawn_with_each_way_and_the_limit_that_ends_it(hybrid):
    found = gk.envelope(hybrid)
    ax = envelope_figure(found).axes[0]
    widths = [bar.get_width() for bar in ax.patches if bar.get_height() < 0.5]
    np.testing.assert_allclose(widths, [1e3 * way.sense * way.distance for way in found.ways])
    texts = " ".join(text.get_text() for text in ax.texts)
    assert all(way.limit in texts for way in found.ways) and "120 mm in any direction" in texts
