"""The plant linearised at rest, in continuous time.

Held at a pose by the forces u_0, with d = [dp; rotation vector] the displacement of the tool in axes of W:

    d' = v,   v' = M^-1 (d/dd (J' u_0 - h) d + J' (u - u_0)),   x - x_0 = T d                                      (1)

T = diag(1, E^-1) turns a rotation vector into a b c (frames.py, (4)).  A machine with velocities of its own has their
displacement in place of d: a 3-PRS that of its sliders, and T is then that of its tip by them; one with elastic joints
those of its tool and its motors.  Friction is left out: at rest it has no slope, or none that says anything of motion.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import casadi as ca
import numpy as np

from ..declare import Shape
from ..errors import ExperimentError, SingularityError
from ..machine.arrays import column
from . import tick

LEVEL = 1e-6  # least cos b; a' and c' are 1 / cos b times what turns


class StateSpace(NamedTuple):
    """What SciPy and python-control take: `scipy.signal.StateSpace(*linearize(machine, x))`."""

    A: np.ndarray
    B: np.ndarray
    C: np.ndarray
    D: np.ndarray


def linearize(machine, x) -> StateSpace:
    """The machine at rest at the pose x (d,) as A, B, C, D in continuous time, eq. (1), without friction.

    State: displacement of the tool, [dp; rotation vector] in axes of W, m and rad, and its rate, the twist; (2 d,).  A
    machine of velocities of its own (`machine.velocities`) has their displacement and them in place of these.
    Input: joint forces beyond those that hold the machine there, (n,) N.  Output: change of the task coordinates,
    x y z a b c in m and rad, (d,).

    Raises
    ------
    SingularityError
        the joints do not hold the platform at x, or a and c are one there (b = +-90 deg).
    """
    x = column(x, len(machine.task), "pose")
    if x.ndim != 1:
        raise ExperimentError("linearize takes one pose", key="x", value=f"shape {x.shape}")
    if len(x) == 6 and abs(np.cos(x[4])) < LEVEL:
        raise SingularityError(
            "a and c turn about one axis here: a b c have no rates", value=f"b = {x[4]:g} rad",
            cure="linearize elsewhere, or turn W so that the pose is another",
        )  # fmt: skip
    bare = machine.frictionless()
    d, still = len(bare.velocities), np.zeros(len(bare.velocities))
    z, u0 = bare.at_rest(x)
    found = plant_jacobians(Shape(bare))(bare.theta, z, still, np.zeros(0), u0, np.zeros(bare.load_count))
    rates, _, push, shown, _ = (np.array(one) for one in found)
    S = rates[: len(z), len(z) :]  # z' = S v
    A = np.block([[np.zeros((d, d)), np.eye(d)], [rates[len(z) :, : len(z)] @ S, rates[len(z) :, len(z) :]]])
    C = np.hstack([shown @ S, np.zeros((len(x), d))])
    return StateSpace(A, np.vstack([np.zeros((d, len(u0))), push]), C, np.zeros((len(x), len(u0))))


@lru_cache(maxsize=64)
def plant_jacobians(shape: Shape) -> ca.Function:
    """(theta, z, v, memory, u, loads) -> five Jacobians.

    d(z', v')/d(z, v) with the friction's memory held, the same with the memory among the states, dv'/du, dx/dz, and
    that of the task rate by v.
    """
    machine = shape.part
    p, theta, z, v, mem = tick.symbols_of(machine)
    u, loads = ca.SX.sym("u", machine.joints_count), tick.loads_symbol(machine)
    rates = ca.vertcat(*tick.rate(machine, p, z, v, mem, u, ca.SX.zeros(6), loads))
    y = ca.vertcat(z, v)
    whole, whole_rates = y, rates
    if mem.numel():
        bristles = machine.memory_rate(p, machine.jacobian_of(p, z) @ v, mem, loads)
        whole, whole_rates = ca.vertcat(y, mem), ca.vertcat(rates, bristles)
    out = [
        ca.jacobian(rates, y),
        ca.jacobian(whole_rates, whole),
        ca.jacobian(rates, u)[z.numel() :, :],
        ca.jacobian(machine.task_of(p, z), z),
        ca.jacobian(machine.task_rate_of(p, z, v), v),
    ]
    return ca.Function("jacobians", [theta, z, v, mem, u, loads], out)
