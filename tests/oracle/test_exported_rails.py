"""Exported hexaglides, 3-PRS heads and turned homes in MuJoCo and Pinocchio: pose, mass, bias, accelerations."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import pytest

from gough.frames import rotation_of_abc_np
from gough.machine.sheet import load_machine
from gough.machine.workspace import random_poses

from .engines import MuJoCo, Pinocchio, random_states
from .exported import without_friction, worst
from .hexaglides import HEXAGLIDES, general
from .test_maximal import oblique
from .tree import CARRIAGES, SLIDERS, SLIDES, forces, on_the_twist, spread, twist_rate

TRIPODS = {"ccu-3prs": lambda: load_machine("ccu-3prs"), "oblique": oblique}
MACHINES = {
    **TRIPODS,
    **{name: lambda make=make: make().replace(friction=None) for name, make in HEXAGLIDES.items()},
    "turned-hexaglide": lambda: general().replace(name="turned", friction=None, home=TURNED),
    "turned-hexapod": lambda: without_friction(load_machine("okuma-pm600")).replace(name="turned", home=LEANING),
}
TURNED, LEANING = [0.05, -0.03, 0.02, 0.1, -0.08, 0.05], [0.05, -0.03, -1.0, 0.1, -0.08, 0.05]
SLIDE_OF = {"hexapod": (SLIDES, "strut"), "hexaglide": (CARRIAGES, "carriage"), "tripod": (SLIDERS, "slider")}
STATES = 60
# as tests/oracle/test_mujoco.py; the least inertias that MuJoCo takes, 1e-12 of 1 kg m2, are below it
SAME = 1e-8

_made = lru_cache(lambda name: MACHINES[name]())


QUICK = ("oblique", "general-hexaglide", "turned-hexapod")  # the others have fewer terms


@pytest.fixture(params=[name if name in QUICK else pytest.param(name, marks=pytest.mark.full) for name in MACHINES])
def machine(request):
    return _made(request.param)


@pytest.fixture(params=["mujoco", "pinocchio"])
def engine(request, machine, tmp_path):
    pytest.importorskip(request.param, reason=f"{request.param} is a dev dependency: pip install gough[dev]")
    return MuJoCo(machine) if request.param == "mujoco" else Pinocchio(machine, tmp_path)


def states(machine):
    """x, task rates V, forces of the drives, wrenches on the tool."""
    if len(machine.task) == 6:
        return random_states(machine, STATES, seed=6)
    rng, library = np.random.default_rng(6), load_machine("ccu-3prs")
    x = machine.home + 0.5 * (random_poses(library, STATES, rng) - library.home)
    w = rng.normal(size=(STATES, 6)) * [500, 500, 500, 50, 50, 50]
    return x, rng.normal(size=(STATES, 3)) * 0.4, rng.normal(size=(STATES, 3)) * 800, w


@pytest.mark.quick("general-hexaglide-*", "*-pinocchio")
def test_mass_bias_and_accelerations_are_the_engines(machine, engine):
    x, V, u, w = states(machine)
    R = rotation_of_abc_np(machine.tool_pose(x)[:, 3:])
    M, h = machine.arrays.run("mass", x, V)[:2]
    rate, slides = machine.forward_dynamics(x, V, u, w), SLIDE_OF[machine.kind][0]
    for k, tree in enumerate(engine.trees(x, V)):
        if isinstance(engine, MuJoCo):
            assert engine.gap() < 2e-14  # m, rounding of 2 m: every loop is closed
        M_there, h_there = on_the_twist(tree, R[k])
        assert worst(M_there, M[k].reshape(M_there.shape)) < SAME and worst(h_there, h[k]) < SAME
        found = twist_rate(tree, R[k], forces(R[k], u[k], w[k], slides))
        assert worst(found[: len(machine.task)], rate[k]) < SAME


def test_the_tool_is_where_gough_says_and_the_slides_read_the_joints(machine):
    pytest.importorskip("mujoco")
    engine, (x, V, *_) = MuJoCo(machine), states(machine)
    pose, q = machine.tool_pose(x), machine.inverse_kinematics(x)
    R, name = rotation_of_abc_np(pose[:, 3:]), SLIDE_OF[machine.kind][1]
    for k, _ in enumerate(engine.trees(x, V)):
        np.testing.assert_allclose(engine.data.site("tool").xpos, pose[k, :3], rtol=0, atol=1e-14)
        np.testing.assert_allclose(engine.data.site("tool").xmat.reshape(3, 3), R[k], rtol=0, atol=1e-14)
        read = [engine.data.joint(f"{name} {i + 1}").qpos[0] for i in range(len(q[k]))]
        np.testing.assert_allclose(read, q[k], rtol=0, atol=1e-14)


def test_at_the_key_frame_home_the_drives_hold_the_machine(machine):
    pytest.importorskip("mujoco")
    engine, d = MuJoCo(machine), len(machine.task)
    np.testing.assert_allclose(engine.model.key_qpos[0], engine.model.qpos0, rtol=0, atol=2e-15)
    R = rotation_of_abc_np(machine.tool_pose(machine.home)[3:])
    (tree,) = engine.trees(machine.home[None], np.zeros((1, d)))
    held = twist_rate(tree, R, forces(R, engine.model.key_ctrl[0], np.zeros(6), SLIDE_OF[machine.kind][0]))
    assert np.abs(held).max() < 1e-11  # rounding of 9.81, times the condition of the loops


def test_pinocchios_own_constrained_dynamics_move_the_tool_as_gough_does(machine, tmp_path):
    """constraintDynamics: its factorisation of the tree with its loops, nothing of it ours."""
    pytest.importorskip("pinocchio")
    engine, (x, V, u, w) = Pinocchio(machine, tmp_path), states(machine)
    d, R, q = len(machine.task), rotation_of_abc_np(machine.tool_pose(x)[:, 3:]), engine.positions(x)
    rate, slides = machine.forward_dynamics(x, V, u, w), SLIDE_OF[machine.kind][0]
    for k, tree in enumerate(engine.trees(x, V)):
        ydd = engine.accelerations(q[k], spread(tree.G, R[k]) @ V[k], forces(R[k], u[k], w[k], slides))
        assert worst(np.concatenate([ydd[:3], R[k] @ ydd[3:6]])[:d], rate[k]) < SAME


@pytest.mark.parametrize("name", ["ccu-3prs", "eth-hexaglide"])
def test_with_stiff_loops_mujoco_holds_the_tool_at_rest(name):
    """Its own step and its own constraints, sliders held by springs: 20 ms later the tool has not moved by 10 nm."""
    mujoco = pytest.importorskip("mujoco")
    from gough.export.mjcf import mjcf

    machine = _made(name)
    model = mujoco.MjModel.from_xml_string(mjcf(machine, "stiff"))
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    slides = [model.joint(f"{SLIDE_OF[machine.kind][1]} {i + 1}").id for i in range(machine.joints_count)]
    place, speed = model.jnt_qposadr[slides], model.jnt_dofadr[slides]
    q_r, rest = data.qpos[place].copy(), model.key_ctrl[0].copy()
    for _ in range(80):
        data.ctrl[:] = rest + 4e6 * (q_r - data.qpos[place]) - 2e4 * data.qvel[speed]
        mujoco.mj_step(model, data)
    assert np.linalg.norm(data.site("tool").xpos - machine.home[:3]) < 1e-8


def test_the_forces_that_mujoco_closes_the_loops_with_are_the_reactions_out_of_goughs_multipliers():
    """MuJoCo's own solver, `efc_force`, nothing of it ours.

    It gives 0.9999 of the exact constraint force (`STIFF_SHARE`): 1e-4 is missing, and the rest follows in kind.
    """
    mujoco = pytest.importorskip("mujoco")
    from gough.export.mjcf import mjcf, positions

    machine = _made("ccu-3prs")
    model = mujoco.MjModel.from_xml_string(mjcf(machine, "stiff"))
    data = mujoco.MjData(model)
    x, xd, u = (a[:20] for a in states(machine)[:3])
    wanted = machine.reactions(x, xd, machine.forward_dynamics(x, xd, u)).platform_joint
    for k, q in enumerate(positions(machine, x)):
        data.qpos[:], data.qvel[:], data.ctrl[:] = q, 0, u[k]
        mujoco.mj_forward(model, data)
        G = data.efc_J.reshape(-1, model.nv)[:9]
        data.qvel[:3], data.qvel[3:] = xd[k], np.linalg.solve(G[:, 3:], -G[:, :3] @ xd[k])
        mujoco.mj_forward(model, data)
        found = data.efc_force[:9].reshape(3, 3)
        assert np.abs(found - wanted[k]).max() < 3e-4 * np.abs(wanted[k]).max()
