"""What a 3-PRS refuses: tips out of reach, singular poses with their condition number, sheets that make no machine."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

import gough as gk
from gough.errors import InputError, KinematicsError, ProgramError, SingularityError, WorkspaceError
from gough.machine.sheet import load_machine
from gough.machine.workspace import check_poses
from gough.simulate import tick


@pytest.fixture(scope="module")
def ccu():
    return load_machine("ccu-3prs")


def test_a_tip_out_of_reach_names_the_link_and_by_how_much(ccu):
    far = flat(ccu, 0.175)
    text = r"link 3: cannot reach: misses by [\d.]+ mm, got 0\.\d+ m from joint to rail \(limit 0\.175 m\)"
    with pytest.raises(WorkspaceError, match=text):
        far.inverse_kinematics(far.home + [0.0, 0.1, 0.0])


def test_a_tip_so_far_aside_that_no_tilt_brings_the_platform_there_is_told(ccu):
    with pytest.raises(WorkspaceError, match="no tilt of the platform brings its joints into the planes of the links"):
        ccu.inverse_kinematics(ccu.home + [0.9, 0.0, 0.0])


def test_the_first_row_out_of_reach_is_named_with_its_place(ccu):
    x = np.array([ccu.home, ccu.home + [0.9, 0, 0]])
    with pytest.raises(WorkspaceError, match="no tilt") as caught:
        check_poses(ccu, x, place=lambda row: f"t = {row * 0.5} s")
    assert caught.value.problems[0].where == "t = 0.5 s"


@pytest.mark.full
def test_a_run_beyond_a_rail_names_slider_value_limit_and_time(ccu):
    short = ccu.replace(**{"limits.travel": [0.36, 0.39], "limits.workspace": None})
    log = gk.simulate(short, gk.PID(bandwidth=10.0), gk.Circle(radius=0.05, feed=0.1, center=[-0.05, 0.0, 0.0]))
    assert log.dataset.attrs["status"] == "failed"
    assert "slider" in log.dataset.attrs["reason"] and "beyond the" in log.dataset.attrs["reason"]
    assert "limit 0.3" in log.dataset.attrs["reason"] and "t = " in log.dataset.attrs["reason"]


def flat(ccu, length):
    """A machine whose links lie nearly square to their rails at home: 0.169 m away, with links of `length` m."""
    return ccu.replace(
        **{
            "link.length": length, "limits.angle": [-1.57, 1.57], "limits.workspace": None, "limits.cone": None,
            "limits.travel": [-2.0, 2.0],
        }
    )  # fmt: skip


def test_a_singular_phi_b_is_told_with_its_condition_number(ccu):
    """Links square to their rails let the platform fall: phi_b is singular at theta = 0."""
    loose = flat(ccu, 0.17).replace(**{"limits.condition": 20.0, "limits.condition_warning": 19.0})
    with pytest.raises(SingularityError, match=r"do not hold the platform, condition number of phi_b") as caught:
        check_poses(loose, loose.home + [0.0, 0.02, 0.0])
    problem = caught.value.problems[0]
    assert problem.limit == "20"
    p, theta, zs, _, _ = tick.symbols_of(loose)
    phi_b = ca.Function("phi_b", [theta, zs], [ca.jacobian(loose.closure_of(p, zs), zs)[:, 3:]])
    K = np.array(phi_b(loose.theta, loose.standing(loose.home + [0.0, 0.02, 0.0])))
    assert float(problem.value) == pytest.approx(0.17 * np.linalg.norm(np.linalg.inv(K)), rel=5e-3)


def test_a_machine_whose_phi_b_is_singular_at_home_is_none(ccu):
    with pytest.raises(InputError, match=r"at home, near a singularity: .* phi_b, got 1\d\d(\.\d)? \(limit 100\)"):
        flat(ccu, 0.16902)


def test_places_of_sliders_that_no_pose_has_are_refused(ccu):
    with pytest.raises(
        KinematicsError, match=r"sliders 1 and 2 are 2\.\d+ m apart, farther than links and platform reach"
    ):
        ccu.forward_kinematics([-1.0, 1.5, 0.3])


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"joints.platform": [[0, 0, 0.3], [0.1, 0, 0.3], [0.2, 0, 0.3]]}, "the platform's joints are no triangle"),
        ({"rails.direction": [[0, 0, -1], [0, 0, -1], [0, 0, -2]]}, "must have length 1"),
        ({"rails.across": [[1, 0, 0], [-1, 0, 0], [0, 0, -1]]}, "must be square to direction"),
        ({"home": [0.0, 0.1745, -2.4]}, "at home, slider 1: beyond the end of its rail"),
        ({"home": [1.5, 0.1745, -1.4]}, "at home, no tilt of the platform"),
        ({"limits.travel": [0.6, 0.2]}, "the first end must be below the second"),
        ({"platform.center": [0.0, 0.0, 250.0]}, "the centre of mass lies far outside the machine"),
        ({"gravity": [0.0, 0.0, -9810.0]}, "gravity is no planet's"),
    ],
)
def test_a_sheet_that_makes_no_machine_is_refused(ccu, change, text):
    with pytest.raises(InputError, match=text):
        ccu.replace(**change)


def test_turning_the_tool_is_not_for_this_machine_but_its_tilt_is_told(ccu):
    pose = ccu.tool_pose(ccu.home + [0.05, 0, 0])
    assert pose.shape == (6,) and np.abs(pose[3:]).max() > 0.1


def test_near_a_singular_pose_inverse_dynamics_is_refused(ccu):
    """At the end of its reach link 3 lies square to its rail: its slider does not hold the platform there."""
    loose, reached, missed = flat(ccu, 0.17), 0.02, 0.04
    for _ in range(40):
        y = (reached + missed) / 2
        there = loose.unreachable(loose.home + [0.0, y, 0.0]) is None
        reached, missed = (y, missed) if there else (reached, y)
    with pytest.raises(SingularityError, match="do not hold the platform here: det J against home"):
        loose.inverse_dynamics(loose.home + [0.0, reached - 1e-9, 0.0], np.zeros(3), np.zeros(3))


def test_a_program_that_turns_the_tool_is_refused_with_its_line(ccu, tmp_path):
    part = tmp_path / "turn.ngc"
    part.write_text("G21 G90 F1000\nG1 X10\nG1 X20 A5\nM2\n")
    with pytest.raises(
        ProgramError, match="ccu-3prs cannot turn its tool: tilt and turn follow from the place"
    ) as caught:
        gk.load_program(part).plan(ccu)
    assert caught.value.problems[0].line == 3


def test_a_tool_of_another_length_is_refused(ccu, tmp_path):
    part = tmp_path / "tool.ngc"
    part.write_text("G21 G90 F1000\nG43.1 Z50\nG1 X10\nM2\n")
    with pytest.raises(ProgramError, match="tilts by itself"):
        gk.load_program(part).plan(ccu)
