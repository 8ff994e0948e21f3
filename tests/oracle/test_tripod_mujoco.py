"""MuJoCo's mass matrix, bias and Jacobians of a 3-PRS, its loops closed here: accelerations and joint forces."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from gough.frames import quaternion_of_rotation_np
from gough.machine.sheet import load_machine
from gough.machine.tripod_parts import stands
from gough.machine.workspace import random_poses

from .test_maximal import oblique
from .tripod_mjcf import tripod_mjcf

mujoco = pytest.importorskip("mujoco", reason="MuJoCo is a dev dependency: pip install gough[dev]")

NV = 12  # S1 theta1 S2 theta2 S3 theta3, v, R' w


class Engine:
    """The tree of one machine."""

    def __init__(self, machine):
        self.machine = machine
        self.model = mujoco.MjModel.from_xml_string(tripod_mjcf(machine))
        self.data = mujoco.MjData(self.model)
        self.ends = [(self.model.site(f"end {i}").id, self.model.site(f"seat {i}").id) for i in (1, 2, 3)]

    def _site(self, call, site):
        out, place = np.zeros((3, NV)), self.data.site_xpos[site]
        if call == "jac":
            mujoco.mj_jacSite(self.model, self.data, out, None, site)
        else:
            mujoco.mj_jacDot(self.model, self.data, out, None, place, self.model.site_bodyid[site])
        return out

    def solve(self, x, z, R, v, u, w):
        """Tip acceleration and the forces of the platform on the links."""
        data = self.data
        data.qpos[:6] = np.ravel(np.stack([z[:3], z[3:]], 1))
        data.qpos[6:9], data.qpos[9:] = x, quaternion_of_rotation_np(R)
        data.qvel[:] = 0
        mujoco.mj_forward(self.model, data)
        G = np.concatenate([self._site("jac", a) - self._site("jac", b) for a, b in self.ends])
        gap = np.concatenate([data.site_xpos[a] - data.site_xpos[b] for a, b in self.ends])
        assert np.abs(gap).max() < 1e-14  # rounding: a state of ours closes MuJoCo's loops
        others = [*range(6), 9, 10, 11]
        data.qvel[6:9] = v
        data.qvel[others] = np.linalg.solve(G[:, others], -G[:, 6:9] @ v)
        mujoco.mj_forward(self.model, data)
        G = np.concatenate([self._site("jac", a) - self._site("jac", b) for a, b in self.ends])
        Gd = np.concatenate([self._site("dot", a) - self._site("dot", b) for a, b in self.ends])
        M = np.zeros((NV, NV))
        mujoco.mj_fullM(self.model, data, M)
        Q = np.zeros(NV)
        Q[[0, 2, 4]], Q[6:9], Q[9:] = u, w[:3], R.T @ w[3:]
        whole = np.block([[M, G.T], [G, np.zeros((9, 9))]])
        found = np.linalg.solve(whole, np.concatenate([Q - data.qfrc_bias, -Gd @ data.qvel]))
        return found[6:9], -found[NV:].reshape(3, 3)


@pytest.mark.parametrize("machine", [load_machine("ccu-3prs"), oblique()], ids=lambda m: m.name)
def test_accelerations_and_forces_of_the_joints_are_mujocos_at_200_random_states(machine):
    rng, library = np.random.default_rng(3), load_machine("ccu-3prs")
    x = machine.home + 0.5 * (random_poses(library, 200, rng) - library.home)
    v, u = rng.normal(size=(200, 3)) * 0.4, rng.normal(size=(200, 3)) * 800
    w = rng.normal(size=(200, 6)) * [500, 500, 500, 50, 50, 50]
    engine, z, R = Engine(machine), machine.standing(x), stands(machine, x)[0]
    wanted = [engine.solve(*row) for row in zip(x, z, R, v, u, w, strict=True)]
    acceleration, force = (np.array(part) for part in zip(*wanted, strict=True))
    found = machine.forward_dynamics(x, v, u, w)
    # 1e-9: the links' axial inertia of 1e-14 and the sliders' 1e-12 are MuJoCo's least, ours is none
    assert_allclose(found, acceleration, rtol=0, atol=1e-9 * np.abs(acceleration).max())
    reaction = machine.reactions(x, v, found, w).platform_joint
    assert_allclose(reaction, force, rtol=0, atol=1e-9 * np.abs(force).max())
