"""What a hybrid machine refuses: tips out of reach, ends of slides, sheets that make no machine."""

from __future__ import annotations

import numpy as np
import pytest

import gough as gk
from gough.errors import InputError, KinematicsError, ProgramError, SheetError, SingularityError, WorkspaceError
from gough.machine.sheet import load_machine
from gough.machine.workspace import check_poses


@pytest.fixture(scope="module")
def hsm():
    return load_machine("ifma-hsm")


def test_a_tip_too_near_to_its_pivot_is_told_with_how_much_is_missing(hsm):
    text = r"slide 1: cannot reach: misses by 800 mm, got 0\.1 m from the axis of pivot 1 \(limit at least 0\.9 m\)"
    with pytest.raises(WorkspaceError, match=text):
        hsm.inverse_kinematics([-0.8, 0.0, 0.0])


def test_the_first_row_out_of_reach_is_named_with_its_place(hsm):
    x = np.array([hsm.home, [-0.9, 0.5, 0.0]])
    with pytest.raises(WorkspaceError, match="misses by 400 mm") as caught:
        check_poses(hsm, x, place=lambda row: f"t = {row * 0.5} s")
    assert caught.value.problems[0].where == "t = 0.5 s"


@pytest.mark.parametrize(
    ("tip", "text"),
    [
        ([0.0, 1.2, 0.7], r"ram: beyond the end of its travel, got 0\.7 m \(limit 0\.65 m\)"),
        ([0.0, 1.2, -0.2], r"ram: beyond the start of its travel, got -0\.2 m \(limit -0\.12 m\)"),
        ([0.0, 2.4, 0.0], r"slide 1: beyond the end of its travel, got 2\.4 m \(limit 2\.2 m\)"),
        ([-0.5, 1.9, 0.0], r"slide 6: beyond the end of its travel, got 2\.\d+ m \(limit 2\.2 m\)"),
        ([0.5, 0.9, 0.0], r"slide 6: beyond the start of its travel, got 0\.\d+ m \(limit 0\.7 m\)"),
    ],
)
def test_a_slide_beyond_its_end_is_named_with_value_and_limit(hsm, tip, text):
    with pytest.raises(WorkspaceError, match=text):
        check_poses(hsm, np.array(tip))


def test_arms_that_lean_too_far_are_named_with_their_angle(hsm):
    stiff = hsm.replace(**{"limits.angle": np.radians([-8.0, 10.0]), "limits.workspace": None})
    with pytest.raises(WorkspaceError, match=r"arm 1: angle beyond the greatest, got 10\.21 deg \(limit 10 deg\)"):
        check_poses(stiff, np.array([-0.315, 1.83, 0.55]))
    with pytest.raises(WorkspaceError, match=r"arm 1: angle beyond the least, got -\d+\.\d+ deg \(limit -8 deg\)"):
        check_poses(stiff, np.array([0.4, 1.5, 0.1]))


def test_arms_along_the_base_are_a_singular_pose(hsm):
    """phi towards 90 deg: s65 - s21 = 2 b sin phi cannot turn the arms any more."""
    loose = hsm.replace(
        **{
            "limits.angle": [-1.6, 1.6], "limits.travel": [[0.1, 6.0], [0.1, 6.0], [-1.0, 1.0]],
            "limits.passive": [-2.0, 2.0], "limits.workspace": None, "limits.condition": 1e6,
            "limits.condition_warning": 1e5, "limits.determinant": 0.01,
        }
    )  # fmt: skip
    phi, s21 = np.radians(89.9), 1.2
    tip = [-0.9 + 0.9 * np.cos(phi) - s21 * np.sin(phi), 0.9 * np.sin(phi) + s21 * np.cos(phi), 0.0]
    with pytest.raises(SingularityError, match="det J"):
        check_poses(loose, np.array(tip))
    with pytest.raises(SingularityError, match="do not hold the platform here: det J against home"):
        loose.inverse_dynamics(tip, np.zeros(3), np.zeros(3))


def test_places_of_slides_that_no_pose_has_are_refused(hsm):
    text = r"slide 1 and slide 6 are 2\.1 m apart, more than their pivots \(1\.8 m\)"
    with pytest.raises(KinematicsError, match=text):
        hsm.forward_kinematics([0.2, 2.3, 0.1])


@pytest.mark.full
def test_a_run_into_the_end_of_a_slide_names_slide_value_limit_and_time(hsm):
    short = hsm.replace(**{"limits.travel": [[0.7, 1.21], [0.7, 2.2], [-0.06, 0.65]], "limits.workspace": None})
    log = gk.simulate(short, gk.PID(bandwidth=10.0), gk.Circle(radius=0.05, feed=0.1, center=[-0.05, 0.0, 0.0]))
    assert log.dataset.attrs["status"] == "failed"
    reason = log.dataset.attrs["reason"]
    assert "slide 1: beyond the end of its travel" in reason and "limit 1.21" in reason and "t = " in reason


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"home": [0.0, 2.4, 0.0]}, r"at home, slide 1: beyond the end of its travel"),
        ({"home": [-0.9, 0.2, 0.0]}, r"at home, slide 1: cannot reach: misses by 700 mm"),
        ({"limits.travel": [[0.0, 2.2], [0.7, 2.2], [0.0, 0.6]]}, "slide 1 may not reach its pivot"),
        ({"limits.travel": [[0.7, 2.2], [2.2, 0.7], [0.0, 0.6]]}, "the first end must be below the second"),
        ({"limits.travel": [[700, 2200], [700, 2200], [0, 600]]}, "spans a strange distance"),
        ({"limits.angle": [0.3, -0.3]}, "the first end must be below the second"),
        ({"ram.center": [0.0, 0.0, -381.53]}, "the centre of mass lies far outside the machine"),
        ({"arm.center": 1000.0}, "the centre of mass lies far outside the machine"),
        ({"gravity": [0.0, -9810.0, 0.0]}, "gravity is no planet's"),
        ({"arm.inertia": -45.0}, "must be above 0"),
    ],
)
def test_a_sheet_that_makes_no_machine_is_refused(hsm, change, text):
    with pytest.raises(InputError, match=text):
        hsm.replace(**change)


def test_friction_of_struts_is_none_of_slides(hsm):
    data = hsm.to_file() | {"friction": {"kind": "stribeck", "coulomb": ["10 N", "10 N"], "viscous": "5 N s/m"}}
    with pytest.raises((InputError, SheetError), match="friction needs one value or three"):
        type(hsm).from_file(data)


def test_a_program_that_turns_the_tool_is_refused_with_its_line(hsm, tmp_path):
    part = tmp_path / "turn.ngc"
    part.write_text("G21 G90 F1000\nG1 X10\nG1 X20 C5\nM2\n")
    with pytest.raises(ProgramError, match="ifma-hsm cannot turn its tool") as caught:
        gk.load_program(part).plan(hsm)
    assert caught.value.problems[0].line == 3
