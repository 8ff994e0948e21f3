"""Limits of the hexaglide with their messages: reach, rails, carriages on one rail, cones; and sheets it refuses."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

import gough as gk
from gough.errors import ExperimentError, KinematicsError, SheetError, SingularityError, WorkspaceError
from gough.frames import quaternion_of_abc_np, rotation_of_abc_np
from gough.machine.workspace import check_poses, margins, random_poses
from gough.mechanics.load_friction import LoadStribeck


@pytest.fixture(scope="module")
def eth():
    return gk.load_machine("eth-hexaglide")


@pytest.fixture(scope="module")
def wide(eth):
    """Without limits but those of reach and of singular poses."""
    return eth.replace(**{"limits.travel": [-5.0, 5.0], "limits.gap": 0.0, "limits.lean": 1e-3, "limits.cone": None})


def test_a_leg_that_cannot_reach_says_which_and_by_how_much(eth):
    """0.5 m down, joint 1 is sqrt(0.235^2 + 1.09^2) = 1.11504 m from its rail."""
    low = eth.home + [0, 0, -0.5, 0, 0, 0]
    text = "leg 1 cannot reach: misses by 115 mm, got 1.11504 m from joint to rail (limit 1 m)"
    zero = np.zeros(6)
    for call in (
        lambda: eth.inverse_kinematics(low),
        lambda: eth.jacobian(low),
        lambda: eth.joint_motion(low, zero, zero),
        lambda: eth.inverse_dynamics(low, zero, zero),
        lambda: eth.mass_matrix(low),
    ):
        with pytest.raises(WorkspaceError) as caught:
            call()
        assert str(caught.value) == f"{text}; check the pose: position, angles, units"
        assert caught.value.exit_status == 1
    assert np.isnan(eth.joint_motion(low, zero, zero, on_fail="nan")[0]).any()


def test_of_many_poses_the_first_out_of_reach_is_named_with_its_leg(eth):
    """Sideways, the far leg misses first: joint 5 at y = 0.265 - 1.0 from a rail at 0.485."""
    x = np.tile(eth.home, (2, 3, 1))
    x[1, 2] += [0, -1.0, 0, 0, 0, 0]
    misses = np.hypot(0.485 - 0.265 + 1.0, 0.59) - 1
    with pytest.raises(WorkspaceError, match=rf"index \[1, 2\]: leg \d cannot reach: misses by {1e3 * misses:.4g} mm"):
        eth.inverse_kinematics(x[..., :])


def test_a_leg_just_in_reach_has_an_answer_and_just_out_of_it_none(wide):
    """Joint 1 and 2 are 1 m from their rail at dz = 0.59 - sqrt(1 - 0.235^2); the others reach farther."""
    edge = wide.home[2] + 0.59 - np.sqrt(1 - 0.235**2)
    inside, outside = (wide.home + [0, 0, edge + d, 0, 0, 0] for d in (1e-9, -1e-9))
    q = wide.inverse_kinematics(inside)
    assert_allclose(q[:2], [-0.08, 0.08], atol=1e-4)  # sqrt(2e-9) beside its joint
    with pytest.raises(WorkspaceError, match="leg 1 cannot reach: misses by "):
        wide.inverse_kinematics(outside)


def test_a_leg_square_across_its_rail_is_refused_before_it_cannot_reach(eth):
    with pytest.raises(WorkspaceError) as caught:
        check_poses(eth, eth.home + [0, 0, -0.37, 0, 0, 0])
    (problem,) = caught.value.problems
    # c^2 = 1 - 0.235^2 - 0.96^2, the leg leans by asin(c) from square
    lean = np.degrees(np.arcsin(np.sqrt(1 - 0.235**2 - 0.96**2)))
    assert (problem.rule, problem.value, problem.limit) == (
        "leg 1: nearly square across its rail", f"{lean:.4g} deg", "15 deg",
    )  # fmt: skip


def test_a_carriage_beyond_an_end_of_its_rail_is_named(eth):
    far = eth.home + [0.6, 0, 0, 0, 0, 0]
    with pytest.raises(
        WorkspaceError, match=r"carriage 6: beyond the end of its rail, got 1\.5368526 m \(limit 1\.5 m\)"
    ):
        check_poses(eth, far)
    with pytest.raises(WorkspaceError, match=r"carriage 5: beyond the start of its rail, got -1\.5368526 m"):
        check_poses(eth, eth.home - [0.6, 0, 0, 0, 0, 0])


def test_carriages_that_would_run_into_each_other_are_named(eth):
    """At home carriages 1 and 2 are 2 x 0.85244741 m apart."""
    m = eth.replace(**{"limits.gap": 1.7})
    low = m.home + [0, 0, -0.02, 0, 0, 0]
    d2 = 0.235**2 + 0.61**2
    with pytest.raises(WorkspaceError) as caught:
        check_poses(m, low)
    (problem,) = caught.value.problems
    assert problem.rule == "carriages 1 and 2: too close" and problem.limit == "1.7 m"
    assert problem.value == f"{0.16 + 2 * np.sqrt(1 - d2):.6g} m"


def test_margins_are_what_is_left_of_every_limit(eth):
    pose = np.array([0.1, -0.05, 0.08, 0.05, -0.08, 0.06])
    z = np.r_[pose[:3], quaternion_of_abc_np(pose[3:])]
    left = dict(zip(eth.limit_names, eth.arrays.run("margins", z)[0], strict=True))

    def legs(x):
        R = rotation_of_abc_np(x[3:])
        B = x[:3] + eth.joints.platform @ R.T
        d = np.linalg.norm((B - eth.rails.point)[:, 1:], axis=1)
        q = B[:, 0] + eth.rails.side * np.sqrt(1 - d * d)
        u = B - eth.rails.point - np.outer(q, [1, 0, 0])
        return d, q, u, u @ R

    (d, q, u, u_T), (_, _, home, home_T) = legs(pose), legs(eth.home)
    cone = np.cos(eth.limits.cone)
    for i in range(6):
        assert left[f"leg {i + 1}: cannot reach"] == pytest.approx(1 - d[i], abs=1e-14)
        assert left[f"carriage {i + 1}: beyond the start of its rail"] == pytest.approx(q[i] + 1.5, abs=1e-14)
        assert left[f"carriage {i + 1}: beyond the end of its rail"] == pytest.approx(1.5 - q[i], abs=1e-14)
        square = abs(u[i, 0]) - np.sin(eth.limits.lean)
        assert left[f"leg {i + 1}: nearly square across its rail"] == pytest.approx(square, abs=1e-14)
        assert left[f"leg {i + 1}: carriage joint beyond its cone"] == pytest.approx(u[i] @ home[i] - cone, abs=1e-14)
        at_T = u_T[i] @ home_T[i] - cone
        assert left[f"leg {i + 1}: platform joint beyond its cone"] == pytest.approx(at_T, abs=1e-14)
    for i, j in ((0, 1), (2, 3), (4, 5)):
        assert left[f"carriages {i + 1} and {j + 1}: too close"] == pytest.approx(q[j] - q[i] - 0.4, abs=1e-14)
    ratio = np.linalg.det(eth.jacobian(pose)) / np.linalg.det(eth.jacobian(eth.home))
    assert left["near a singularity: det J against home"] == pytest.approx(ratio - 1e-3, abs=1e-12)
    assert len(left) == 4 * 6 + 3 + 2 * 6 + 1


def test_the_whole_published_workspace_is_within_every_limit(eth):
    """500 x 500 x 300 mm at any tilt to 12 deg, the corners among them."""
    at = np.stack(np.meshgrid([-0.25, 0, 0.25], [-0.25, 0, 0.25], [-0.15, 0, 0.15], indexing="ij"), -1).reshape(-1, 3)
    corners = np.concatenate([at, np.zeros((27, 3))], 1)
    x = np.concatenate([corners, random_poses(eth, 20_000, np.random.default_rng(3))])
    z = np.concatenate([x[:, :3], quaternion_of_abc_np(x[:, 3:])], 1)
    assert (margins(eth, z) >= 0).all()
    check_poses(eth, x)
    q = eth.inverse_kinematics(corners)
    # the longest way: joint 6 at the corner, 0.03 m beside and 0.44 m below its rail
    assert np.abs(q).max() == pytest.approx(0.25 + 0.16 + np.sqrt(1 - 0.03**2 - 0.44**2), abs=1e-12)
    assert min((q[:, i + 1] - q[:, i]).min() for i in (0, 2, 4)) == pytest.approx(1.095, abs=5e-3)  # and gaps of 1.09 m
    found, status = eth.forward_kinematics(eth.inverse_kinematics(x), on_fail="nan")
    assert (status == 0).all(), "forward kinematics from home is right in all of it"


def test_the_box_of_the_workspace_is_length_width_and_height(eth):
    for offset, name in (
        ([0.26, 0, 0], "length"), ([0, -0.26, 0], "width"), ([0, 0, 0.16], "height"),
    ):  # fmt: skip
        x = eth.home + np.r_[offset, 0, 0, 0]
        with pytest.raises(WorkspaceError, match=f"beyond the {name} of the workspace, got 0.[12]6 m"):
            eth.forward_kinematics(eth.inverse_kinematics(x), near=x)
    x = random_poses(eth, 4000, np.random.default_rng(5))
    assert (np.abs(x[:, :2]).max(0) > 0.249).all() and np.abs(x[:, 2]).max() > 0.149  # corners are filled, too
    assert ((np.abs(x[:, 0]) > 0.2) & (np.abs(x[:, 1]) > 0.2)).sum() > 100


def test_places_of_carriages_that_no_pose_has(eth):
    q = eth.inverse_kinematics(eth.home)
    with pytest.raises(KinematicsError) as caught:
        eth.forward_kinematics(q * 1.6)
    assert str(caught.value).startswith(
        "carriages 1 and 2 are 2.728 m apart, farther than legs and platform reach (2.16 m); check unit and order"
    )
    with pytest.raises(KinematicsError, match="carriage 4 must be finite"):
        eth.forward_kinematics(np.where(np.arange(6) == 3, np.nan, q))
    with pytest.raises(ExperimentError, match=r"must have shape \(\.\.\., 6\)"):
        eth.forward_kinematics(q[:5])


def test_on_the_other_branch_the_places_are_not_taken_for_a_pose(eth):
    """Carriages 1 and 2 exchanged: the legs' lengths fit a pose, the sides of the sheet do not."""
    q = eth.inverse_kinematics(eth.home)
    with pytest.raises((KinematicsError, SingularityError, WorkspaceError)):
        eth.forward_kinematics(q[[1, 0, 3, 2, 5, 4]])


def test_singular_poses_are_refused(wide):
    """Tilted by b until det J vanishes, near 67 deg: every leg still reaches."""
    turns = np.radians(np.linspace(0, 70, 701))
    x = wide.home + turns[:, None] * [0, 0, 0, 0, 1, 0]
    assert wide.unreachable(x) is None
    ratio = np.linalg.det(wide.jacobian(x)) / np.linalg.det(wide.jacobian(wide.home))
    first = int(np.argmax(ratio < 1e-3))
    assert ratio[first] < 1e-3, "the machine has no singular pose on this way"
    with pytest.raises(SingularityError, match="near a singularity: condition number of J"):
        check_poses(wide, x[: first + 1])
    steep = wide.replace(**{"limits.condition": 1e9})
    with pytest.raises(SingularityError, match=f"det J against home, got {ratio[first]:.3g} of it"):
        check_poses(steep, x[: first + 1])
    with pytest.raises(SingularityError, match="the joints do not hold the platform here"):
        wide.inverse_dynamics(x[first], np.zeros(6), np.zeros(6))


# -- sheets -----------------------------------------------------------------------------------------------------------

REFUSED = [
    ({"rails.side": [1, 1, -1, 1, -1, 1]}, "home: carriages 1 and 2 are in each other at home, got 0.16 m apart"),
    ({"rails.side": [0, 1, -1, 1, -1, 1]}, r"rails.side: is 1 or -1 for each carriage"),
    ({"rails.direction": [[1, 0, 0]] * 5 + [[0.5, 0, 0]]}, "rails.direction: a direction must have length 1, got 0.5"),
    ({"rails.direction": [[1, 0, 0]] * 5 + [[0, 1, 0]]}, "carriages 5 and 6 run on one rail in different directions"),
    ({"legs.length": 0.5}, r"home: leg 1 cannot reach at home: misses by 135\.1 mm"),
    ({"legs.length": [1.0] * 5}, "legs.length: needs one value or six, got 5"),
    ({"legs.length": 0.0}, "legs.length: must be above 0 m"),
    ({"legs.mass": -1.0}, "legs.mass: must be above 0 kg"),
    ({"carriage.mass": 0.0}, "carriage.mass: must be above 0 kg"),
    ({"limits.travel": [1.5, -1.5]}, "limits.travel: the first end must be below the second"),
    ({"limits.travel": [-0.9, 1.5]}, r"home: carriage 5 is beyond its rail at home, got -0\.936853 m \(limit -0\.9 to"),
    ({"limits.gap": 1.75}, r"carriages 1 and 2 are in each other at home, got 1\.70489 m apart \(limit 1\.75 m\)"),
    ({"limits.lean": np.radians(52)}, r"home: leg 1 is square across its rail at home, or nearly, got 50\.57 deg"),
    ({"friction.coulomb": [1.0, 2.0]}, "friction needs one value or six"),
    ({"friction": LoadStribeck(coulomb=0.1)}, "friction.kind: load_stribeck scales with forces between the tubes"),
    ({"gravity": [0, 0, -9810.0]}, "gravity is no planet's"),
    ({"platform.center": [0, 0, 179.4]}, "platform.center: the centre of mass lies far outside the machine"),
    ({"limits.workspace.radius": 0.3}, "is a cylinder or a box; give radius, or size, and not both"),
    ({"drive.lead": 0.02}, "no such key"),
]  # fmt: skip


@pytest.mark.parametrize(("change", "text"), REFUSED, ids=[next(iter(c)) + str(i) for i, (c, _) in enumerate(REFUSED)])
def test_a_sheet_that_is_no_machine_is_refused(eth, change, text):
    with pytest.raises((SheetError, ExperimentError), match=text):
        eth.replace(**change)


def test_a_symmetric_platform_is_singular_at_home(eth):
    """MACHINES.md 2.4: with the middle pair in the plane of symmetry, and outer pairs as mirror images, no leg holds
    one freedom."""
    P = np.array(eth.joints.platform)
    P[2:4, 1], P[4:] = 0.0, P[:2] * [1, -1, 1]
    with pytest.raises(SheetError, match="home is a singular pose, or near one, got condition number"):
        eth.replace(**{"joints.platform": P})


def test_all_that_is_wrong_with_home_is_said_at_once(eth):
    with pytest.raises(SheetError) as caught:
        eth.replace(**{"limits.travel": [-0.9, 0.9], "limits.gap": 1.75})
    assert [p.rule for p in caught.value.problems] == [
        "carriage 5 is beyond its rail at home", "carriage 6 is beyond its rail at home",
        "carriages 1 and 2 are in each other at home",
    ]  # fmt: skip
