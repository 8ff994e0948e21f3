"""Limits and the checks of sheets say the same of a machine wherever its frames and the zeros of its rails are."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from numpy.testing import assert_allclose

import gough as gk
from gough.errors import InputError, SheetError
from gough.frames import abc_of_rotation_np, rotation_of_abc_np
from gough.machine.limits import check_points
from gough.machine.strut_limits import possible_lengths
from gough.machine.workspace import condition, margin_names, margins, random_poses

SHIFT = np.array([0.1, -0.2, 0.3, 0.15, -0.05, 0.25])  # m, where q = 0 of each rail is


@pytest.fixture(scope="module")
def eth():
    return gk.load_machine("eth-hexaglide").replace(**{"limits.travel": [-3.0, 3.0]})


def shifted(machine):
    """The same hexaglide, its rails measured from other places."""
    return machine.replace(**{"rails.point": machine.rails.point - SHIFT[:, None] * machine.rails.direction})


def of_pose(machine, x):
    return margins(machine, np.array([machine.coordinates(one) for one in x]))


def test_where_a_rail_is_measured_from_moves_its_ends_and_nothing_else(eth):
    x, other = random_poses(eth, 20, np.random.default_rng(1)), shifted(eth)
    assert_allclose(other.inverse_kinematics(x), eth.inverse_kinematics(x) + SHIFT, atol=1e-14)
    here, there = of_pose(eth, x), of_pose(other, x)
    for k, name in enumerate(margin_names(eth)):
        moved = {"start": 1, "end": -1}.get(name.removesuffix(" of its rail").rpartition(" ")[2], 0)
        by = moved * SHIFT[int(name.partition(":")[0][-1]) - 1] if moved else 0.0
        assert_allclose(there[:, k], here[:, k] + by, atol=1e-12, err_msg=name)


@pytest.mark.parametrize(
    "change",
    [{"limits.gap": 1.75}, {"limits.lean": np.radians(52)}, {"limits.condition": 1.5}],
    ids=lambda change: next(iter(change)),
)
def test_where_a_rail_is_measured_from_does_not_change_what_is_wrong_with_home(eth, change):
    told = []
    for machine in (eth, shifted(eth)):
        with pytest.raises(SheetError) as caught:
            machine.replace(**change)
        told.append(str(caught.value))
    assert told[0] == told[1] and "at home" in told[0].replace("home is a singular pose", "at home")


def test_the_workspace_turns_with_the_machine(nist):
    """W turned by 170 deg: c at home is no longer 0, and c of a pose turned by 25 deg more is -165 deg."""
    R = rotation_of_abc_np(np.radians([0, 0, 170]))

    def turned(x):
        return np.concatenate([x[:3] @ R.T, abc_of_rotation_np(R @ rotation_of_abc_np(x[3:]))])

    other = nist.replace(
        **{"joints.base": nist.joints.base @ R.T, "joints.base_axis": nist.joints.base_axis @ R.T,
           "home": turned(nist.home)}
    )  # fmt: skip
    x = nist.home + np.array([[0.1, -0.05, 0.03, 0.1, -0.1, c] for c in np.radians([-25, -5, 0, 5, 25, 35])])
    assert {np.sign(turned(one)[5]) for one in x} == {-1, 1}
    assert_allclose(of_pose(other, [turned(one) for one in x]), of_pose(nist, x), atol=1e-12)


def test_the_condition_number_takes_the_platforms_radius_about_its_own_middle(nist):
    """By hand from the joints' distances in pairs: the sum of their squares is 2 n^2 times the radius squared."""
    B, J = nist.joints.platform, nist.jacobian(nist.home)
    radius = np.sqrt(((B[:, None] - B) ** 2).sum() / (2 * 6**2))
    by_hand = np.linalg.cond(J @ np.diag([1, 1, 1, 1 / radius, 1 / radius, 1 / radius]))
    for origin in (np.zeros(3), np.array([0.3, -2.0, 5.0])):
        machine = SimpleNamespace(joints=SimpleNamespace(platform=B + origin))
        assert condition(machine, J) == pytest.approx(by_hand, rel=1e-12)


def test_a_home_is_as_singular_as_its_jacobian_about_the_middle_of_the_platform(nist):
    """T put into the middle of the joints: the check of the sheet has the condition number of J there, to a part in
    1e9."""
    middle = nist.joints.platform.mean(0)
    home = nist.home + np.r_[rotation_of_abc_np(nist.home[3:]) @ middle, 0, 0, 0]
    moved = {"joints.platform": nist.joints.platform - middle, "platform.center": nist.platform.center - middle}
    machine = nist.replace(**moved, home=home)
    number = condition(machine, machine.jacobian(home))
    assert nist.replace(**moved, **{"home": home, "limits.condition": number * (1 + 1e-9)})
    for far in (np.zeros(3), np.array([0.0, 0.0, 0.7])):  # nor does it matter where the tip is
        tip = {"joints.platform": moved["joints.platform"] + far, "platform.center": moved["platform.center"] + far}
        away = home - np.r_[rotation_of_abc_np(home[3:]) @ far, 0, 0, 0]
        with pytest.raises(InputError, match="home is a singular pose, or near one"):
            nist.replace(**tip, **{"home": away, "limits.condition": number * (1 - 1e-9)})


def test_joints_on_a_line_are_refused_wherever_the_line_is():
    along = np.linspace(-0.5, 0.5, 6)[:, None] * np.array([0.6, 0.0, 0.8])
    for origin in ([0, 0, 0], [0, 1.0, 0.2]):
        with pytest.raises(InputError, match="platform joints lie on one line"):
            check_points("platform", along + np.array(origin))


def test_a_platform_far_from_its_tip_has_its_centre_of_mass_among_its_joints(nist):
    """Joints and centre of mass 20 m above the tip: nothing is wrong; a centre left at the tip is."""
    up = np.array([0, 0, 20.0])
    high = {"joints.platform": nist.joints.platform + up,
            "home": nist.home - np.r_[rotation_of_abc_np(nist.home[3:]) @ up, 0, 0, 0]}  # fmt: skip
    assert nist.replace(**high, **{"platform.center": nist.platform.center + up})
    distance = np.linalg.norm(nist.platform.center - nist.joints.platform.mean(0) - up)
    with pytest.raises(InputError, match=rf"lies far outside the machine, got {distance:g} m from its joints"):
        nist.replace(**high)


def test_lengths_fit_where_every_pair_of_struts_closes_its_quadrangle(nist):
    """Corner by corner in Python, joints far from the origin; the pair that is named is one that does not close."""
    A, B = nist.joints.base, nist.joints.platform
    far = nist.replace(**{"joints.base": A + [0.0, 5.0, 0.0], "joints.platform": B + [3.0, 0.0, 0.0],
                          "home": nist.home + [-3.0, 5.0, 0, 0, 0, 0]})  # fmt: skip
    q = np.random.default_rng(4).uniform(0.5, 2.2, (400, 6))

    def beyond(l, i, j):
        return abs(l[i] - l[j]) - np.sqrt(sum((A[i] - A[j]) ** 2)) - np.sqrt(sum((B[i] - B[j]) ** 2))

    wanted = np.array([all(beyond(l, i, j) <= 0 for i in range(6) for j in range(i)) for l in q])
    assert 40 < wanted.sum() < 360
    for machine in (nist, far):
        fits, why = possible_lengths(machine, q)
        assert fits.tolist() == wanted.tolist()
        for row in np.flatnonzero(~fits):
            i, j = (int(name[-1]) - 1 for name in why(row)[1].split(" and "))
            assert beyond(q[row], i, j) > 0
