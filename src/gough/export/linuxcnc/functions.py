"""What a controller computes beside the kinematics of export/c, as functions over SX that are printed as C.

LinuxCNC's axes are the frame O of programs: its machine zero is where gough puts program zero (`Machine.program_zero`),

    p_WT = p_WO + R_WO p_OT,   R_WT = R_WO R(abc)                                                                  (1)

so an NC program without offsets means to both the same.  Feedforward of joints q, q', q'' at the pose x they have:

    v = J^-1 q',   v' = J^-1 (q'' - J' v),   u = J^-T (M v' + h)                                                   (2)
"""

from __future__ import annotations

import casadi as ca
import numpy as np

from ...frames import abc_of_rotation, rotation_of_abc, rotation_of_abc_np
from ...mechanics.linear import solve_square, solve_square_transposed


def axes_of(machine) -> str:
    """Letters of the axes of a machine, its task coordinates: XYZ or XYZABC."""
    return "XYZABC"[: len(machine.task)]


def frames(machine) -> list[ca.Function]:
    """placed: pose in O -> pose in W; seen: back, eq. (1).  (d,) each."""
    zero = np.asarray(machine.program_zero, float)
    p_WO, R_WO = zero[:3], rotation_of_abc_np(zero[3:])
    pose = ca.SX.sym("pose", len(machine.task))
    turned = bool(np.any(zero[3:]))

    def angles(R):
        # with the axes of W the angles are those of the program to the last bit, whatever their turns
        return pose[3:] if not turned else abc_of_rotation(R @ rotation_of_abc(pose[3:]))

    there = p_WO + (R_WO @ pose[:3] if turned else pose[:3])
    back = R_WO.T @ (pose[:3] - p_WO) if turned else pose[:3] - p_WO
    if len(machine.task) == 6:
        there, back = ca.vertcat(there, angles(R_WO)), ca.vertcat(back, angles(R_WO.T))
    return [ca.Function(name, [pose], [out], ["pose"], ["out"]) for name, out in (("placed", there), ("seen", back))]


def feedforward(machine) -> ca.Function:
    """(theta, pose in W (d,), q', q'') -> forces of the joints (n,), eq. (2)."""
    p, theta = machine.symbols
    x = ca.SX.sym("pose", len(machine.task))
    qd, qdd = (ca.SX.sym(name, machine.joints_count) for name in ("rate", "acceleration"))
    z = machine.coordinates_of(p, x)
    J = machine.jacobian_of(p, z)
    v = solve_square(J, qd)
    vd = solve_square(J, qdd - machine.joint_acceleration(p, z, v, ca.SX(*v.shape)))
    pi = {key: value for key, (value, _) in machine.inertial(p).items()}
    u = solve_square_transposed(J, machine.inverse_force(p, pi, z, v, vd))
    names = ["theta", "pose", "rate", "acceleration"]
    return ca.Function("feedforward", [theta, x, qd, qdd], [u], names, ["force"])
