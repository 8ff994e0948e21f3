r"""Hybrid machine with slides 1 and 6 elastic: six components between each motor and its link.

d_2 = [dx dy dz, rx ry rz] of link 2 from slide 1 and d_5 of link 5 from slide 6 stand in the chains of hybrid_chain.py,
composed exactly: first axis across the arm, second along it, third out of the plane.  Coordinates

    a = (s21 s65 s32, d_2, dx5 dy5 rz5),   b = (s54 phi10 phi60, dz5 rx5 ry5),   v = a'

With A_5 and the axes of link 5 seen from link 2, g = R_2' (A_5 - A_2) - s54 e_x and R = R_2' R_5, the loop closes in
space:

    phi = ( -g_y, -g_x, b (R_21 - R_12),  g_z, b (R_32 - R_23) / 2, b (R_13 - R_31) / 2 )                           (16)
    U = (d_2' K_2 d_2 + d_5' K_5 d_5) / 2                                                                          (17)
    M_a v' + h_a = J' u + w - G' [K_2 d_2 + D_2 d_2'; K_5 d_5 + D_5 d_5'],   J = [1 0],   [d_2'; d_5'] = G v        (18)

(R_21 is the entry in the second row, first column.)  The loop ties three of the twelve elastic coordinates, those of
link 5 out of the plane: it gives them whatever the pose, so that phi_b is the rigid machine's beside a block near
(1, b, b).  M_a, h_a without springs are of machine/constrained.py.  docs/theory/compliance.md, section 5.

Source: Bouzgarrou, Ray, Gogu, Thuilot 2001, section 2.2 and eq. (3).
"""

from __future__ import annotations

from typing import ClassVar

import casadi as ca
import numpy as np

from ..declare import Array, Part, quantity, si_numbers
from ..errors import ExperimentError
from ..mechanics import constrained
from .constrained import ConstrainedMachine, ToolMotion
from .flexible import FlexibleMachine, check_given, check_options, elastic_joints
from .hybrid_chain import chains

_RIGID = (0, 1, 2, 12, 13, 14)  # s21 s65 s32 s54 phi10 phi60 among the coordinates
_FIRST = tuple(range(3, 9))  # d_2
_SECOND = (9, 10, 15, 16, 17, 11)  # d_5
_NAMES = ("dx", "dy", "dz", "rx", "ry", "rz")


class SlideSprings(Part):
    """K and D of slides 1 and 6 as numbers of theta, SI, a row of 36 each; made by `flexible_hybrid`."""

    stiffness: Array = quantity("1", "K, by rows: N/m, N, N m/rad", shape=(2, 36))
    damping: Array | None = quantity("1", "D, by rows, likewise times s", default=None, shape=(2, 36))


def flexible_hybrid(machine, measured: str, stiffness: float) -> FlexibleHybrid:
    """The hybrid machine with elastic slides; see `Machine.flexible`."""
    check_given(machine)
    check_options(measured, stiffness)
    K, D = np.zeros((2, 2, 36))
    for _, number, entry, _ in elastic_joints(machine):
        found = entry.spring()
        K[number], D[number] = (stiffness * part.ravel() for part in found)
    if not K.any(1).all():
        raise ExperimentError(
            "both slides give way or none: the flexible machine has six components at each", key="compliance",
            value=f"none of slide {(1, 6)[int(np.argmin(K.any(1)))]}", cure='name joint = "slides"',
        )  # fmt: skip
    with si_numbers():
        springs = SlideSprings(stiffness=K, damping=D if D.any() else None)
        return FlexibleHybrid(stiff=machine, springs=springs, measured=measured)


class FlexibleHybrid(FlexibleMachine, ConstrainedMachine):
    """A hybrid machine `stiff` with springs at its slides."""

    dependent_names: ClassVar = ("s54", "phi10", "phi60", "dz5", "rx5", "ry5")
    velocities: ClassVar = (
        *("s21'", "s65'", "s32'"),
        *(f"{name}2'" for name in _NAMES),
        *(f"{name}5'" for name in ("dx", "dy", "rz")),
    )
    independent_count: ClassVar = 12
    coordinate_count: ClassVar = 18

    springs: SlideSprings

    # -- coordinates ----------------------------------------------------------------------------------------------

    @staticmethod
    def _pick(z, places):
        return ca.vertcat(*[z[i] for i in places])

    def _chains(self, p, z, zd):
        flex = tuple((self._pick(z, places), self._pick(zd, places)) for places in (_FIRST, _SECOND))
        return chains(p, self._pick(z, _RIGID), self._pick(zd, _RIGID), flex)

    def closure_of(self, p, z):
        """phi of eq. (16).  (6,) m."""
        at, b = self._chains(p, z, ca.SX.zeros(18)), p.base.half_width
        gap = at.link_2.R.T @ (at.link_5.p - at.passive.p)
        R = at.link_2.R.T @ at.link_5.R
        turns = (R[1, 0] - R[0, 1], (R[2, 1] - R[1, 2]) / 2, (R[0, 2] - R[2, 0]) / 2)
        return ca.vertcat(-gap[1], -gap[0], b * turns[0], gap[2], b * turns[1], b * turns[2])

    def tool_motion_of(self, p, z, zd):
        """T of hybrid.py, (4), where the springs let it be."""
        tool = self._chains(p, z, zd).tool
        return ToolMotion(tool.p, tool.R, tool.twist)

    def coordinates_of(self, p, x):
        """z of a tool tip with no spring bent."""
        z = self.stiff.coordinates_of(p.stiff, x)
        return ca.vertcat(z[:3], ca.SX.zeros(9), z[3:], ca.SX.zeros(3))

    def coordinates(self, x) -> np.ndarray:
        """z of tool tips with no spring bent.  (..., 3) -> (..., 18)."""
        z = self.stiff.coordinates(x)
        out = np.zeros((*z.shape[:-1], 18))
        out[..., _RIGID] = z
        return out

    def measured_of(self, p, z):
        """What the encoders are on: the motors, or the links behind the springs, along the arms.  (3,)."""
        if self.measured == "motor":
            return z[:3]
        return z[:3] + ca.vertcat(z[_FIRST[1]], z[_SECOND[1]], 0)

    def home_rotation(self, p):
        return self.stiff.home_rotation(p.stiff)

    def determinant_of(self, p, z):
        return self.stiff.determinant_of(p.stiff, self._pick(z, _RIGID))

    def margins(self, p, z):
        """Those of the rigid machine, at its coordinates among these."""
        return self.stiff.margins(p.stiff, self._pick(z, _RIGID))

    def limit_told(self, index, margin):
        return self.stiff.limit_told(index, margin)

    # -- dynamics -------------------------------------------------------------------------------------------------

    def inertial(self, p):
        """The parameters of the rigid machine."""
        return self.stiff.inertial(p.stiff)

    def bodies_of(self, p, pi, z, zd):
        """Those of the rigid machine, links and ram moving in space."""
        return self.stiff.bodies_at(pi, self._chains(p, z, zd))

    def joint_mass(self, pi):
        """Nothing turns with a linear motor."""
        return self.stiff.joint_mass(pi)

    def mass_and_bias(self, p, pi, z, v):
        """M (12, 12) and h (12,) of M v' + h, springs and dampers in h.

        By the mass matrix on all 18 coordinates, where it is sparse, and then T' M T: a third of the operations of
        bodies moved by v.
        """
        n = self.independent_count
        M, h, _ = self._eliminated(self.moved(p, pi, z, v), p.gravity)
        G = self._elastic_rates(constrained.dependent(self.closed(p, z)))
        springs = zip(self._tables(p), (_FIRST, _SECOND), (G[:6, :], G[6:, :]), strict=True)
        for (K, D), places, rows in springs:
            force = K @ self._pick(z, places)
            h += rows.T @ (force if D is None else force + D @ (rows @ v))
        assert M.shape == (n, n)
        return M, h

    def _eliminated(self, moved, gravity):
        """M and h of v without springs, and B."""
        n, B = self.independent_count, moved.B
        bd = constrained.dependent_acceleration(moved.closure, B, ca.SX(n, 1))
        M, q = ca.SX(18, 18), ca.SX(18, 1)
        for body, _, drift, whole in moved.bodies:
            M += whole.T @ constrained.spatial_inertia(body) @ whole
            q += whole.T @ constrained.needed(body, body.twist, drift - whole[:, n:] @ bd, gravity)
        M_aa, M_ab, M_bb = M[:n, :n], M[:n, n:], M[n:, n:]
        mixed = M_ab + B.T @ M_bb
        cross = M_ab @ B
        return M_aa + cross + cross.T + B.T @ (M_bb @ B), q[:n] + B.T @ q[n:] + mixed @ bd, B

    def inverse_force(self, p, pi, z, v, vd):
        """M v' + h, on v."""
        M, h = self.mass_and_bias(p, pi, z, v)
        return M @ vd + h

    def _tables(self, p):
        """(K, D) of slides 1 and 6; D None without damping."""
        for i in range(2):
            K = ca.reshape(p.springs.stiffness[i, :], 6, 6).T
            yield K, None if self.springs.damping is None else ca.reshape(p.springs.damping[i, :], 6, 6).T

    @staticmethod
    def _elastic_rates(B):
        """G of eq. (18), sparse.  (12, 12)."""
        T = ca.vertcat(ca.SX.eye(12), B)
        return ca.vertcat(*[T[i, :] for i in (*_FIRST, *_SECOND)])

    def elastic_energy(self, p, z):
        """U of eq. (17), J."""
        total = 0
        for (K, _), places in zip(self._tables(p), (_FIRST, _SECOND), strict=True):
            d = self._pick(z, places)
            total += ca.dot(d, K @ d) / 2
        return total
