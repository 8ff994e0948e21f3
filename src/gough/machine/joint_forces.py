"""Machine with forces in its passive joints: reactions, and the friction that scales with them.

What a kind of machine must say is reactions.py's: struts, joints, inertial parameters.
"""

from __future__ import annotations

import casadi as ca
import numpy as np

from ..errors import WorkspaceError
from . import reactions
from .arrays import check_determinant
from .platform import PlatformMachine
from .strut_limits import OVERLAP


class JointForces(PlatformMachine):
    """A machine of struts whose joints know the forces that they carry."""

    def frictionless(self):
        return self.replace(friction=None, joints=self.joints.replace(friction=None))

    @property
    def guided(self) -> bool:
        """Whether the sheet says where the tubes of a strut bear on each other."""
        return self.strut is not None and self.strut.sleeve is not None

    @property
    def load_count(self) -> int:
        """How many forces in the joints friction asks for: a normal force, or two reactions, a strut, or all three."""
        return 6 * (bool(self.friction and self.friction.loaded) + 2 * (self.joints.friction is not None))

    def loads_of(self, p, z, v, vd, memory, u):
        """The forces in the joints that make friction, N, at the twist rate vd and the drive forces u.

        (load_count,): |N_a| + |N_b|, then |R_B| and |R_A|, of every strut.  Taken without the friction of the joints,
        which adds mu r / l of the reactions, some parts in ten thousand.
        """
        pi = {key: value for key, (value, _) in self.inertial(p).items()}
        found, out = reactions.reactions_of(self, p, pi, z, v, vd, u), []
        if self.friction and self.friction.loaded:
            out.append(found.normal)
        if self.joints.friction is not None:
            lost = self.strut_friction(p, self.jacobian_of(p, z) @ v, memory, ca.vertcat(*out))
            n = self.struts(p, z)[3]
            R_B = found.platform_joint + n * ca.repmat(lost.T, 3, 1)
            R_A = found.base_joint - n * ca.repmat(lost.T, 3, 1)
            out += [ca.vertcat(*[reactions.magnitude(R[:, i]) for i in range(6)]) for R in (R_B, R_A)]
        return ca.vertcat(*out)

    def loads_carried(self, p, pi, z, v, vd, net):
        """`loads_of` for struts that carry `net` (6,) N, whatever drive and friction made of it.  (load_count,)."""
        found, out = reactions.reactions_of(self, p, pi, z, v, vd, net), []
        if self.friction and self.friction.loaded:
            out.append(found.normal)
        if self.joints.friction is not None:
            ends = (found.platform_joint, found.base_joint)
            out += [ca.vertcat(*[reactions.magnitude(R[:, i]) for i in range(6)]) for R in ends]
        return ca.vertcat(*out)

    def friction_load(self, p, pi, z, v, vd):
        """|N_a| + |N_b| of every strut on a motion.  The drives do not matter: they push along the strut.  (6,) N."""
        if not (self.friction and self.friction.loaded):
            return None
        return reactions.reactions_of(self, p, pi, z, v, vd, ca.SX(6, 1)).normal

    def joint_friction(self, p, z, v, loads):
        """What the friction of the joints adds to J' (u - friction), on the twist.  (6,) [N; N m]."""
        if self.joints.friction is None:
            return ca.SX(6, 1)
        R_B, R_A = loads[-12:-6], loads[-6:]
        return reactions.joint_friction_of(self, p, z, v, R_B, R_A)

    @property
    def reaction_fields(self) -> tuple[str, ...]:
        """Which of `Reactions` the machine has."""
        return ("platform_joint", "base_joint") + (("mouth", "end", "normal") if self.guided else ())

    def reactions_of(self, p, z, v, vd, net, loads=None, w=None):
        """`reactions.reactions_of`, with the friction of the joints at `loads` where it has any."""
        pi = {key: value for key, (value, _) in self.inertial(p).items()}
        held = None if loads is None or self.joints.friction is None else (loads[-12:-6], loads[-6:])
        return reactions.reactions_of(self, p, pi, z, v, vd, net, held)

    def reactions(self, x, xd, xdd, wrench=None) -> reactions.Reactions:
        """Forces in the joints on a motion, without friction of the joints; friction of the struts changes none.

        `wrench` (..., 6) acts on the tool at its tip, in W.  x, xd, xdd: (..., 6) each; vectors (..., 6, 3) N in W,
        strut by strut, `normal` (..., 6) N; see `reactions.Reactions`.

        Raises
        ------
        SingularityError
            where det J has fallen below limits.determinant of home's.
        WorkspaceError
            where a tube has left its sleeve.
        """
        flat, ratio = self.arrays.run("reactions", *self._columns(x, xd, xdd), self._wrench(wrench))
        check_determinant(ratio, self.limits.determinant)
        if self.guided:
            self._check_overlap(x)
        return reactions.unpacked(flat, self.guided)

    def _check_overlap(self, x):
        longest = self.strut.sleeve + self.strut.tube - OVERLAP
        q = self.inverse_kinematics(x)
        bad = np.argwhere(~(q <= longest))
        if len(bad):
            *index, strut = (int(i) for i in bad[0])
            raise WorkspaceError(
                f"{self.joint_names[strut]}: the tube has left its sleeve", where=f"index {index}" if index else None,
                value=f"{q[tuple(bad[0])]:.6g} m", limit=f"{longest:.6g} m", cure="lengthen strut.sleeve or strut.tube",
            )  # fmt: skip
