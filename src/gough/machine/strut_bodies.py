"""The two bodies of a strut as rigid bodies: what each needs, and what both ask of the platform joint.

The moving part has its origin at B, the fixed part at A, both the axes S of strut_motion.py.  A body's motion needs a
force f and a moment t about its origin (`bodies.rigid_wrench`); by virtual work the platform must give at B

    F = f_m + A' (t_m + t_f) + n m_r l''                                                                          (1)

and with the cross of the base joint, of inertia J about a, on which it turns at a . w_s,

    F += A' a J (a . w_s')                                                                                        (2)

For slender parts (1) is eq. (5) of machine/hexapod.py, which `strut.py` writes out in fewer operations.  Derived in
docs/theory/hexapod.md, eqs. (7) and (8).
"""

from __future__ import annotations

import casadi as ca

from ..frames import skew
from ..mechanics.bodies import rigid_wrench
from .strut_motion import frame, spin

PAIRS = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
ENDS = {"moving": -1, "fixed": 1}  # the sense of `center` on the strut's axis, seen from the body's origin


def inertial(strut) -> dict:
    """The parameters of both bodies, {name: (SX, unit)}; `strut` is a Strut or its view."""
    out = {}
    for part, sign in ENDS.items():
        body, key = getattr(strut, part), f"strut.{part}"
        out[f"{key}.m"] = (body.mass, "kg")
        out[f"{key}.m c"] = (body.mass * body.center, "kg m")
        if not body.general:
            out[f"{key}.I"] = (body.transverse + body.mass * body.center**2, "kg m2")
            if body.axial is not None:
                out[f"{key}.Iaxial"] = (body.axial, "kg m2")
            continue
        cx, cy = (0, 0) if body.offset is None else (body.offset[0], body.offset[1])
        if body.offset is not None:
            out[f"{key}.m cx"], out[f"{key}.m cy"] = (body.mass * cx, "kg m"), (body.mass * cy, "kg m")
        S = skew(ca.vertcat(cx, cy, sign * body.center))
        about = body.inertia if body.inertia is not None else _slender(body)
        I = about - body.mass * S @ S
        for i, j in PAIRS:
            out[f"{key}.I{'xyz'[i]}{'xyz'[j]}"] = (I[i, j], "kg m2")
    return out


def _slender(body):
    axial = 0 if body.axial is None else body.axial
    return ca.diag(ca.vertcat(body.transverse, body.transverse, axial))


class StrutBodies:
    """Both bodies of a strut from the inertial parameters `pi`, general or slender."""

    def __init__(self, pi):
        self.pi = pi
        self.m_r = pi.get("drive.m", 0)
        self.parts = [part for part in ENDS if f"strut.{part}.m" in pi]
        self.general = {part: f"strut.{part}.Ixx" in pi for part in self.parts}

    def in_W(self, part, n, R_WS):
        """m, m c (3,) and I about the origin (3, 3) of a part, in axes of W.  R_WS only for a general one."""

        def of(key):
            return self.pi.get(f"strut.{part}.{key}", 0)

        along = ENDS[part] * of("m c")
        if not self.general[part]:
            nn = n @ n.T
            return of("m"), along * n, of("I") * (ca.SX.eye(3) - nn) + of("Iaxial") * nn
        mc = ca.vertcat(of("m cx"), of("m cy"), along)
        I = ca.SX(3, 3)
        for i, j in PAIRS:
            I[i, j] = I[j, i] = of(f"I{'xyz'[i]}{'xyz'[j]}")
        return of("m"), R_WS @ mc, R_WS @ I @ R_WS.T

    def wrenches(self, motion, gravity):
        """(f, t) that the motion of the moving part needs about B, and the fixed part about A.  2 x ((3,), (3,))."""
        R = motion.frame() if any(self.general.values()) else None
        out = []
        for part, origin in (("moving", motion.a_B), ("fixed", ca.SX(3, 1))):
            if part not in self.parts:
                out.append((ca.SX(3, 1), ca.SX(3, 1)))
                continue
            m, mc, I = self.in_W(part, motion.n, R)
            wrench = rigid_wrench(m, mc, I, motion.w, origin - gravity, motion.wd)
            out.append((wrench[:3], wrench[3:]))
        return out

    def force(self, motion, gravity):
        """F of eq. (1), on B, in W; the cross is `cross_force`.  (3,)."""
        (f, t), (_, t_f) = self.wrenches(motion, gravity)
        return f + motion.at_B(t + t_f) + motion.n * (self.m_r * motion.ldd)

    def mass(self, a, l, n):
        """Mass at B: F = mass a_B + ... .  (3, 3)."""
        A = turning(a, l, n)
        R = frame(a, n) if any(self.general.values()) else None
        M = self.m_r * n @ n.T
        for part in self.parts:
            m, mc, I = self.in_W(part, n, R)
            M += A.T @ I @ A
            if part == "moving":
                SA = skew(mc) @ A
                M += m * ca.SX.eye(3) - SA - SA.T
        return M


def turning(a, l, n):
    """A of w_s = A v_B, eq. (2) of strut_motion.py.  (3, 3)."""
    A = skew(n) / l
    return A if a is None else A + n @ spin(a, ca.dot(a, n), l, n).T


def cross_force(J, motion):
    """Eq. (2).  (3,)."""
    return motion.at_B(motion.a) * (J * ca.dot(motion.a, motion.wd))


def cross_mass(J, a, l, n):
    """The mass that the cross shows at B.  (3, 3)."""
    lever = turning(a, l, n).T @ a
    return J * lever @ lever.T
