"""The limit case: without learning and without the sliding term both adaptive laws are computed torque.

At home, where K_D = k M(home) is k M, at rest and with friction neither believed nor compensated,

    u = J^-T (M (V_r' + (L + k) V_r + k L e) + g)                                                                   (1)

which is computed torque with the poles L, k and 0.  In motion C(V) sigma is left over (sliding.md of the theory pages).
"""

from __future__ import annotations

import casadi as ca
import numpy as np

from ...control.base import Measurement
from ...control.computed_torque import ComputedTorque
from ...kernel.pack import flatten, symbols, unflatten
from ...simulate.tick import rest_row
from .setup import FAST, law, machine

SAMPLES = 200
NO_FRICTION = 1e-12  # a coefficient: CDAC refuses a machine without friction to learn
NO_POLE = 1e-12  # 1/s, for the third pole of computed torque, which must be above 0


def difference(name: str) -> float:
    """The largest difference of the forces of CDAC or FCDAC from eq. (1), N, over random references at home at rest."""
    true = machine(torque_limit=None).replace(**{"drive.encoder": None, "joints.friction": None})
    without = {f"friction.{key}": NO_FRICTION for key in ("coulomb", "static")}
    true = true.replace(**without, **{"friction.viscous": 0.0, "friction.viscous_offset": 0.0})
    L, k = FAST.gains["slope"], FAST.gains["damping"]
    off = {"sliding": 0.0, "inertia_rate": 0.0}
    off |= {"coulomb_rate": 0.0, "viscous_rate": 0.0} if name == "CDAC" else {"friction_rate": 0.0}
    adaptive = law(name, FAST.gains, **off).on(true, FAST.period)
    torque = ComputedTorque(poles=np.array([L, k, NO_POLE])).on(true, FAST.period)
    rest = rest_row(true, true.home)
    u0 = true.inverse_dynamics(true.home, np.zeros(6), np.zeros(6))
    steps = [_force(one, one.init(rest, u0), rest) for one in (adaptive, torque)]
    random, found = np.random.default_rng(0), 0.0
    for _ in range(SAMPLES):
        # 1 mm and 1 mrad, 0.1 m/s and rad/s, 2 m/s2 and rad/s2: as large as they come on a machine tool
        x, xd, xdd = (size * random.standard_normal(6) for size in (1e-3, 0.1, 2.0))
        moved = rest._replace(x=true.home + x, xd=xd, xdd=xdd)
        forces = [np.array(step(rest.q, flatten(moved))).ravel() for step in steps]
        found = max(found, float(np.abs(forces[0] - forces[1]).max()))
    return found


def _force(control, state, row) -> ca.Function:
    """(q, reference) -> joint forces of the first sample."""
    r, q = symbols(row), ca.SX.sym("q", control.machine.joints_count)
    held = unflatten(state, ca.SX(ca.DM(flatten(state))))
    measured = Measurement(q, ca.SX(control.machine.joints_count, 1))
    command, _ = control.step(held, r, measured, ca.SX(ca.DM(control.theta)))
    return ca.Function("force", [q, flatten(r)], [command.u])
