"""Signs and orders, as numbers worked out by hand.

No identity can see a convention that is turned round consistently; these can.
"""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest
from numpy.testing import assert_allclose

from gough import frames
from gough.machine.hexapod_parts import Tool
from gough.machine.sheet import load_machine

EX, EY, EZ = np.eye(3)
RIGHT = np.pi / 2
ROOT_HALF = 0.7071067811865476


@pytest.fixture(scope="module")
def nist():
    return load_machine("nist-octahedral")


@pytest.fixture(scope="module")
def okuma():
    return load_machine("okuma-pm600")


def symbolic(function, *columns):
    return np.array(ca.DM(function(*(ca.DM(c) for c in columns)))).squeeze()


# -- rotations --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("abc", "images"),
    [
        ((RIGHT, 0, 0), (EX, EZ, -EY)),  # a: about x, y goes to z
        ((0, RIGHT, 0), (-EZ, EY, EX)),  # b: about y, z goes to x
        ((0, 0, RIGHT), (EY, -EX, EZ)),  # c: about z, x goes to y
        ((RIGHT, 0, RIGHT), (EY, EZ, EX)),  # a first, then c about the fixed z
        ((RIGHT, RIGHT, 0), (-EZ, EX, -EY)),  # a first, then b about the fixed y
    ],
)
def test_a_b_c_turn_about_the_fixed_x_then_y_then_z(abc, images):
    R = np.stack(images, 1)
    assert_allclose(frames.rotation_of_abc_np(np.array(abc)), R, atol=1e-15)
    assert_allclose(symbolic(frames.rotation_of_abc, abc), R, atol=1e-15)


def test_a_general_rotation_by_hand():
    """a, b, c = 30, 45, 60 deg with sines and cosines of the tables."""
    R = [
        [0.3535533905932738, -0.5732233047033631, 0.7391989197401166],
        [0.6123724356957945, 0.7391989197401166, 0.2803300858899106],
        [-0.7071067811865476, 0.3535533905932738, 0.6123724356957945],
    ]
    assert_allclose(frames.rotation_of_abc_np(np.radians([30, 45, 60])), R, atol=1e-15)
    assert_allclose(frames.abc_of_rotation_np(R), np.radians([30, 45, 60]), atol=1e-15)


@pytest.mark.parametrize(("axis", "abc"), [(1, (RIGHT, 0, 0)), (2, (0, RIGHT, 0)), (3, (0, 0, RIGHT))])
def test_a_quaternion_is_w_x_y_z(axis, abc):
    wanted = np.array([ROOT_HALF, 0, 0, 0])
    wanted[axis] = ROOT_HALF
    assert_allclose(frames.quaternion_of_abc_np(np.array(abc)), wanted, atol=1e-15)
    assert_allclose(symbolic(frames.quaternion_of_abc, abc), wanted, atol=1e-15)


def test_quaternions_multiply_as_hamilton_carved_it():
    i, j, k = np.eye(4)[1:]
    assert_allclose(symbolic(frames.quaternion_product, i, j), k)
    assert_allclose(symbolic(frames.quaternion_product, j, k), i)
    assert_allclose(symbolic(frames.quaternion_product, k, i), j)
    assert_allclose(symbolic(frames.quaternion_product, i, i), [-1, 0, 0, 0])


def test_angular_velocity_is_in_the_fixed_frame():
    """Turned by c = 90 deg, a spin about the world's x moves the tool's x (now along y) towards the world's z."""
    quat = frames.quaternion_of_abc_np(np.array([0, 0, RIGHT]))
    # (0, w) q / 2 = (0, 1, 0, 0) (r, 0, 0, r) / 2 = (0, r, -r, 0) / 2
    assert_allclose(symbolic(frames.quaternion_rate, quat, EX), [0, ROOT_HALF / 2, -ROOT_HALF / 2, 0], atol=1e-16)


def test_a_positive_rotation_vector_about_z_is_a_positive_c():
    assert_allclose(frames.rotation_of_vector_np(np.array([0, 0, RIGHT])), np.stack([EY, -EX, EZ], 1), atol=1e-15)
    assert_allclose(
        symbolic(frames.quaternion_of_rotation_vector, [0, 0, RIGHT]), [ROOT_HALF, 0, 0, ROOT_HALF], atol=1e-15
    )
    assert_allclose(
        symbolic(frames.rotation_vector_of_quaternion, [ROOT_HALF, 0, 0, ROOT_HALF]), [0, 0, RIGHT], atol=1e-15
    )


def test_angle_rates_make_a_spin_about_fixed_axes():
    """With b = 90 deg and c = 0 the axis of a points along -z: a' and c' cancel."""
    E = frames.abc_rate_matrix_np(np.array([0.3, RIGHT, 0.0]))
    assert_allclose(E, [[0, 0, 0], [0, 1, 0], [-1, 0, 1]], atol=1e-15)


# -- struts, twists and wrenches --------------------------------------------------------------------------------------


def test_a_pose_is_x_y_z_a_b_c_of_the_tool_and_lengths_run_from_base_to_platform(nist):
    """Strut 1 of nist at home, by hand: B - A = (0.102378752, -1.263093620, -1.1) m."""
    assert_allclose(nist.inverse_kinematics([0, 0, 0, 0, 0, 0])[0], 1.678060458311, rtol=1e-12)
    # the tool 0.1 m lower: -1.2 instead of -1.1
    assert_allclose(
        nist.inverse_kinematics([0, 0, -0.1, 0, 0, 0])[0], np.sqrt(0.102378752**2 + 1.26309362**2 + 1.44), rtol=1e-12
    )
    # turned by c = 90 deg, joint 1 stands at (-0.317207725, -0.147916392, 0)
    s = np.array([-0.317207725 + 0.250295144, -0.147916392 - 1.580301345, -1.1])
    assert_allclose(nist.inverse_kinematics([0, 0, 0, 0, 0, RIGHT])[0], np.sqrt(s @ s), rtol=1e-12)


@pytest.fixture(scope="module")
def plumb(nist):
    """nist with a vertical strut 1, above a platform joint at x = 0.3 m."""
    base, platform = nist.joints.base.copy(), nist.joints.platform.copy()
    base[0], platform[0] = [0.3, 0, 1.1], [0.3, 0, 0]
    return nist.replace(**{"joints.base": base, "joints.platform": platform, "limits.length": [1.0, 2.0]})


def test_a_row_of_the_jacobian_is_n_and_b_x_n(plumb):
    """n = -z, b = 0.3 x: b x n = 0.3 (x X -z) = 0.3 y."""
    assert_allclose(plumb.jacobian(plumb.home)[0], [0, 0, -1, 0, 0.3, 0], atol=1e-15)


@pytest.mark.parametrize(
    ("twist", "rate"),
    [
        ((0, 0, 1, 0, 0, 0), -1.0),  # the tool rises towards the base above it: the strut shortens
        ((0, 0, 0, 0, 1, 0), 0.3),  # a spin about +y lowers what lies at +x: the strut lengthens
        ((1, 0, 0, 0, 0, 0), 0.0),
        ((0, 0, 0, 1, 0, 0), 0.0),
    ],
)
def test_a_twist_is_velocity_then_spin(plumb, twist, rate):
    qd = plumb.joint_motion(plumb.home, twist, np.zeros(6))[1]
    assert_allclose(qd[0], rate, atol=1e-15)


def test_struts_that_carry_a_hanging_platform_pull(nist, okuma):
    """u > 0 lengthens.  Massless struts of nist at home: u = -m g / (6 cos) = -300 x 9.81 / (6 x 0.655518694) N."""
    rest = [np.zeros(6), np.zeros(6)]
    assert_allclose(nist.replace(strut=None).inverse_dynamics(nist.home, *rest), -748.2620, atol=1e-3)
    assert_allclose(nist.inverse_dynamics(nist.home, *rest), -1600.5955, atol=1e-3)
    assert_allclose(okuma.inverse_dynamics(okuma.home, *rest), -482.6534, atol=1e-3)


def test_struts_that_carry_a_standing_platform_push(nist):
    """The same platform 1.1 m above its base joints instead of below them."""
    standing = nist.replace(home=[0, 0, 2.2, 0, 0, 0], strut=None)
    assert_allclose(standing.inverse_dynamics(standing.home, np.zeros(6), np.zeros(6)), 748.2620, atol=1e-3)


def test_gravity_points_down_z_and_may_point_elsewhere(nist):
    assert nist.gravity.tolist() == [0, 0, -9.81]
    free = nist.replace(strut=None, **{"drive.inertia": None})
    assert_allclose(free.forward_dynamics(free.home, np.zeros(6), np.zeros(6)), [0, 0, -9.81, 0, 0, 0], atol=1e-12)
    side = free.replace(gravity=[0, -9.81, 0])
    assert_allclose(side.forward_dynamics(side.home, np.zeros(6), np.zeros(6)), [0, -9.81, 0, 0, 0, 0], atol=1e-12)


def test_a_wrench_acts_on_the_tool(nist, okuma):
    """1000 N upwards on the tool relieves every hanging strut by 1000 / (6 cos) N."""
    rest = [np.zeros(6), np.zeros(6)]
    for m, cosine in ((nist, 0.655518694), (okuma, 0.732569821)):
        change = m.inverse_dynamics(m.home, *rest, wrench=[0, 0, 1000, 0, 0, 0]) - m.inverse_dynamics(m.home, *rest)
        assert_allclose(change, 1000 / (6 * cosine), rtol=1e-8)


def test_a_wrench_is_force_then_moment_in_axes_of_W(nist):
    """100 N m about z: the struts that lengthen under +c (1, 3, 5; b x n = +0.0919851 m) are relieved of push."""
    rest = [np.zeros(6), np.zeros(6)]
    change = nist.inverse_dynamics(nist.home, *rest, wrench=[0, 0, 0, 0, 0, 100]) - nist.inverse_dynamics(
        nist.home, *rest
    )
    assert_allclose(change, 100 / (6 * 0.091985315) * np.array([-1, 1, -1, 1, -1, 1]), rtol=1e-6)


def test_a_push_of_the_drives_lengthens_the_struts(okuma):
    rest = okuma.inverse_dynamics(okuma.home, np.zeros(6), np.zeros(6))
    a = okuma.forward_dynamics(okuma.home, np.zeros(6), rest + 100)
    qdd = okuma.joint_motion(okuma.home, np.zeros(6), a)[2]
    assert (qdd > 0).all() and a[2] < 0  # a hanging tool goes down


# -- the tool frame ---------------------------------------------------------------------------------------------------


def test_p_PT_is_the_tip_seen_from_the_platform(okuma):
    """okuma's joints lie 0.4 m above its tip: a platform frame in their plane has its tip at z = -0.4 m."""
    joints = okuma.joints.platform - [0, 0, 0.4]
    told = okuma.replace(
        tool=Tool(position=[0, 0, -0.4]), **{"joints.platform": joints, "platform.center": [0, 0, -0.02]}
    )
    x = [0.05, -0.04, -1.02, 0.1, -0.1, 0.2]
    assert_allclose(told.inverse_kinematics(x), okuma.inverse_kinematics(x), rtol=1e-15)
    motion = np.array([0.3, -0.2, 0.4, 0.5, -0.6, 0.7]), np.array([3.0, -2, 4, 5, -6, 7])
    assert_allclose(told.inverse_dynamics(x, *motion), okuma.inverse_dynamics(x, *motion), rtol=1e-12)


def test_R_PT_turns_axes_of_the_tool_into_axes_of_the_platform(okuma):
    """With c = 90 deg the tool's x axis is the platform's y: the platform's joint at +x lies at -y of the tool."""
    platform = okuma.joints.platform.copy()
    platform[0] = [0.28, 0, 0.4]
    turned = okuma.replace(tool=Tool(position=[0, 0, 0], angles=[0, 0, RIGHT]), home=[0, 0, -1.008, 0, 0, RIGHT],
                           **{"joints.platform": platform, "limits.length": [0.3, 2.0]})  # fmt: skip
    assert_allclose(turned.platform_joints_np()[0], [0, -0.28, 0.4], atol=1e-15)
