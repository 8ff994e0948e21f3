"""Machines that give way: rest, stiffness, modes, energy; what is refused."""

from __future__ import annotations

import copy
import pickle

import casadi as ca
import numpy as np
import pytest
from numpy.testing import assert_allclose

import gough as gk
from gough.errors import ExperimentError, KinematicsError, SheetError, WorkspaceError
from gough.kernel import Schedule, Signal, compile
from gough.machine.vibration import small_motions, stiffness_map
from gough.simulate import tick

SOFT = [
    {"joint": "struts", "stiffness": 2e7},
    {"joint": "base joints", "stiffness": [4e7, 1e7, 2e7]},
    {"joint": "platform joints", "stiffness": [2e7, 4e7, 1e7]},
]
POSE = np.array([0.1, 0.05, 0.02, 0.1, -0.1, 0.2])


@pytest.fixture(scope="module")
def nist():
    return gk.load_machine("nist-octahedral")


@pytest.fixture(scope="module")
def flexible(nist):
    return nist.flexible()


# -- what is refused --------------------------------------------------------------------------------------------------


def refusal(machine, *entries, kind=SheetError):
    with pytest.raises(kind) as caught:
        machine.replace(compliance=list(entries)).flexible()
    return str(caught.value)


def test_a_joint_that_is_not_there_is_refused_with_the_nearest(nist):
    assert refusal(nist, {"joint": "strutts", "stiffness": 1e8}) == (
        "compliance.0.joint: no joint of this machine that may give way, got 'strutts'; did you mean struts?"
    )
    assert refusal(nist, {"joint": "strut 7", "stiffness": 1e8}) == (
        "compliance.0.joint: no joint of this machine has this number, got 'strut 7'; there is 1, 2, 3, 4, 5, 6"
    )
    assert refusal(gk.load_machine("ifma-hsm"), {"joint": "slide 2", "stiffness": 1e8}) == (
        "compliance.0.joint: no joint of this machine has this number, got 'slide 2'; there is 1, 6"
    )


def test_a_joint_is_named_once_whether_alone_or_among_all(nist):
    entries = {"joint": "struts", "stiffness": 1e8}, {"joint": "strut 3", "stiffness": 2e8}
    assert refusal(nist, *entries) == "compliance.1.joint: this joint is there already, got strut 3"


def test_joints_that_carry_forces_across_the_drives_must_be_rigid():
    assert refusal(gk.load_machine("ccu-3prs"), {"joint": "hinge 2", "stiffness": 1e8}) == (
        "compliance.0.joint: tripod: the hinge must be rigid: it carries forces across its drive, which a spring along "
        "the drive knows nothing of, got 'hinge 2'"
    )


def test_a_strut_has_one_stiffness_and_a_slide_six(nist):
    assert refusal(nist, {"joint": "struts", "stiffness": [1e8, 1e8, 1e8]}) == (
        "compliance.0.stiffness: struts gives way along itself only; give one number, in N/m"
    )
    hybrid = gk.load_machine("ifma-hsm")
    assert refusal(hybrid, {"joint": "slides", "stiffness": 1e8}) == (
        "compliance.0.stiffness: slides gives way in six components; give six numbers, N/m and N m/rad; a rigid "
        "component gets a large one"
    )
    assert refusal(hybrid, {"joint": "slide 6", "stiffness": [1e8] * 6}, kind=ExperimentError) == (
        "compliance: both slides give way or none: the flexible machine has six components at each, got none of slide "
        '1; name joint = "slides"'
    )


def test_a_machine_that_says_nothing_of_its_joints_is_not_made_flexible(nist):
    with pytest.raises(ExperimentError) as caught:
        nist.replace(compliance=None).flexible()
    assert str(caught.value) == (
        "flexible: nist-octahedral has no [[compliance]]: nothing in it gives way; give [[compliance]] with joint = "
        '... (drives, struts, base joints, platform joints) and stiffness = "..."'
    )


def test_every_drive_needs_a_spring_and_a_mass_before_it(nist):
    assert refusal(nist, {"joint": "strut 2", "stiffness": 1e8}, kind=ExperimentError) == (
        "compliance: every drive needs an elastic joint on its way to the platform, got none of strut 1, strut 3, "
        'strut 4, strut 5, strut 6; name all of a sort, as in joint = "drives"; a stiff one gets a large stiffness'
    )
    light = nist.replace(**{"drive.inertia": None})
    assert refusal(light, {"joint": "struts", "stiffness": 1e8}, kind=ExperimentError) == (
        "drive.inertia: an elastic drive needs mass on its motor's side of the spring, got 0 kg at strut 1; give "
        "drive.inertia (a screw), or use a machine whose motors are heavy"
    )


def test_what_only_a_rigid_machine_has_is_refused(flexible):
    with pytest.raises(ExperimentError, match="asked of the rigid one; use .rigid"):
        flexible.inverse_dynamics(flexible.home, np.zeros(6), np.zeros(6))
    with pytest.raises(ExperimentError, match='must be "motor" or "joint"'):
        flexible.rigid.flexible(measured="tool")
    with pytest.raises(ExperimentError, match="direction has three numbers"):
        flexible.static_stiffness(flexible.home, [0, 0, 0])
    with pytest.raises(ExperimentError, match="direction must be finite"):
        flexible.static_stiffness(flexible.home, [0, np.nan, 1])
    with pytest.raises(ExperimentError, match="rest is of one pose at a time"):
        flexible.at_rest(np.zeros((2, 6)))
    with pytest.raises(ExperimentError, match="wrench must be finite"):
        flexible.modes(flexible.home, wrench=[np.inf] * 6)
    with pytest.raises(ExperimentError, match="numbers above 0"):
        flexible.frequency_response(flexible.home, [0.0, 1.0])


@pytest.mark.full
def test_a_machine_too_soft_to_stand_is_refused_by_name(nist):
    """Softer than its weight bends: the platform hangs beyond its limits, an arm turns over."""
    with pytest.raises(WorkspaceError) as caught:
        nist.flexible(stiffness=1e-5).at_rest(nist.home)
    assert "at rest under gravity and load" in str(caught.value)
    hybrid = gk.load_machine("ifma-hsm")
    # the ram upright: m g l of some 2 kN m against 280 N m/rad of each slide
    with pytest.raises(KinematicsError, match="no stable rest under gravity and load: .* least stiffness -"):
        hybrid.replace(gravity=[0, 0, -9.81]).flexible(stiffness=1e-4).at_rest([0, 1.2, 0.5])
    with pytest.raises(WorkspaceError, match="target unreachable under gravity: slide 1: beyond the end of its travel"):
        hybrid.replace(**{"limits.travel": [[0.7, 1.2001], [0.7, 2.2], [-0.06, 0.65]]}).flexible(stiffness=0.1).targets(
            hybrid.home + [0, 0, 0.1]
        )


def test_a_flexible_machine_is_copied_and_sent_to_workers_whole():
    flexible = gk.load_machine("okuma-pm600").flexible()  # a fresh one: what is compiled of a machine does not travel
    for other in (copy.deepcopy(flexible), pickle.loads(pickle.dumps(flexible))):
        assert other == flexible and hash(other) == hash(flexible)
    assert flexible != flexible.rigid.flexible(stiffness=2.0)
    assert flexible.structure() == flexible.rigid.flexible(stiffness=2.0).structure()  # one program serves both


# -- rest -------------------------------------------------------------------------------------------------------------


def test_the_compliance_of_a_hexapod_is_that_of_six_springs_along_its_struts(nist):
    """Without gravity: C_T = J^-1 diag(c) J^-T, by the Jacobian of the rigid machine."""
    still = nist.replace(gravity=[0, 0, 0.0])
    J, x = nist.jacobian(nist.home + POSE), nist.home + POSE
    c = 1 / 400e6 + 2 / 800e6  # the sheet's struts and joints
    wanted = np.linalg.inv(J) @ (c * np.linalg.inv(J).T)
    assert_allclose(still.flexible().tool_compliance(x), wanted, rtol=1e-9, atol=1e-9 * np.abs(wanted).max())


def test_a_small_force_moves_the_tool_by_the_compliance_there(flexible):
    """Two rests apart, by Newton's method, against the derivative at one of them, gravity in both."""
    x = flexible.home + POSE
    C = flexible.tool_compliance(x)
    for k, wrench in enumerate(np.diag([10.0] * 3 + [5.0] * 3)):
        plus, minus = (flexible.settled_pose(x, sign * wrench) for sign in (1, -1))
        moved = (plus - minus)[:3] / 2
        # rest is found to 1e-13 m of some 1e-7
        assert_allclose(moved, C[:3, k] * wrench[k], rtol=1e-5, atol=1e-12)


@pytest.mark.full
@pytest.mark.parametrize("name", ["nist-octahedral", "eth-hexaglide", "ccu-3prs", "okuma-pm600"])
def test_springs_a_million_times_as_stiff_leave_the_rigid_machine_at_rest(name):
    m = gk.load_machine(name)
    hard = m.flexible(stiffness=1e6)
    x = m.home + POSE[: len(m.task)] / 10
    z, u = hard.at_rest(x)
    still = np.zeros(len(x))
    # u follows from s / c: the last digit of a strut, 2e-16 m, is 2e-16 m x 2e14 N/m = 0.05 N
    assert_allclose(u, m.inverse_dynamics(x, still, still), atol=0.5)
    assert_allclose(hard.settled_pose(x), m.tool_pose(x), atol=1e-10)


def test_encoders_at_the_joints_see_what_the_springs_give_way(nist):
    x = nist.home + POSE
    at_joint, at_motor = nist.flexible(measured="joint"), nist.flexible()
    assert np.abs(at_motor.settled_pose(x) - x).max() > 1e-5
    assert_allclose(at_joint.settled_pose(x), x, atol=1e-12)  # a hexapod's struts say all of its platform
    assert_allclose(at_joint.targets(x), nist.inverse_kinematics(x), atol=1e-12)
    sag = at_motor.targets(x) - nist.inverse_kinematics(x)
    u = nist.inverse_dynamics(x, *np.zeros((2, 6)))  # what the struts carry with the tool at x
    assert_allclose(sag, u * (1 / 400e6 + 2 / 800e6), rtol=1e-6, atol=1e-12)  # each longer by its force on its springs


# -- small motions ----------------------------------------------------------------------------------------------------


def test_stiffness_and_mass_at_rest_are_symmetric_and_the_damping_proportional(nist):
    one = small_motions(nist.frictionless().flexible(), nist.home + POSE)
    for A in (one.M, one.D, one.K):
        assert np.abs(A - A.T).max() < 1e-9 * np.abs(A).max()
    beta = 0.02 / (np.pi * 40.0)
    geometric = one.K - one.D / beta  # gravity and the forces in the struts: small, and no damper knows it
    assert 0 < np.abs(geometric).max() < 1e-3 * np.abs(one.K).max()


@pytest.mark.full
def test_the_frequency_response_is_that_of_the_linearised_plant(nist):
    """Two ways: M, D, K here, and A, B, C of `gk.linearize`, which differentiates the tick's own rate."""
    m = nist.frictionless().flexible()
    x, f = nist.home, np.array([3.0, 30.0, 300.0])
    A, B, C, D = gk.linearize(m, x)
    s = 2j * np.pi * f[:, None, None]
    wanted = C @ np.linalg.solve(s * np.eye(len(A)) - A, np.broadcast_to(B, (3, *B.shape))) + D
    found = m.frequency_response(x, f)  # displacement and turn; at home a b c are turns about x y z
    assert_allclose(found, wanted, rtol=1e-6, atol=1e-9 * np.abs(wanted).max())


def test_far_below_the_modes_a_force_moves_the_rigid_machine(nist):
    m = nist.frictionless().replace(gravity=[0, 0, 0.0])
    f = 0.05
    rigid = -np.linalg.solve(m.mass_matrix(m.home), m.jacobian(m.home).T) / (2 * np.pi * f) ** 2
    found = m.flexible().frequency_response(m.home, [f])[0]
    assert_allclose(found, rigid, rtol=1e-4, atol=1e-4 * np.abs(rigid).max())  # (0.05 / 37)^2 = 2e-6 and the damping


def test_a_tool_pushed_in_a_held_machine_answers_with_its_static_compliance():
    """The wrench's response with encoders at motors that are as heavy as the earth."""
    m = gk.load_machine("nist-octahedral").replace(gravity=[0, 0, 0.0], **{"drive.inertia": 3e6}).frictionless()
    f = m.flexible()
    found = f.frequency_response(m.home, [0.5], source="tool")[0]
    # the motors of 3e11 kg follow by 1e-12 of it; at 0.5 Hz of 37 the answer is (0.5 / 37)^2 = 2e-4 larger
    assert_allclose(found.real, f.tool_compliance(m.home), rtol=1e-3, atol=1e-3 * np.abs(found).max())


@pytest.mark.full
@pytest.mark.parametrize("name", ["nist-octahedral", "ifma-hsm"])
def test_what_a_motor_does_to_the_tool_a_push_on_the_tool_does_to_the_encoder(name):
    """Reciprocity, M, D and K being symmetric: from motor i to the tool along j as from there to encoder i."""
    f = gk.load_machine(name).frictionless().flexible()
    at = [5.0, 50.0, 500.0]
    there, back = (f.frequency_response(f.home, at, *way) for way in (("motor", "tool"), ("tool", "encoder")))
    assert_allclose(there, np.swapaxes(back, -1, -2), rtol=0, atol=1e-9 * np.abs(there).max())


def test_held_modes_do_not_move_a_motor_and_free_ones_do(flexible):
    held, free = flexible.modes(flexible.home), flexible.modes(flexible.home, held=False)
    assert np.abs(held.shape[6:]).max() < 1e-12 and (np.abs(free.shape[6:, -1]) > 0.1).any()
    assert (np.diff(held.frequency) >= 0).all() and len(held.frequency) == 6
    assert_allclose(np.abs(held.shape).max(0), 1)


def test_the_map_is_symmetric_as_the_machine_is(nist):
    """Mirrored in the y-z plane strut 1 is strut 2: what gives way at (x, y) gives way at (-x, y)."""
    x = np.array([[0.1, 0.05, 0, 0, 0, 0], [-0.1, 0.05, 0, 0, 0, 0], [5.0, 0, 0, 0, 0, 0]])
    found = stiffness_map(nist.flexible(), x)
    for values in found.values():
        assert np.isnan(values[2]).all()  # nothing stands 5 m away
    assert_allclose(found["stiffness"][0], found["stiffness"][1], rtol=1e-6)
    assert_allclose(found["frequency"][0], found["frequency"][1], rtol=1e-6)
    assert_allclose(found["sag"][0], found["sag"][1] * [-1, 1, 1], atol=1e-10)
    assert found["least"][0] <= found["stiffness"][0].min()


# -- energy -----------------------------------------------------------------------------------------------------------


def energies(m, z0, v0, h, steps, every):
    """Kinetic and elastic energy along the tick's own sub-steps of h s, drives without force, from springs unbent."""
    p = m.at(ca.SX(ca.DM(m.theta)))
    pi = {key: value for key, (value, _) in m.inertial(p).items()}
    z, v = ca.SX.sym("z", m.coordinate_count), ca.SX.sym("v", len(m.velocities))
    sizes = {"z": z.numel(), "v": v.numel()}
    signals = [
        Signal("theta_plant", len(m.theta), "parameter"), Signal("wrench", 6, "parameter"),
        Signal("u", m.joints_count, "parameter"), Signal("memory", 0, "state"),
        *(Signal(name, size, "state") for name, size in sizes.items()),
        *(Signal(f"{name}{i}", size, "wire") for name, size in sizes.items() for i in (2, 3, 4)),
        *(Signal(f"{name}d{i}", size, "wire") for name, size in sizes.items() for i in (1, 2, 3, 4)),
    ]  # fmt: skip
    schedule = Schedule(tuple(signals), substep=tick._substep(m, h), substeps=every, log=("z", "v"))
    given = {"theta_plant": m.theta, "wrench": np.zeros(6), "u": np.zeros(m.joints_count)}
    states = {"z": z0, "v": v0, "memory": np.zeros(0)}
    rows = compile(schedule).start(parameters=given, states=states).advance(steps)[:, 0]
    M, _ = m.mass_and_bias(p, pi, z, v)
    shown = ca.Function("E", [z, v], [ca.dot(v, M @ v) / 2, m.elastic_energy(p, z)]).map(len(rows))
    T, U = (np.array(part).ravel() for part in shown(rows[:, : z.numel()].T, rows[:, z.numel() :].T))
    return T, U


@pytest.mark.full
def test_a_flexible_hexapod_let_go_without_damping_keeps_its_energy(nist):
    """Joints softer along one axis than along another: their compliance along a strut changes as it turns."""
    m = nist.frictionless().replace(gravity=[0, 0, 0.0], compliance=SOFT).flexible()
    v0 = np.r_[0.3, -0.2, 0.25, 0.4, -0.3, 0.5, 1.0, -1.0, 0.5, 0.8, -0.7, 0.3]
    T, U = energies(m, m.coordinates(nist.home), v0, 1e-4, 400, 10)
    E = T + U
    assert U.max() > 0.2 * E[0], "the springs must take a good part of it to prove anything"
    # RK4 at w h = 600 x 1e-4 = 0.06 loses (w h)^5 / 72 a radian, over 240 rad: 3e-6 of it at worst
    assert np.abs(E - E[0]).max() < 3e-6 * E[0]


@pytest.mark.full
def test_the_flexible_hybrid_machine_let_go_without_damping_keeps_its_energy():
    entry = {"joint": "slides", "stiffness": [8e6, 1.2e7, 8e6, 2.8e5, 2e5, 1.5e6]}
    m = gk.load_machine("ifma-hsm").replace(gravity=[0, 0, 0.0], compliance=[entry]).flexible()
    v0 = m.modes(m.home).shape.real[:, :4] @ [0.4, -0.3, 0.2, 0.3] + np.r_[0.1, 0.05, 0.1, np.zeros(9)]
    T, U = energies(m, m.coordinates(m.home), v0, 1e-4, 300, 10)
    E = T + U
    assert U.max() > 0.2 * E[0]
    assert np.abs(E - E[0]).max() < 3e-6 * E[0]  # w h = 720 x 1e-4, as above
