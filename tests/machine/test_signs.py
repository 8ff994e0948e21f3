"""Signs that no other test saw when `make mutate` turned them."""

from __future__ import annotations

import casadi as ca
import numpy as np
from numpy.testing import assert_allclose

from gough.frames import quaternion_of_abc_np, rotation_of_abc_np
from gough.machine import forward, reactions
from gough.machine.hexapod_parts import JointFriction
from gough.machine.workspace import random_poses
from gough.mechanics.load_friction import LoadStribeck
from gough.simulate import tick


def test_friction_between_the_tubes_takes_from_the_drive_what_the_joints_then_do_not_carry(nist):
    """Loads at a drive force u are the reactions at the net force u - friction: the friction is inside the strut."""
    m = nist.replace(**{"joints.friction": JointFriction(coefficient=0.01, platform_radius=0.04, base_radius=0.05)})
    rng = np.random.default_rng(8)
    for x in random_poses(m, 5, rng):
        z = ca.DM([*x[:3], *quaternion_of_abc_np(x[3:])])
        v, vd = ca.DM(rng.normal(size=6)), ca.DM(10 * rng.normal(size=6))
        memory, u = ca.DM(1e-7 * rng.normal(size=m.memory_count)), ca.DM(1e4 * rng.normal(size=6))
        loads = np.array(ca.evalf(ca.SX(m.loads_of(m, z, v, vd, memory, u)))).ravel()
        lost = m.strut_friction(m, m.jacobian_of(m, z) @ v, memory, loads[:6])
        found = m.reactions_of(m, z, v, vd, u - lost)
        R_B, R_A = (np.array(ca.evalf(ca.SX(R))) for R in (found.platform_joint, found.base_joint))
        assert np.abs(np.array(ca.evalf(ca.SX(lost)))).min() > 10  # N: so a wrong sign would be seen below
        assert_allclose(loads[6:12], np.linalg.norm(R_B, axis=0), rtol=1e-12)
        assert_allclose(loads[12:], np.linalg.norm(R_A, axis=0), rtol=1e-12)


def test_the_magnitude_of_a_force_is_a_number_at_zero_and_so_is_its_derivative():
    x = ca.SX.sym("x", 3)
    f = ca.Function("f", [x], [reactions.magnitude(x), ca.jacobian(reactions.magnitude(x), x)])
    value, slope = f([0, 0, 0])
    assert 0 < float(value) < 1e-3 and np.array(slope).ravel().tolist() == [0, 0, 0]  # a thousandth of a newton
    assert_allclose(float(f([3, 4, 12])[0]), 13, rtol=1e-6)


def test_a_slender_part_beside_a_cross_is_the_body_with_the_same_inertia(okuma):
    """With a cross the general equations take slender parts, too: as bodies diag(transverse, transverse, axial)."""
    numbers = {"moving": (2.0, 1.5), "fixed": (0.4, 0.7)}  # kg m2, axial large enough to count
    slender = okuma.replace(**{"joints.cross": 0.05}).replace(
        **{f"strut.{part}.{key}": value for part, pair in numbers.items()
           for key, value in zip(("transverse", "axial"), pair, strict=True)}
    )  # fmt: skip
    parts = {
        part: getattr(slender.strut, part).replace(
            transverse=None, axial=None, inertia=np.diag([across, across, axial])
        )
        for part, (across, axial) in numbers.items()
    }
    bodies = slender.replace(strut=slender.strut.replace(**parts))
    rng = np.random.default_rng(9)
    x, V, Vd = random_poses(okuma, 50, rng), rng.normal(size=(50, 6)), 10 * rng.normal(size=(50, 6))
    u = slender.inverse_dynamics(x, V, Vd)
    assert_allclose(bodies.inverse_dynamics(x, V, Vd), u, rtol=1e-11, atol=1e-9)  # N, of thousands: rounding
    none = slender.replace(**{"strut.moving.axial": 0.0, "strut.fixed.axial": 0.0})
    assert np.abs(none.inverse_dynamics(x, V, Vd) - u).max() > 0.1  # N: so a wrong sign would be seen


def test_friction_under_a_load_is_offset_plus_coefficient_times_load():
    law = LoadStribeck(
        coulomb=0.2, static=0.3, stribeck=2e-3, viscous=0.5, coulomb_offset=30.0, viscous_offset=100.0, smoothing=1e-9
    )
    for load, v in ((0.0, 1.0), (1000.0, 1.0), (2000.0, -0.5)):
        found = float(ca.evalf(ca.SX(law.force(law, ca.DM(v), ca.DM(0), ca.DM(load)))))
        assert_allclose(found, (30 + 0.2 * load) * np.sign(v) + (100 + 0.5 * load) * v, rtol=1e-14)
    slow = float(ca.evalf(ca.SX(law.force(law, ca.DM(1e-6), ca.DM(0), ca.DM(1000.0)))))
    assert_allclose(slow, 30 + 0.3 * 1000, rtol=1e-5)  # breakaway; (v / v_s)^2 is 2.5e-7


def test_margins_are_what_is_left_of_stroke_cones_and_determinant(okuma):
    z = ca.DM([0.05, -0.04, -1.0, *quaternion_of_abc_np([0.1, -0.1, 0.05])])
    names, values = okuma.margins(okuma, z)
    left = dict(zip(names, np.array(ca.evalf(ca.SX(values))).ravel(), strict=True))
    pose = np.array([0.05, -0.04, -1.0, 0.1, -0.1, 0.05])

    def struts(x):
        R = rotation_of_abc_np(x[3:])
        s = x[:3] + okuma.joints.platform @ R.T - okuma.joints.base
        l = np.linalg.norm(s, axis=1)
        return l, s / l[:, None], s / l[:, None] @ R

    (l, n, n_T), (_, home, home_T) = struts(pose), struts(okuma.home)
    shortest, longest = okuma.limits.length
    for i in range(6):
        strut = f"strut {i + 1}"
        assert_allclose(left[f"{strut}: too short"], l[i] - shortest, atol=1e-14)
        assert_allclose(left[f"{strut}: too long"], longest - l[i], atol=1e-14)
        for end, now, then in (("base", n, home), ("platform", n_T, home_T)):
            cosine = now[i] @ then[i] - np.cos(okuma.limits.cone)
            assert_allclose(left[f"{strut}: {end} joint beyond its cone"], cosine, atol=1e-14)
    ratio = np.linalg.det(okuma.jacobian(pose)) / np.linalg.det(okuma.jacobian(okuma.home))
    assert_allclose(left["near a singularity: det J against home"], ratio - okuma.limits.determinant, atol=1e-12)


def test_friction_in_the_joints_slows_the_plant(okuma):
    rubbing = okuma.replace(
        **{"joints.friction": JointFriction(coefficient=0.3, platform_radius=0.05, base_radius=0.05)}
    )
    z = ca.DM(ca.evalf(ca.SX(okuma.coordinates_of(okuma, ca.DM(okuma.home)))))
    v, u, w = ca.DM([0.1, 0.2, -0.1, 0.5, -0.4, 0.3]), ca.DM.zeros(6), ca.DM.zeros(6)
    memory, loads = ca.DM.zeros(0), ca.DM([1000.0] * 12)
    _, with_it = tick.rate(rubbing, rubbing, z, v, memory, u, w, loads)
    _, without = tick.rate(okuma, okuma, z, v, memory, u, w, ca.DM.zeros(0))
    M = okuma.mass_matrix(okuma.home)
    power = np.array(v).ravel() @ M @ np.array(ca.evalf(ca.SX(with_it - without))).ravel()
    assert power < -1  # W; 12 joints of 1 kN x 0.3 x 0.05 m, at some tenths of a rad/s each


def test_a_newton_step_moves_the_platform_by_a_quarter_of_the_longest_chord_at_most(library_machine):
    """Joints a metre longer than home's from home: the step along the tool axis is cut to its bound."""
    m = library_machine
    (z0,) = m.arrays.run("coordinates", m.home)
    z1, size = m.arrays.run("newton", z0, m.inverse_kinematics(m.home) + 1.0)
    reach = 0.25 * max(np.linalg.norm(A - B) for A, B in zip(m.joints.base, m.joints.platform, strict=True))
    step = np.linalg.norm(z1[:3] - z0[:3])
    # the step is along z to the symmetry of the sheets' joints, given to 1e-9 m
    assert_allclose(step, reach, rtol=1e-6)
    assert_allclose(size[0], step, rtol=1e-6)


def test_lengths_are_refused_beyond_the_chords_between_their_joints_and_not_before(library_machine):
    """Two struts and the chords |A_i A_j|, |B_i B_j| close a quadrangle, or they cannot be there."""
    m = library_machine
    q = np.random.default_rng(11).uniform(0.1, 3.0, (3000, 6))
    fits = np.ones(len(q), bool)
    for i in range(6):
        for j in range(i):
            chords = sum(np.linalg.norm(p[i] - p[j]) for p in (m.joints.base, m.joints.platform))
            fits &= np.abs(q[:, i] - q[:, j]) <= chords
    assert 30 < fits.sum() < 2970, "rows of both fates"
    np.testing.assert_array_equal(forward.impossible(m, q)[0], fits)
