"""MuJoCo and Pinocchio on an exported machine: each gives the Tree of a state, by its own algorithms."""

from __future__ import annotations

import re

import numpy as np

from gough.export.mjcf import mjcf, positions
from gough.frames import rotation_of_abc_np

from .tree import Tree, spread


def random_states(machine, count: int, seed: int):
    """Poses of the workspace, twists to 1 m/s and 1.5 rad/s and more, strut forces, wrenches.  (count, 6) each."""
    from gough.machine.workspace import random_poses

    rng = np.random.default_rng(seed)
    x = random_poses(machine, count, rng)
    V = rng.normal(size=(count, 6)) * [1, 1, 1, 1.5, 1.5, 1.5]
    return x, V, rng.normal(size=(count, 6)) * 1000, rng.normal(size=(count, 6)) * [1000, 1000, 1000, 100, 100, 100]


class MuJoCo:
    """MuJoCo's composite rigid body algorithm and recursive Newton-Euler, with its own Jacobians of sites."""

    def __init__(self, machine):
        import mujoco

        self.mujoco, self.machine = mujoco, machine
        self.model = mujoco.MjModel.from_xml_string(mjcf(machine))
        self.model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONSTRAINT)  # G is taken from the sites
        self.data = mujoco.MjData(self.model)
        self.ends = list(zip(self.model.eq_obj1id, self.model.eq_obj2id, strict=True))

    def trees(self, x, V):
        """The tree of every x (n, d), moving with the velocities V (n, d): twists, or velocities of a 3-PRS's tip."""
        poses = self.machine.tool_pose(x)
        for q, R_WT, twist in zip(positions(self.machine, x), rotation_of_abc_np(poses[:, 3:]), V, strict=True):
            yield self._tree(q, R_WT, twist)

    def _tree(self, q, R_WT, V) -> Tree:
        mujoco, model, data = self.mujoco, self.model, self.data
        data.qpos[:], data.qvel[:] = q, 0
        mujoco.mj_forward(model, data)
        G = np.concatenate([self._jacobian(a) - self._jacobian(b) for a, b in self.ends])
        data.qvel[:] = spread(G, R_WT) @ V
        mujoco.mj_forward(model, data)
        M = np.zeros((model.nv, model.nv))
        mujoco.mj_fullM(model, data, M)
        drift = np.concatenate([self._drift(a) - self._drift(b) for a, b in self.ends])
        return Tree(M, data.qfrc_bias.copy(), G, drift)

    def gap(self) -> float:
        """Largest distance of two points that a loop joins, m."""
        return max(np.linalg.norm(self.data.site_xpos[a] - self.data.site_xpos[b]) for a, b in self.ends)

    def _jacobian(self, site):
        out = np.zeros((3, self.model.nv))
        self.mujoco.mj_jacSite(self.model, self.data, out, None, site)
        return out

    def _drift(self, site):
        out = np.zeros((3, self.model.nv))
        point, body = self.data.site_xpos[site], self.model.site_bodyid[site]
        self.mujoco.mj_jacDot(self.model, self.data, out, None, point, body)
        return out @ self.data.qvel


class Pinocchio:
    """Pinocchio's own reading of the file: its joints, its constraints, its algorithms."""

    def __init__(self, machine, folder):
        import pinocchio as pin

        path = folder / f"{machine.name}.xml"
        path.write_text(mjcf(machine))
        self.pin, self.machine = pin, machine
        self.model, self.loops, _ = pin.buildModelAndConstraintsFromMJCF(str(path))
        # its reader keeps -9.81 along z whatever <option gravity> says
        self.model.gravity.linear = np.array(re.search(r'gravity="(.*?)"', path.read_text())[1].split(), float)
        place = pin.FrameType.OP_FRAME
        self.ends = [
            (
                self.model.addFrame(pin.Frame(f"end {i}", loop.joint1_id, loop.joint1_placement, place)),
                self.model.addFrame(pin.Frame(f"seat {i}", loop.joint2_id, loop.joint2_placement, place)),
            )
            for i, loop in enumerate(self.loops)
        ]
        self.data = self.model.createData()
        self.rigid, self.rigid_data = pin.StdVec_RigidConstraintModel(), pin.StdVec_RigidConstraintData()
        for loop in self.loops:
            one = pin.convertToRigidConstraintModel(self.model, loop)
            self.rigid.append(one)
            self.rigid_data.append(one.createData())
        pin.initConstraintDynamics(self.model, self.data, self.rigid, self.rigid_data)
        self.exact = pin.ProximalSettings(1e-14, 0.0, 1)

    def accelerations(self, q, v, tau):
        """y'' by Pinocchio's constraintDynamics: the whole tree with its loops.  (nv,)."""
        return self.pin.constraintDynamics(self.model, self.data, q, v, tau, self.rigid, self.rigid_data, self.exact)

    def positions(self, x):
        """Its q at task coordinates: as MuJoCo's, with the quaternion's w last."""
        q = positions(self.machine, x)
        q[..., 3:7] = q[..., [4, 5, 6, 3]]
        return q

    def trees(self, x, V):
        """The tree of every x (n, d), moving with the velocities V (n, d): twists, or velocities of a 3-PRS's tip."""
        poses = self.machine.tool_pose(x)
        for q, R_WT, twist in zip(self.positions(x), rotation_of_abc_np(poses[:, 3:]), V, strict=True):
            yield self._tree(q, R_WT, twist)

    def _tree(self, q, R_WT, V) -> Tree:
        pin, model, data = self.pin, self.model, self.data
        axes = pin.LOCAL_WORLD_ALIGNED
        pin.computeJointJacobians(model, data, q)
        pin.updateFramePlacements(model, data)
        G = np.concatenate(
            [(pin.getFrameJacobian(model, data, a, axes) - pin.getFrameJacobian(model, data, b, axes))[:3]
             for a, b in self.ends]
        )  # fmt: skip
        v = spread(G, R_WT) @ V
        M = pin.crba(model, data, q).copy()
        M = np.triu(M) + np.triu(M, 1).T
        c = pin.nonLinearEffects(model, data, q, v).copy()
        pin.forwardKinematics(model, data, q, v, np.zeros(model.nv))
        drift = np.concatenate(
            [(pin.getFrameClassicalAcceleration(model, data, a, axes)
              - pin.getFrameClassicalAcceleration(model, data, b, axes)).linear for a, b in self.ends]
        )  # fmt: skip
        return Tree(M, c, G, drift)
