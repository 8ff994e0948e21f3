"""MuJoCo's mass matrix, bias and Jacobians of a hybrid machine, its loop closed here: accelerations, passive slide."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from gough.machine.sheet import load_machine
from gough.machine.workspace import random_poses

from .hybrid_mjcf import hybrid_mjcf
from .test_hybrid import skewed

mujoco = pytest.importorskip("mujoco", reason="MuJoCo is a dev dependency: pip install gough[dev]")

NV, COUNT = 6, 200
PHI10, S21, S32, S54, PHI60, S65 = range(NV)  # the order of the tree
OURS = [S21, S65, S32, S54, PHI10, PHI60]


class Engine:
    """The tree of one machine."""

    def __init__(self, machine):
        self.model = mujoco.MjModel.from_xml_string(hybrid_mjcf(machine))
        self.data = mujoco.MjData(self.model)
        self.tip, self.seat, self.end = (self.model.site(name).id for name in ("tip", "seat", "end"))

    def _site(self, call, site):
        """(6, NV): of the place and the turning of a site, or their rates."""
        place, turn, data = np.zeros((3, NV)), np.zeros((3, NV)), self.data
        if call == "jac":
            mujoco.mj_jacSite(self.model, data, place, turn, site)
        else:
            mujoco.mj_jacDot(self.model, data, place, turn, data.site_xpos[site], self.model.site_bodyid[site])
        return np.concatenate([place, turn])

    def _gap(self, call):
        """Of link 5 against the end of the passive slide, in the plane: x, y, turn.  (3, NV)."""
        return (self._site(call, self.end) - self._site(call, self.seat))[[0, 1, 5]]

    def solve(self, z, sd, u, w):
        """The tip's place, speed and acceleration, and the force (x, y) and moment of link 2 on link 5."""
        data = self.data
        data.qpos[OURS], data.qvel[:] = z, 0
        mujoco.mj_forward(self.model, data)
        away = data.site_xpos[self.end] - data.site_xpos[self.seat]
        assert np.abs(away).max() < 1e-14  # rounding: a state of ours closes MuJoCo's loop
        G, rest = self._gap("jac"), [S54, PHI10, PHI60]
        data.qvel[[S21, S65, S32]] = sd
        data.qvel[rest] = np.linalg.solve(G[:, rest], -G[:, [S21, S65, S32]] @ sd)
        mujoco.mj_forward(self.model, data)
        G, Gd, J = self._gap("jac"), self._gap("dot"), self._site("jac", self.tip)
        M = np.zeros((NV, NV))
        mujoco.mj_fullM(self.model, data, M)
        Q = J.T @ w
        Q[[S21, S65, S32]] += u
        whole = np.block([[M, -G.T], [G, np.zeros((3, 3))]])
        found = np.linalg.solve(whole, np.concatenate([Q - data.qfrc_bias, -Gd @ data.qvel]))
        acceleration = J @ found[:NV] + self._site("dot", self.tip) @ data.qvel
        return data.site_xpos[self.tip].copy(), (J @ data.qvel)[:3], acceleration[:3], found[NV:]


@pytest.mark.parametrize("machine", [load_machine("ifma-hsm"), skewed()], ids=lambda m: m.name)
def test_accelerations_and_the_forces_of_the_passive_slide_are_mujocos_at_200_random_states(machine):
    rng = np.random.default_rng(3)
    x = random_poses(machine, COUNT, rng)
    sd, u = rng.normal(size=(COUNT, 3)) * 1.5, rng.normal(size=(COUNT, 3)) * 8000
    w = rng.normal(size=(COUNT, 6)) * [2000, 2000, 2000, 500, 500, 500]
    engine = Engine(machine)
    rows = [engine.solve(*row) for row in zip(machine.coordinates(x), sd, u, w, strict=True)]
    place, xd, xdd, passive = (np.array(part) for part in zip(*rows, strict=True))
    assert_allclose(place, x, rtol=0, atol=1e-14)
    found = machine.forward_dynamics(x, xd, u, w)
    # 1e-9: the passive slide's 1e-9 kg are MuJoCo's least, ours is none
    assert_allclose(found, xdd, rtol=0, atol=1e-9 * np.abs(xdd).max())
    reactions = machine.reactions(x, xd, found, w)
    assert_allclose(reactions.passive, passive, rtol=0, atol=1e-9 * np.abs(passive).max())
