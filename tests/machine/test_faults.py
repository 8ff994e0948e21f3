"""Rows K1 to K6 of RELIABILITY.md: poses out of reach, singular poses, lengths no pose has; each with its message."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from gough.errors import ExperimentError, InputError, KinematicsError, SingularityError, WorkspaceError
from gough.frames import rotation_of_abc_np
from gough.machine import forward
from gough.machine.workspace import check_poses, condition, margin_names, margins, random_poses


def wide(m):
    """The machine without limits on its struts' length and direction, but those of a singularity."""
    bare = m.replace(friction=None, strut=m.strut.replace(sleeve=None, tube=None))  # a guide ends the stroke
    return bare.replace(**{"limits.length": [1e-3, 100.0], "limits.cone": 3.14, "limits.workspace": None})


def test_k1_a_pose_beyond_the_stroke_names_strut_value_limit_and_place(nist):
    x = np.array([nist.home, nist.home + [0, 0, -0.4, 0, 0, 0]])
    with pytest.raises(WorkspaceError) as caught:
        check_poses(nist, x, place=lambda row: f"t = {row * 0.5} s, NC line 12")
    q = nist.inverse_kinematics(x[1]).max()
    (problem,) = caught.value.problems
    assert problem.rule == "strut 1: too long" and problem.where == "t = 0.5 s, NC line 12"
    assert problem.value == f"{q:.8g} m" and problem.limit == "1.9 m" and "move the work" in problem.cure
    assert caught.value.exit_status == 1


def test_k1_a_strut_too_short_is_named_too(nist):
    with pytest.raises(WorkspaceError, match=r"strut 1: too short, got 1\.3\d+ m \(limit 1\.4 m\)"):
        check_poses(nist, nist.home + [0, 0, 0.6, 0, 0, 0])


def test_k1_a_joint_beyond_its_cone_is_named(okuma):
    m = okuma.replace(**{"limits.length": [0.1, 3.0]})
    with pytest.raises(
        WorkspaceError, match=r"strut \d: platform joint beyond its cone, got 51\.8 deg \(limit 45 deg\)"
    ):
        check_poses(m, m.home + [0, 0, 0, 0, 0, np.radians(70)])


def test_k1_the_cone_is_the_angle_from_home_at_each_end(okuma):
    """At the tilt where a platform joint has turned by exactly the cone's angle, its margin changes sign."""
    m = wide(okuma).replace(**{"limits.cone": np.radians(30)})
    names = m.limit_names
    for b in np.radians([5, 20, 29, 31, 40]):
        x = m.home + [0, 0, 0, 0, b, 0]
        z = np.array(m.coordinates_of(m, np.array(x))).ravel()
        found = margins(m, z)[0]
        for i in range(6):
            n, n_home = (m.jacobian(y)[i, :3] for y in (x, m.home))
            R, R_home = (rotation_of_abc_np(y[3:]) for y in (x, m.home))
            base = np.arccos(min(1.0, n @ n_home))
            end = np.arccos(min(1.0, (R.T @ n) @ (R_home.T @ n_home)))
            assert (found[names.index(f"strut {i + 1}: base joint beyond its cone")] >= 0) == (base <= np.radians(30))
            assert (found[names.index(f"strut {i + 1}: platform joint beyond its cone")] >= 0) == (
                end <= np.radians(30)
            )


@pytest.mark.parametrize(
    ("offset", "message"),
    [
        ([0.26, 0, 0, 0, 0, 0], "beyond the radius of the workspace"),  # 0.25 m
        ([0, 0, -0.11, 0, 0, 0], "beyond the height of the workspace"),  # 0.2 m, half of it down
        ([0, 0, 0, np.radians(21), 0, 0], "tilted beyond the workspace"),  # 20 deg
        ([0, 0, 0, 0, 0, np.radians(31)], "turned beyond the workspace"),  # 30 deg
        ([0, 0, 0, 0, 0, np.radians(-31)], "turned beyond the workspace"),
    ],
)
def test_k1_a_pose_outside_the_declared_workspace_is_no_answer(nist, offset, message):
    x = nist.home + offset
    with pytest.raises(WorkspaceError, match=message):
        nist.forward_kinematics(nist.inverse_kinematics(x), near=x)
    inside = nist.home + 0.9 * np.array(offset)
    assert_allclose(nist.forward_kinematics(nist.inverse_kinematics(inside), near=inside), inside, atol=1e-12)


def test_k1_random_poses_are_inside_every_limit_and_fill_the_workspace(library_machine):
    m = library_machine
    x = random_poses(m, 5000, np.random.default_rng(108))
    check_poses(m, x)
    space, offset = m.limits.workspace, x[:, :3] - m.home[:3]
    r = np.hypot(offset[:, 0], offset[:, 1])
    assert space.radius * 0.95 < r.max() <= space.radius
    assert space.height / 2 * 0.95 < np.abs(offset[:, 2]).max() <= space.height / 2
    tilt = np.arccos(rotation_of_abc_np(x[:, 3:])[:, 2, 2])
    assert space.tilt * 0.95 < tilt.max() <= space.tilt + 1e-9


def test_k1_a_workspace_no_pose_of_which_is_reachable_is_said_not_searched_for_ever(nist):
    m = nist.replace(**{"limits.length": [1.678, 1.6781]})  # home is 1.67806 m; its neighbours are not
    with pytest.raises(WorkspaceError, match="hardly a pose of the declared workspace"):
        random_poses(m, 1000, np.random.default_rng(109))


FICHTER = [0, 0, 0, 0, 0, np.pi / 2]  # a platform turned by 90 deg about its axis loses a freedom


def test_k2_near_a_singularity_a_pose_is_refused_by_its_condition_number(library_machine):
    m = wide(library_machine)
    x = m.home + [0, 0, 0, 0, 0, np.radians(89)]
    kappa = condition(m, m.jacobian(x))
    assert kappa > m.limits.condition and m.limits.determinant < np.linalg.det(m.jacobian(x)) / np.linalg.det(
        m.jacobian(m.home)
    )
    with pytest.raises(
        SingularityError,
        match=rf"near a singularity: condition number of J, got {kappa:.3g} \(limit 100\); move the work",
    ):
        check_poses(m, x)
    check_poses(m, m.home + [0, 0, 0, 0, 0, np.radians(60)])


def test_k2_the_condition_number_is_the_same_for_lengths_in_any_unit(nist):
    """Lengths divided by the platform's radius: scaling the machine by 1000 (mm) changes nothing."""
    x = nist.home + [0.02, 0.03, 0.01, 0.1, 0.2, 0.3]
    small = condition(nist, nist.jacobian(x))
    big = nist.replace(**{"joints.base": 10 * nist.joints.base, "joints.platform": 10 * nist.joints.platform,
                          "limits.length": [14.0, 19.0], "strut.sleeve": 10.0, "strut.tube": 10.0})  # fmt: skip
    assert_allclose(condition(big, big.jacobian(x * [10, 10, 10, 1, 1, 1])), small, rtol=1e-12)


@pytest.mark.quick("okuma-pm600")
def test_k3_at_the_singular_pose_no_force_is_given(library_machine):
    m = wide(library_machine)
    x = m.home + np.array(FICHTER)
    assert abs(np.linalg.det(m.jacobian(x)) / np.linalg.det(m.jacobian(m.home))) < 1e-14
    for call in (m.inverse_dynamics, m.regressor):
        with pytest.raises(SingularityError, match="the joints do not hold the platform here"):
            call(x, np.zeros(6), np.zeros(6))
    with pytest.raises(SingularityError, match=r"near a singularity: det J against home, .* of it \(limit 0.001\)"):
        check_poses(m, x)
    # what does not divide by J is finite there
    assert np.isfinite(m.jacobian(x)).all() and np.isfinite(m.inverse_kinematics(x)).all()
    assert np.isfinite(m.forward_dynamics(x, np.zeros(6), np.zeros(6))).all()


def test_k3_the_error_names_the_row(nist):
    x = np.tile(nist.home, (2, 3, 1))
    x[1, 2] += FICHTER
    with pytest.raises(SingularityError, match=r"^index \[1, 2\]: "):
        wide(nist).inverse_dynamics(x, np.zeros(6), np.zeros(6))


def test_k3_beyond_the_singular_pose_the_machine_is_another_and_refused(library_machine):
    m = wide(library_machine)
    x = m.home + np.array(FICHTER) * 1.2
    with pytest.raises(SingularityError):
        m.inverse_dynamics(x, np.zeros(6), np.zeros(6))
    with pytest.raises(KinematicsError, match="another assembly mode"):
        m.forward_kinematics(m.inverse_kinematics(x), near=x)


def test_k3_a_start_at_the_singular_pose_gives_a_right_pose_or_an_error(library_machine):
    m = library_machine
    x = random_poses(m, 500, np.random.default_rng(110))
    start = m.home + np.array(FICHTER)
    found, status = m.forward_kinematics(m.inverse_kinematics(x), near=start, on_fail="nan")
    ok = status == 0
    assert np.isfinite(found[ok]).all() and np.isnan(found[~ok]).all()
    assert ok.sum() == 0 or np.abs(found[ok] - x[ok]).max() < 1e-9


def test_k3_an_exactly_singular_jacobian_ends_its_own_search_only(nist):
    """Strut 1 of no length has no direction: J holds NaN there, no step is taken, and the neighbours do not suffer."""
    x = np.tile(nist.home, (3, 1))
    x[1] = np.concatenate([nist.joints.base[0] - nist.joints.platform[0], np.zeros(3)])
    q = nist.inverse_kinematics(nist.home + np.array([0.01, 0, 0, 0, 0, 0]) + np.zeros((3, 6)))
    z, steps = forward.newton(nist, q, x, np.ones(3, bool))
    assert steps[1] == 1 and np.array_equal(z[1], nist.arrays.run("coordinates", x[1])[0])
    assert np.abs(z[[0, 2], 0] - nist.home[0] - 0.01).max() < 1e-12
    with pytest.raises(KinematicsError, match=r"index \[1\]: .* after 1 iterations, nearest pose \[") as caught:
        nist.forward_kinematics(q, near=x)
    assert "nan" not in str(caught.value)


def test_k4_lengths_no_pose_has_end_in_an_error_with_residual_and_iterations(nist):
    q = nist.inverse_kinematics(nist.home) + [0.5, 0.0, 0.5, 0.0, 0.5, 0.0]
    with pytest.raises(KinematicsError) as caught:
        nist.forward_kinematics(q)
    text = str(caught.value)
    assert "forward kinematics found no pose, got residual " in text and "after 60 iterations, nearest pose [" in text
    assert "(limit 1e-10 m)" in text and "near=..." in text and "nan" not in text


def test_k4_the_row_that_fails_is_named_and_the_others_are_kept_as_asked(nist):
    q = np.tile(nist.inverse_kinematics(nist.home), (3, 1))
    q[1] += [0.5, 0.0, 0.5, 0.0, 0.5, 0.0]
    with pytest.raises(KinematicsError, match=r"^index \[1\]: "):
        nist.forward_kinematics(q)
    x, status = nist.forward_kinematics(q, on_fail="nan")
    assert status.tolist() == [0, 2, 0]
    assert np.isnan(x[1]).all() and np.abs(x[[0, 2]] - nist.home).max() < 1e-12
    assert [forward.STATUS[s] for s in status] == ["ok", "no convergence", "ok"]


def test_k5_another_assembly_mode_is_refused_and_named(okuma):
    """The platform above the base joints instead of below: same lengths, mirrored."""
    q = okuma.inverse_kinematics(okuma.home)
    mirrored = okuma.home * [1, 1, 0, 1, 1, 1] + [0, 0, 1.008 - 2 * 0.4, 0, 0, 0]
    assert_allclose(okuma.inverse_kinematics(mirrored), q, atol=1e-12)
    with pytest.raises(KinematicsError, match=r"another assembly mode, got det J = -\d.* of home's"):
        okuma.forward_kinematics(q, near=mirrored)
    _, status = okuma.forward_kinematics(q, near=mirrored, on_fail="nan")
    assert forward.STATUS[int(status)] == "another assembly mode"


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({3: 0.0}, "strut 4 must be above 0 m"),
        ({3: -1.6}, "strut 4 must be above 0 m"),
        ({2: np.nan}, "strut 3 must be finite"),
        ({5: np.inf}, "strut 6 must be finite"),
        ({0: 9.0}, "strut 1 and strut 2 lengths differ by more than their joints allow"),
    ],
)
def test_k6_impossible_lengths_are_refused_before_the_search(nist, change, message, monkeypatch):
    q = nist.inverse_kinematics(nist.home).copy()
    for i, value in change.items():
        q[i] = value
    seen = []
    real = forward.newton
    monkeypatch.setattr(forward, "newton", lambda m, q, x0, run: (seen.append(run.any()), real(m, q, x0, run))[1])
    with pytest.raises(KinematicsError, match=message):
        nist.forward_kinematics(q)
    assert seen and not any(seen), "not one iteration"
    x, status = nist.forward_kinematics(q, on_fail="nan")
    assert status == 1 and np.isnan(x).all()


def test_k6_the_quadrangle_rule_refuses_no_real_pose(library_machine):
    x = random_poses(library_machine, 20_000, np.random.default_rng(111))
    fits, _ = forward.impossible(library_machine, library_machine.inverse_kinematics(x))
    assert fits.all()


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_numbers_that_are_not_finite_never_reach_the_equations(nist, bad):
    x = np.tile(nist.home, (4, 1))
    x[2, 1] = bad
    zero = np.zeros(6)
    calls = [
        lambda: nist.inverse_kinematics(x), lambda: nist.jacobian(x), lambda: nist.mass_matrix(x),
        lambda: nist.inverse_dynamics(x, zero, zero), lambda: nist.inverse_dynamics(nist.home, x, zero),
        lambda: nist.inverse_dynamics(nist.home, zero, zero, wrench=x), lambda: nist.forward_dynamics(x, zero, zero),
        lambda: nist.forward_dynamics(nist.home, zero, x), lambda: nist.regressor(x, zero, zero),
        lambda: nist.joint_motion(x, zero, zero), lambda: nist.forward_kinematics(np.ones((4, 6)), near=x),
    ]  # fmt: skip
    for call in calls:
        with pytest.raises(ExperimentError, match=r"index \[2, 1\]: .* must be finite"):
            call()


def test_wrong_shapes_are_named(nist):
    with pytest.raises(ExperimentError, match=r"pose must have shape \(\.\.\., 6\), got \(5,\)"):
        nist.inverse_kinematics(np.zeros(5))
    with pytest.raises(ExperimentError, match=r"joint coordinates must have shape \(\.\.\., 6\)"):
        nist.forward_kinematics(np.zeros((6, 3)))
    with pytest.raises(ExperimentError, match='on_fail must be "raise" or "nan"'):
        nist.forward_kinematics(np.ones(6), on_fail="ignore")


def test_margins_have_a_name_each(library_machine):
    z = np.array(library_machine.coordinates_of(library_machine, library_machine.home)).ravel()
    assert margins(library_machine, z).shape == (1, len(margin_names(library_machine)))
    assert (margins(library_machine, z) >= 0).all()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            {"strut.moving.center": 280.0},
            r"strut.moving.center: the centre of mass lies far outside .* did you mean mm",
        ),
        (
            {"platform.center": [0, 0, 260.0]},
            r"platform.center: the centre of mass lies far outside .* did you mean mm",
        ),
        ({"gravity": [0, 0, -9810.0]}, r"gravity: gravity is no planet's, got 9810 m/s2 \(limit 30 m/s2\)"),
        ({"drive.lead": 10.0}, r"drive.lead: must be at most 1 m, got 10 m"),
        ({"drive.encoder": 2.5e-3}, r"drive.encoder: must be at most 0.001 m, got 0.0025 m"),
    ],
)
def test_k7_a_length_in_another_unit_is_noticed(nist, change, message):
    with pytest.raises(InputError, match=message):
        nist.replace(**change)
