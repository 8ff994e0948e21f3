"""What a controller computes of a machine, as functions over SX that are printed as C.

LinuxCNC's axes are the frame O of programs: its machine zero is where gough puts program zero (`Machine.program_zero`),

    p_WT = p_WO + R_WO p_OT,   R_WT = R_WO R(abc)                                                                  (1)

so an NC program without offsets means to both the same.  `zero` is the column p_WO (3), R_WO by columns (9).
Feedforward of joints q, q', q'' as they are commanded, z from one sample's joints to the next by Newton's method:

    v = J^-1 q',   v' = J^-1 (q'' - J' v),   u = J^-T (M v' + h)                                                   (2)
"""

from __future__ import annotations

import casadi as ca
import numpy as np

from ...frames import abc_of_rotation, rotation_of_abc, rotation_of_abc_np, rotation_of_quaternion
from ...machine.arrays import row_function
from ...mechanics.linear import solve_square, solve_square_transposed


def axes_of(machine) -> str:
    """Letters of the axes of a machine, its task coordinates: XYZ or XYZABC."""
    return "XYZABC"[: len(machine.task)]


def zero_of(machine) -> np.ndarray:
    """`zero` of eq. (1), (12,)."""
    pose = np.asarray(machine.program_zero, float)
    return np.concatenate([pose[:3], rotation_of_abc_np(pose[3:]).ravel(order="F")])


def inverse(machine) -> ca.Function:
    """(theta, zero, pose in O (d,)) -> joints (n,), z, margins of the limits."""
    p, theta = machine.symbols
    d = len(machine.task)
    zero, pose = ca.SX.sym("zero", 12), ca.SX.sym("pose", d)
    R_WO = ca.reshape(zero[3:], 3, 3)
    x = zero[:3] + R_WO @ pose[:3]
    if d == 6:
        turned = bool(np.any(np.asarray(machine.program_zero)[3:]))
        # axes of W: the angles are those of the program, to the last bit, whatever their turns
        x = ca.vertcat(x, abc_of_rotation(R_WO @ rotation_of_abc(pose[3:])) if turned else pose[3:])
    z = machine.coordinates_of(p, x)
    return ca.Function("inverse", [theta, zero, pose], [machine.joints_of(p, z), z, machine.margins(p, z)[1]])


def newton(machine) -> ca.Function:
    """(theta, z, joints) -> z after a step of machine/forward.py, eq. (1), and the largest entry of the step."""
    return row_function("newton", machine)


def landing(machine) -> ca.Function:
    """(theta, zero, z, joints) -> pose in O (d,), residual m, margins of the limits, the last one of det J."""
    p, theta = machine.symbols
    zero = ca.SX.sym("zero", 12)
    z, q = ca.SX.sym("z", machine.coordinate_count), ca.SX.sym("q", machine.joints_count)
    position, quat = machine.tool_pose_of(p, z)
    R_WO = ca.reshape(zero[3:], 3, 3)
    pose = R_WO.T @ (position - zero[:3])
    if len(machine.task) == 6:
        pose = ca.vertcat(pose, abc_of_rotation(R_WO.T @ rotation_of_quaternion(quat)))
    residual = ca.mmax(ca.fabs(ca.vertcat(q - machine.joints_of(p, z), machine.closure_of(p, z))))
    return ca.Function("landing", [theta, zero, z, q], [pose, residual, machine.margins(p, z)[1]])


def feedforward(machine) -> ca.Function:
    """(theta, z before, q, q', q'') -> forces of the joints u (n,), eq. (2), and z."""
    p, theta = machine.symbols
    n = machine.joints_count
    z0 = ca.SX.sym("z", machine.coordinate_count)
    q, qd, qdd = (ca.SX.sym(name, n) for name in ("q", "qd", "qdd"))
    z = z0
    for _ in range(2):  # as observe/forward.py: the start is one sample's motion away
        z = machine.normalised(p, machine.stepped(z, machine.newton_step(p, z, q)))
    J = machine.jacobian_of(p, z)
    v = solve_square(J, qd)
    still = ca.SX(*v.shape)
    vd = solve_square(J, qdd - machine.joint_acceleration(p, z, v, still))
    pi = {key: value for key, (value, _) in machine.inertial(p).items()}
    u = solve_square_transposed(J, machine.inverse_force(p, pi, z, v, vd))
    return ca.Function("feedforward", [theta, z0, q, qd, qdd], [u, z])
