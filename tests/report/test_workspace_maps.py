"""Maps over the workspace show what `stiffness_map` finds, with units."""

from __future__ import annotations

import numpy as np
import pytest

import gough as gk
from gough.errors import ExperimentError
from gough.machine.vibration import stiffness_map
from gough.report.maps import SHOWN, grid, workspace_map


@pytest.mark.full
@pytest.mark.parametrize("name", ["nist-octahedral", "ifma-hsm"])
def test_a_map_holds_the_values_of_its_poses_and_names_the_worst(name):
    flexible = gk.load_machine(name).flexible()
    ax = workspace_map(flexible, "least", points=5)
    shown = ax.collections[0].get_array()
    poses = grid(flexible.rigid, points=5)
    inside = np.isfinite(poses).all(-1)
    wanted = stiffness_map(flexible, poses[inside])["least"] * 1e-6
    np.testing.assert_allclose(shown.compressed(), wanted[np.isfinite(wanted)])
    assert f"least {np.nanmin(wanted):.4g} N/um" in ax.get_title(loc="left")
    assert ax.get_xlabel() == "x [mm]" and ax.figure.axes[-1].get_ylabel().endswith("[N/um]")
    if name == "nist-octahedral":  # a cylinder: its corners are empty
        assert not inside[0, 0] and inside[2, 2]


@pytest.mark.full
def test_every_map_there_is_can_be_drawn():
    flexible = gk.load_machine("ifma-hsm").flexible()
    for what, (told, unit, _) in SHOWN.items():
        assert f"{told} [{unit}]" == workspace_map(flexible, what, points=2).figure.axes[-1].get_ylabel()


def test_a_map_that_there_is_not_is_refused_with_the_nearest():
    flexible = gk.load_machine("nist-octahedral").flexible()
    with pytest.raises(ExperimentError, match="no such map, got 'frequncy'; did you mean frequency"):
        workspace_map(flexible, "frequncy")
    with pytest.raises(ExperimentError, match="a map needs a declared workspace"):
        grid(gk.load_machine("emps"))


def test_a_map_at_a_height_where_the_machine_cannot_stand_is_refused_and_of_no_poses_there_are_no_rows():
    flexible = gk.load_machine("ifma-hsm").flexible()
    with pytest.raises(ExperimentError, match=r"height: the machine can stand nowhere on this map, got 5 m"):
        workspace_map(flexible, height=5.0, points=2)
    assert {key: len(rows) for key, rows in stiffness_map(flexible, np.zeros((0, 3))).items()} == {
        "stiffness": 0, "least": 0, "frequency": 0, "sag": 0,
    }  # fmt: skip
