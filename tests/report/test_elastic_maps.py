"""Maps of machines that give way: stiffness and chatter are datasets and figures like all others."""

from __future__ import annotations

import numpy as np
import pytest

import gough as gk
from gough.cutting import Cutting, EndMill, Wall
from gough.cutting.posed import depth_map
from gough.errors import ExperimentError, WorkspaceError
from gough.machine.vibration import stiffness_map
from gough.plan.chatter import chatter_map
from gough.plan.findings import LABELS, findings
from gough.plan.maps import machine_map
from gough.plan.quantities import TOLD
from gough.report.map_figures import map_figure

CUTTING = Cutting(
    tool=EndMill(diameter=12e-3, teeth=4, helix=0.0), coefficients="A5052",
    wall=Wall(axial_depth=10e-3, places=[0.0, 0.1], radial=[6e-3]), spindle_speed=300.0,
)  # fmt: skip
FEED = [0, -1, 0]


@pytest.mark.full
def test_every_number_of_a_map_of_stiffness_can_be_drawn_and_the_figure_names_the_worst():
    found = machine_map(gk.load_machine("ifma-hsm"), "stiffness", points=2)
    units = {"N/m": "N/um", "Hz": "Hz", "m": "um"}
    for name in ("stiffness_least", "stiffness_x", "stiffness_y", "stiffness_z", "frequency", "sag"):
        figure, worst = map_figure(found, name), findings(found)["worst"][name]
        assert figure.axes[-1].get_ylabel() == f"{LABELS[name]} [{units[TOLD[name][0]]}]"
        factor = {"N/m": 1e-6, "Hz": 1.0, "m": 1e6}[TOLD[name][0]]
        assert f"{worst['is']} {factor * worst['value']:.4g} {units[TOLD[name][0]]} (o)" in figure.get_suptitle()


@pytest.mark.full
def test_the_stiffness_along_an_axis_is_never_below_the_softest_and_is_that_of_the_pose():
    machine = gk.load_machine("nist-octahedral")
    found = machine_map(machine, "stiffness", points=2, over={"x": (-0.05, 0.05), "y": (-0.05, 0.05)})
    pose = np.array(machine.home)
    pose[:2] = 0.05, -0.05
    wanted = stiffness_map(machine.flexible(), pose)["stiffness"][0]
    along = np.array([found[f"stiffness_{axis}"].values for axis in "xyz"])
    np.testing.assert_allclose(along[:, 1, 0], wanted, rtol=1e-12)
    assert (along >= found["stiffness_least"].values * (1 - 1e-12)).all()


@pytest.mark.full
def test_a_map_of_chatter_holds_the_depths_of_its_poses_within_the_limits_of_the_machine():
    flexible = gk.load_machine("nist-octahedral").flexible()
    found = chatter_map(flexible, CUTTING, FEED, over={"x": (0.0, 0.1), "z": (0.0, 5.0)}, points=2)
    pose = np.array(flexible.home)
    pose[0] = 0.1
    wanted = depth_map(flexible, [pose], CUTTING, FEED)
    assert found["depth"].values[1, 0] == wanted["least"][0] > 0
    assert found["depth_here"].values[1, 0] == wanted["limit"][0]
    assert found["chatter_frequency"].values[1, 0] == wanted["frequency"][0]
    assert np.isnan(found["depth"].values[:, 1]).all() and not found["inside"].values[:, 1].any()  # 5 m up
    figure, worst = map_figure(found, "chatter"), findings(found)["worst"]["depth"]
    assert f"least {1e3 * worst['value']:.4g} mm (o)" in figure.get_suptitle()
    assert figure.axes[-1].get_ylabel() == "depth free of chatter [mm]"
    assert map_figure(found, "chatter_frequency").axes[-1].get_ylabel() == "frequency of the chatter [Hz]"


def test_a_number_that_a_map_does_not_hold_is_refused_with_the_nearest():
    found = machine_map(gk.load_machine("ifma-hsm"), "feed", points=2)
    with pytest.raises(ExperimentError, match="the map holds no such thing, got 'fed'; did you mean feed"):
        map_figure(found, "fed")
    with pytest.raises(ExperimentError, match="the map holds no such thing, got 'stiffness'"):
        map_figure(found, "stiffness")


def test_maps_where_the_machine_cannot_stand_or_of_too_many_poses_are_refused():
    flexible = gk.load_machine("ifma-hsm").flexible()
    with pytest.raises(WorkspaceError, match="the machine can stand nowhere on this map"):
        machine_map(flexible.rigid, "stiffness", at={"z": 5.0}, points=2)
    with pytest.raises(ExperimentError, match="a map of chatter takes milliseconds a pose: too many, got 40000 poses"):
        chatter_map(flexible, CUTTING, FEED, points=200)
    assert {key: len(rows) for key, rows in stiffness_map(flexible, np.zeros((0, 3))).items()} == {
        "stiffness": 0, "least": 0, "frequency": 0, "sag": 0,
    }  # fmt: skip
