"""Parts of the study of Bouzgarrou et al., 2001: the move, the mirror image, gains, and the rigid rows."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from gough.machine.workspace import random_poses
from gough.study.bouzgarrou2001 import checks, continuous, rigid
from gough.study.bouzgarrou2001.move import SinusoidalMove
from gough.study.bouzgarrou2001.setup import (
    END,
    HIGH,
    LOW,
    OFF,
    PERIOD,
    PRINTED,
    START,
    cascade,
    computed_torque,
    machine,
    mirrored,
    move,
    perturbed,
    sheet,
)


def test_the_times_of_the_move_are_0_4449_and_0_4157_s_by_double_integration_of_its_acceleration():
    """MACHINES.md 4.2, item 2; speeds to 1.42, 2.83 and 2.65 m/s."""
    made = move()
    assert_allclose(made.times, [0.4449, 0.4449, 0.4157], atol=5e-5)
    t = np.linspace(0, made.times.max(), 200_001)
    p, pd, pdd, *_ = made.poses(t)
    assert_allclose(np.abs(pdd).max(0), [10, 20, 20], rtol=1e-6)
    assert_allclose(np.abs(pd).max(0), [1.42, 2.83, 2.65], atol=5e-3)
    step = t[1]
    speed = np.concatenate([np.zeros((1, 3)), np.cumsum((pdd[1:] + pdd[:-1]) / 2, axis=0) * step])
    place = np.concatenate([np.zeros((1, 3)), np.cumsum((pd[1:] + pd[:-1]) / 2, axis=0) * step])
    # trapezoids: step^2 T / 12 times a derivative of 2e4 m/s4
    assert_allclose(speed, pd, rtol=0, atol=1e-8)
    assert_allclose(place, p, rtol=0, atol=1e-9)
    assert_allclose(START + p[-1], END, rtol=0, atol=1e-15)


def test_jerks_are_differences_of_the_acceleration():
    made, h = move(), 1e-7
    assert_allclose((made.poses([h])[2] / h)[0], np.sign(made.distance) * made.jerks, rtol=1e-6)
    assert SinusoidalMove(distance=[0, 0.1, 0], amplitude=[1, 1, 1]).jerks[0] == 0


def test_the_path_of_chords_is_nowhere_farther_than_1_um_from_the_motion():
    m, made = machine(), move()
    motion = made.plan(m)
    rows = motion.sample(0, motion.count(PERIOD), PERIOD)
    book = motion.book(0, motion.count(PERIOD), PERIOD)
    on = np.flatnonzero(book.counted)
    point = motion.path.point(book.block[on], book.u[on])
    assert np.linalg.norm(point - rows.x[on], axis=1).max() < 1e-6
    assert_allclose(rows.x[-1], END, rtol=0, atol=1e-15)
    assert np.abs(rows.xd[-1]).max() == 0 and np.abs(rows.xdd[-1]).max() == 0


def test_the_mirror_image_moves_like_its_image():
    """The same slides, forces and masses at the mirrored place; mirrored twice it is itself."""
    m, rng = sheet(), np.random.default_rng(1)
    m = m.replace(link2=m.link2.replace(inertia=[[22, 1, -2], [1, 18, 3], [-2, 3, 25]]))
    image, flip = mirrored(m), np.array([-1.0, 1, 1])
    assert mirrored(image) == m
    x = random_poses(m, 50, rng)
    xd, xdd = rng.normal(size=x.shape), rng.normal(size=x.shape) * 10
    assert_allclose(image.inverse_kinematics(flip * x), m.inverse_kinematics(x), rtol=0, atol=1e-14)
    u = m.inverse_dynamics(x, xd, xdd)
    assert_allclose(image.inverse_dynamics(flip * x, flip * xd, flip * xdd), u, rtol=0, atol=1e-11 * np.abs(u).max())
    assert_allclose(image.velocity_mass(flip * x), m.velocity_mass(x), rtol=0, atol=1e-10)
    random_poses(image, 50, rng)  # its limits are mirrored too


def test_forces_of_the_move_on_the_sheets_machine_are_those_of_the_data_page():
    """MACHINES.md 4.3: 5.7, 19.0 and 6.3 kN."""
    t = np.linspace(0, 0.45, 901)
    p, pd, pdd, *_ = move().poses(t)
    u = sheet().inverse_dynamics(START + p, pd, pdd)
    assert_allclose(np.abs(u).max(0) / 1e3, [5.7, 19.0, 6.3], atol=0.05)


def test_both_laws_have_the_poles_of_the_printed_gains():
    for gains in (LOW, HIGH):
        law = cascade(gains)
        K_v, w, w_i = law.gains(law)
        assert_allclose([w, w * (K_v + w_i), w * w_i * K_v], gains, rtol=1e-12)
        assert computed_torque(gains).gains(computed_torque(gains)) == gains
    assert_allclose([2 * LOW.k_d, 4 * LOW.k_p, 8 * LOW.k_i], HIGH, rtol=0)  # at half the pace
    assert checks.cascade_share(PRINTED) < 1 < checks.cascade_share(LOW)
    assert checks.damping(LOW) == 1


def test_sixteen_machines_have_their_centres_off_by_a_fifth_and_nothing_else():
    m = machine()
    made = perturbed(m)
    assert len(made) == 16
    assert {round(float(other.arm.center / m.arm.center), 9) for other in made} == {1 - OFF, 1 + OFF}
    corner = made[-1]  # all outwards
    assert_allclose(corner.link2.center, 1.2 * m.link2.center, rtol=1e-15)
    assert_allclose(corner.ram.center - m.ram.center, [0.2 * m.base.half_width, 0, 0], atol=1e-15)
    assert corner.link2.mass == m.link2.mass and (corner.ram.inertia == m.ram.inertia).all()


@pytest.mark.full
def test_the_repaired_c_s_is_the_machines_own():
    found = checks.elimination(None)
    assert found.repaired < 1e-12 * found.largest < 0.1 * found.printed


@pytest.mark.full
def test_the_sampled_loop_becomes_the_continuous_one():
    """PID, high gains: the speed of a sample's mean is a Ts / 2 late, of which k_V makes a Ts / (2 k_V); a the
    greatest acceleration of a slide.  Half of it at half the sample."""
    m, p, pd, pdd = machine(), *move().poses(np.linspace(0, 0.45, 901))[:3]
    a, k_V = np.abs(m.joint_motion(START + p, pd, pdd)[2]).max(), 100.0
    wanted = continuous.follow("PID", HIGH, m)
    off = []
    for period in (PERIOD, PERIOD / 2):
        course = rigid.run("PID", HIGH, period=period)
        at = np.rint(wanted.t / period).astype(int)
        off.append(np.abs(course.e[at] - wanted.e).max())
    # 10 %: the acceleration changes within the time of the loop, and forces are held half a sample too
    assert off[0] == pytest.approx(a * PERIOD / (2 * k_V), rel=0.1)
    assert off[1] / off[0] == pytest.approx(0.5, rel=0.02)
