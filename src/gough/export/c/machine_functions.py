"""The functions of one machine that C needs, over SX: (theta, ...) -> ..., parameters named as in C.

coordinates   x -> z                         system  z, q -> K, r of a Newton step K d = r
inverse       x -> q, gap of the closure     moved   z, d -> z after the step
landing       z, q -> x, residual, margins   direct  q -> z, where that has a closed form
"""

from __future__ import annotations

import casadi as ca
import numpy as np

from ...machine import workspace
from ...machine.arrays import row_function
from ...machine.axis import Axis
from ...machine.base import Machine
from ...machine.hybrid import Hybrid


def named(name: str, inputs: dict, outputs: dict) -> ca.Function:
    """A Function whose inputs and outputs have these names."""
    values = [ca.densify(ca.SX(value)) for value in outputs.values()]
    return ca.Function(name, list(inputs.values()), values, list(inputs), list(outputs))


def closed_form(machine: Machine) -> bool:
    """Whether joints give coordinates without a search."""
    return isinstance(machine, Axis | Hybrid)


def unknowns(machine: Machine) -> int:
    """How many numbers the forward kinematics searches: a twist, or the dependent coordinates."""
    return 6 if machine.pose_is_state else machine.coordinate_count - machine.joints_count


def kinematic_functions(m: Machine) -> dict[str, ca.Function]:
    """Name -> function, each with theta as its first input."""
    p, theta = m.symbols
    d, n = len(m.task), m.joints_count
    x, z = ca.SX.sym("pose", d), ca.SX.sym("z", m.coordinate_count)
    q, step = ca.SX.sym("joints", n), ca.SX.sym("d", unknowns(m))
    at = m.coordinates_of(p, x)
    gap = m.closure_of(p, at)
    J = row_function("jacobian", m)
    inside = ca.vertcat(workspace.workspace_of(m, p, z), m.margins(p, z)[1])
    away = ca.mmax(ca.fabs(ca.vertcat(q - m.joints_of(p, z), m.closure_of(p, z))))
    found = {
        "coordinates": named("coordinates", {"theta": theta, "pose": x}, {"z": at}),
        "inverse": named(
            "inverse",
            {"theta": theta, "pose": x},
            {"joints": m.joints_of(p, at), "gap": ca.mmax(ca.fabs(gap)) if gap.numel() else ca.SX(0)},
        ),
        "jacobian": named("jacobian", {"theta": theta, "pose": x}, {"J": J(theta, x)}),
        "landing": named(
            "landing",
            {"theta": theta, "z": z, "joints": q},
            {"pose": m.task_of(p, z), "residual": away, "margins": inside},
        ),
    }
    if closed_form(m):
        found["direct"] = named("direct", {"theta": theta, "joints": q}, {"z": _direct(m, p, q)})
        return found
    if m.pose_is_state:
        K, r = m.newton_system(p, z, q)
        after = m.normalised(p, m.stepped(z, step))
    else:
        c = m.closed(p, z)
        K, r = c.phi_b, -c.phi
        after = ca.vertcat(z[:n], z[n:] + step)
    found["system"] = named("system", {"theta": theta, "z": z, "joints": q}, {"K": ca.vec(K), "r": r})
    found["moved"] = named("moved", {"theta": theta, "z": z, "d": step}, {"after": after})
    return found


def _direct(m, p, q):
    """z of joints: of an axis its place; of a hybrid machine eq. (3) of machine/hybrid.py solved for phi10."""
    if isinstance(m, Axis):
        return q
    b = p.base.half_width
    phi = ca.asin((q[1] - q[0]) / (2 * b))
    return ca.vertcat(q, 2 * b * ca.cos(phi), phi, phi)


def dynamic_functions(m: Machine) -> dict[str, ca.Function]:
    """inverse_dynamics: pose, rate, acceleration, wrench -> force, det J against home."""
    p, theta = m.symbols
    d = len(m.task)
    x, xd, xdd = (ca.SX.sym(name, d) for name in ("pose", "rate", "acceleration"))
    w = ca.SX.sym("wrench", 6)
    f = row_function("inverse_dynamics", m)
    force, ratio = f(theta, x, xd, xdd, w)
    inputs = {"theta": theta, "pose": x, "rate": xd, "acceleration": xdd, "wrench": w}
    return {"inverse_dynamics": named("inverse_dynamics", inputs, {"force": force, "determinant": ratio})}


def reach(m: Machine) -> float:
    """The longest step of the search, m, as machine/forward.py takes it."""
    return float(ca.evalf(ca.SX(m.stride_of(m))))


def home_sign(m: Machine) -> float:
    """The sign of det K of `system` at home."""
    z = np.ravel(m.coordinates(m.home))
    K = kinematic_functions(m)["system"](m.theta, z, m.inverse_kinematics(m.home))[0]
    size = unknowns(m)
    return float(np.sign(np.linalg.det(np.array(K).reshape(size, size, order="F"))))
