"""MuJoCo on the exported file: the same mass matrix, bias, weight and accelerations, by its own algorithms."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import pytest

from gough.export.mjcf import mjcf, positions
from gough.frames import rotation_of_abc_np

from . import closed_loop
from .engines import MuJoCo, random_states
from .exported import EXPORTED, worst
from .tree import forces, on_the_twist, twist_rate

mujoco = pytest.importorskip("mujoco", reason="MuJoCo is a dev dependency: pip install gough[dev]")

_made = lru_cache(lambda name: EXPORTED[name]())
STATES = 1000
# the figure of issue 4; measured 3e-14 and below on all three machines
SAME = 1e-8


@pytest.fixture(params=EXPORTED)
def machine(request):
    return _made(request.param)


@pytest.mark.quick("everything")
def test_mass_bias_weight_and_forward_dynamics_are_mujocos_at_1000_random_states(machine):
    engine = MuJoCo(machine)
    x, V, u, w = random_states(machine, STATES, seed=1)
    R = rotation_of_abc_np(x[:, 3:])
    M, h = machine.mass_matrix(x), machine.arrays.run("mass", x, V)[1]
    weight = machine.arrays.run("mass", x, np.zeros(6))[1]
    Vd = machine.forward_dynamics(x, V, u, w)
    for k, tree in enumerate(engine.trees(x, V)):
        assert engine.gap() < 1e-14  # m, rounding: the closed form of `positions` closes every loop
        M_mj, h_mj = on_the_twist(tree, R[k])
        assert worst(M_mj, M[k]) < SAME and worst(h_mj, h[k]) < SAME
        assert worst(twist_rate(tree, R[k], forces(R[k], u[k], w[k])), Vd[k]) < SAME
    for k, tree in enumerate(engine.trees(x[:100], np.zeros((100, 6)))):
        assert worst(on_the_twist(tree, R[k])[1], weight[k]) < SAME


def test_the_strut_coordinate_of_the_file_is_the_length_of_the_strut(machine):
    engine = MuJoCo(machine)
    poses = random_states(machine, 20, seed=2)[0]
    R = rotation_of_abc_np(poses[:, 3:])
    for k, (pose, _) in enumerate(zip(poses, engine.trees(poses, np.zeros((20, 6))), strict=True)):
        lengths = [engine.data.joint(f"strut {i}").qpos[0] for i in range(1, 7)]
        np.testing.assert_allclose(lengths, machine.inverse_kinematics(pose), rtol=0, atol=1e-14)
        np.testing.assert_allclose(engine.data.site("tool").xpos, pose[:3], rtol=0, atol=1e-14)
        np.testing.assert_allclose(engine.data.site("tool").xmat.reshape(3, 3), R[k], rtol=0, atol=1e-14)


def test_the_key_frame_home_is_home_and_its_forces_hold_the_machine_there(machine):
    engine = MuJoCo(machine)
    key = engine.model.key_qpos[0]
    np.testing.assert_allclose(key, positions(machine, machine.home), rtol=0, atol=1e-14)
    np.testing.assert_allclose(key, engine.model.qpos0, rtol=0, atol=1e-15)  # so the viewer opens it standing right
    (tree,), R = engine.trees(machine.home[None], np.zeros((1, 6))), rotation_of_abc_np(machine.home[3:])
    held = twist_rate(tree, R, forces(R, engine.model.key_ctrl[0], np.zeros(6)))
    assert np.abs(held).max() < 1e-12  # m/s2, rounding of 9.81


def hold_at_rest(machine, loops: str, samples: int):
    """Tip against gough's pose at rest, m: MuJoCo's own step, u = u_rest + Kp (l_r - l) - Kd l' at 1 kHz."""
    model = mujoco.MjModel.from_xml_string(mjcf(machine, loops))
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    l_r, u_rest = data.qpos[9::3].copy(), model.key_ctrl[0].copy()
    for _ in range(samples):
        data.ctrl[:] = u_rest + 4e6 * (l_r - data.qpos[9::3]) - 5.6e4 * data.qvel[8::3]
        mujoco.mj_step(model, data, round(1e-3 / model.opt.timestep))
    return float(np.linalg.norm(data.site("tool").xpos - machine.home[:3]))


def test_under_mujocos_default_loops_the_platform_hangs_a_millimetre_low_and_under_stiff_ones_it_does_not():
    """At rest under its weight, struts held at their lengths: the loops open, and the tool hangs 0.78 mm low.

    0.777 mm is MuJoCo 4.0.0's; the band leaves room for another version, not for another constraint model.
    """
    machine = _made("nist-octahedral")
    assert hold_at_rest(machine, "default", 600) == pytest.approx(0.777e-3, rel=0.05)
    assert hold_at_rest(machine, "stiff", 20) < 1e-8


@pytest.mark.full
def test_the_closed_loop_is_mujocos_within_what_halving_its_step_changes():
    """Stiff loops give way with the square of the step; what is left of that is all that parts the two."""
    m = closed_loop.machine()
    ours = closed_loop.gough(m, substeps=4)
    coarse, middle, fine = (closed_loop.mujoco(m, "stiff", h) for h in (1e-3, 0.5e-3, 0.25e-3))
    order = closed_loop.apart(coarse, middle) / closed_loop.apart(middle, fine)
    assert 3 < order < 5  # second order
    # of second order: the error of the finer is a third of the change; half as much again for higher orders
    assert closed_loop.apart(ours, fine) < 1.5 / 3 * closed_loop.apart(middle, fine)
    assert closed_loop.apart(ours, coarse) < 0.1e-6  # m, so 1 ms competes in bench/peers.py


def test_the_closed_loop_under_mujocos_default_loops_is_millimetres_off_at_every_step():
    m = closed_loop.machine()
    ours = closed_loop.gough(m, substeps=4)
    off = [closed_loop.apart(ours, closed_loop.mujoco(m, "default", h)) for h in (1e-3, 0.25e-3)]
    assert min(off) > 1e-3 and off[1] == pytest.approx(off[0], rel=0.05)  # the step is not what parts them
