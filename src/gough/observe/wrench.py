"""The wrench on the tool that a force on the independent velocities stands for.

    F = B w,   w = T F                                                                                              (1)

B is what the machine says a wrench does (`Machine.wrench_of`).  A platform with six freedoms tells all of w: T = 1, or
B^-1.  With fewer the tool's moment cannot be told from its force; then w is a force at the tip alone, and of those that
make F the smallest: T = [B_f' (B_f B_f')^-1; 0], B_f the columns of B that belong to the force.
"""

from __future__ import annotations

import casadi as ca
import numpy as np

from ..mechanics.linear import solve_spd, solve_square


def tool_map(machine, p, z):
    """T of eq. (1) at the coordinates z.  (6, len(v))."""
    count = len(machine.velocities)
    if count == 6 and machine.pose_is_state:
        return ca.SX.eye(6)
    w = ca.SX.sym("w", 6)
    B = ca.jacobian(machine.wrench_of(p, z, w), w)
    if count == 6:
        return solve_square(B, ca.SX.eye(6))
    B_f = B[:, :3]
    return ca.vertcat(B_f.T @ solve_spd(B_f @ B_f.T, ca.SX.eye(count)), ca.SX(3, count))


def tool_map_np(machine, x) -> np.ndarray:
    """T at the pose x (d,).  (6, len(v))."""
    T = tool_map(machine, machine, ca.SX(ca.DM(machine.coordinates(x))))
    return np.array(ca.evalf(ca.densify(T)))
