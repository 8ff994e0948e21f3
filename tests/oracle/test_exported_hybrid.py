"""The exported hybrid machine and axis in MuJoCo and Pinocchio: pose, mass, bias, at rest and in motion.

The engines' trees are brought onto the tool by their own constraint Jacobians: G y of the loop's null space with the
tool's Jacobian, x' = J G x'.
"""

from __future__ import annotations

import re

import numpy as np
import pytest

import gough as gk
from gough.export.mjcf import mjcf, positions
from gough.machine.drives import Screw
from gough.machine.workspace import random_poses

STATES = 20
SAME = 1e-9  # of the largest entry; condition of the two points across the slide, some hundreds, times rounding
DIFFERENCE = 1e-6  # relative step of G's rate by central differences: 1e-12 by curvature, 1e-9 by rounding of G


def machines():
    hybrid, axis = (gk.load_machine(name).replace(friction=None) for name in ("ifma-hsm", "emps"))
    mirrored = hybrid.replace(
        **{"base.half_width": -hybrid.base.half_width, "limits.passive": -hybrid.limits.passive[::-1]}
    )
    leaning = axis.replace(**{"rail.direction": [0.6, 0.0, 0.8]})
    screw = leaning.replace(drive=Screw(lead=0.01, inertia=2e-4))
    return {"ifma-hsm": hybrid, "mirrored": mirrored, "emps": axis, "leaning": leaning, "screw": screw}


@pytest.fixture(params=sorted(machines()))
def machine(request):
    return machines()[request.param]


def places(machine):
    rng = np.random.default_rng(3)
    if len(machine.task) == 1:
        x = rng.uniform(*machine.limits.travel, (STATES, 1))
    else:
        x = random_poses(machine, STATES, rng)
    return x, rng.normal(size=x.shape) * 0.4


class MuJoCo:
    def __init__(self, machine, _folder):
        self.lib = pytest.importorskip("mujoco")
        self.model = self.lib.MjModel.from_xml_string(mjcf(machine))
        self.data, self.machine = self.lib.MjData(self.model), machine

    def set(self, x, v=None):
        self.data.qpos[:] = positions(self.machine, x)
        self.data.qvel[:] = 0 if v is None else v
        self.lib.mj_forward(self.model, self.data)

    def jacobians(self):
        """Of the tool's place (3, nv), and of the loops."""
        J, turn = np.zeros((2, 3, self.model.nv))
        self.lib.mj_jacSite(self.model, self.data, J, turn, self.model.site("tool").id)
        return J, self.data.efc_J.reshape(-1, self.model.nv)[: self.data.ne]

    def dynamics(self):
        M = np.zeros((self.model.nv, self.model.nv))
        self.lib.mj_fullM(self.model, self.data, M)
        return M, np.array(self.data.qfrc_bias)

    def tool(self):
        return np.array(self.data.site("tool").xpos)

    def gap(self):
        ends = [("link 5 a", "link 2 a"), ("link 5 b", "link 2 b")] if self.model.neq else []
        return max((np.abs(self.data.site(a).xpos - self.data.site(b).xpos).max() for a, b in ends), default=0.0)


class Pinocchio:
    def __init__(self, machine, folder):
        self.lib = pytest.importorskip("pinocchio")
        path = folder / "machine.xml"
        path.write_text(mjcf(machine))
        self.model, self.loops, _ = self.lib.buildModelAndConstraintsFromMJCF(str(path))
        gravity = re.search(r'gravity="(.*?)"', path.read_text())[1].split()
        self.model.gravity.linear = np.array(gravity, float)  # its reader keeps -9.81 along z
        self.data, self.machine = self.model.createData(), machine

    def set(self, x, v=None):
        self.q, self.v = positions(self.machine, x), np.zeros(self.model.nv) if v is None else v
        self.lib.computeJointJacobians(self.model, self.data, self.q)
        self.lib.updateFramePlacements(self.model, self.data)

    def _at(self, joint, placement):
        """Place (3,) and Jacobian (3, nv) in W of a point on a joint."""
        M = self.data.oMi[joint] * placement
        J = self.lib.getJointJacobian(self.model, self.data, joint, self.lib.ReferenceFrame.LOCAL_WORLD_ALIGNED)
        J = np.reshape(J, (6, self.model.nv))  # a vector where there is one velocity
        arm = M.translation - self.data.oMi[joint].translation
        return M.translation, J[:3] - self.lib.skew(arm) @ J[3:]

    def jacobians(self):
        frame = self.model.frames[self.model.getFrameId("tool")]
        J = self._at(frame.parentJoint, frame.placement)[1]
        rows = [
            self._at(one.joint1_id, one.joint1_placement)[1] - self._at(one.joint2_id, one.joint2_placement)[1]
            for one in self.loops
        ]
        return J, np.concatenate([np.zeros((0, self.model.nv)), *rows])

    def dynamics(self):
        M = np.array(self.lib.crba(self.model, self.data, self.q))
        M = np.triu(M) + np.triu(M, 1).T
        return M, np.array(self.lib.nonLinearEffects(self.model, self.data, self.q, self.v))

    def tool(self):
        return np.array(self.data.oMf[self.model.getFrameId("tool")].translation)

    def gap(self):
        ends = [(one.joint1_id, one.joint1_placement, one.joint2_id, one.joint2_placement) for one in self.loops]
        return max((np.abs(self._at(a, b)[0] - self._at(c, d)[0]).max() for a, b, c, d in ends), default=0.0)


@pytest.fixture(params=[MuJoCo, Pinocchio], ids=["mujoco", "pinocchio"])
def engine(request, machine, tmp_path):
    return request.param(machine, tmp_path)


def spread(engine, machine, x):
    """G (nv, d): the tree's velocities of a velocity of the task, the loops closed."""
    engine.set(x)
    J, loops = engine.jacobians()
    if len(machine.task) == 1:
        J = (machine.rail.direction @ J)[None]
    _, s, V = np.linalg.svd(loops) if len(loops) else (0, np.zeros(0), np.eye(J.shape[1]))
    N = V[int((s > 1e-9 * (s.max() if len(s) else 1)).sum()) :].T
    assert N.shape[1] == len(machine.task)  # the loops leave the freedoms of the machine
    return N @ np.linalg.inv(J @ N)


def worst(found, right) -> float:
    return float(np.abs(found - right).max() / max(np.abs(right).max(), 1e-12))


def test_the_tool_is_where_gough_says_and_the_loop_is_closed(machine, engine):
    for x in places(machine)[0]:
        engine.set(x)
        np.testing.assert_allclose(engine.tool(), machine.tool_pose(x)[:3], rtol=0, atol=1e-13)
        assert engine.gap() < 1e-13


def test_mass_and_bias_are_the_engines(machine, engine):
    x, xd = places(machine)
    mass, bias = machine.arrays.run("mass", x, xd)[:2]
    d = len(machine.task)
    for k in range(STATES):
        G = spread(engine, machine, x[k])
        step = DIFFERENCE * xd[k]
        rate = (spread(engine, machine, x[k] + step) - spread(engine, machine, x[k] - step)) / (2 * DIFFERENCE)
        engine.set(x[k], G @ xd[k])
        M, h = engine.dynamics()
        assert worst(G.T @ M @ G, mass[k].reshape(d, d)) < SAME
        assert np.abs(G.T @ (h + M @ rate @ xd[k]) - bias[k]).max() < 1e-7 * max(1.0, np.abs(h).max())


def test_at_the_key_frame_home_the_drives_hold_the_machine(machine):
    engine = MuJoCo(machine, None)
    np.testing.assert_allclose(engine.model.key_qpos[0], engine.model.qpos0, rtol=0, atol=2e-15)
    G = spread(engine, machine, machine.home)
    engine.data.ctrl[:] = engine.model.key_ctrl[0]
    engine.set(machine.home)
    force = engine.data.qfrc_actuator - engine.data.qfrc_bias
    weight = np.abs(engine.data.qfrc_bias).max()
    assert np.abs(G.T @ force).max() < 1e-11 * max(1.0, weight)
