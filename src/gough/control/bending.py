"""How far a flexible machine gives way at its tool, symbolic, for laws that allow for it: in closed form, or by a map.

With elastic drives (machine/elastic_drives.py) nothing has to be searched: the tool at x, x', x'' asks for the forces f
of the rigid machine, without what is on the motors' side, and the springs for joints

    q_c = q(x) + c(x) f(x, x', x''),   J' f = M_r v' + h_r                                                          (1)

c the compliance of the legs in series.  (What c' adds to the forces of a bent spring is left out: f c' / 2 of f, some
1e-5.)  d of `shift` is the displacement from x to the place x_c with q(x_c) = q_c, by two Newton steps.  A hybrid
machine with elastic slides has the polynomials of elastic_map.py, eqs. (1), (3) there.

docs/theory/flexible_control.md, section 1.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import casadi as ca
import numpy as np

from .. import frames
from ..declare import Shape
from ..errors import ExperimentError
from ..kernel.building import BUILDING
from ..machine.base import Machine
from ..machine.elastic_drives import ElasticDrives
from ..mechanics.linear import solve_square_transposed
from .elastic_map import ElasticMap, fitted

Bends = ElasticDrives | ElasticMap


def bends_of(machine: Machine, degree: int, moving: bool) -> Bends:
    """What tells how `machine`, as a law believes it, gives way.

    Raises
    ------
    ExperimentError
        nothing in it gives way, or it declares no workspace.
    """
    try:
        flexible = machine.flexible()
    except ExperimentError as error:
        raise error.at(key="machine") from None
    return flexible if isinstance(flexible, ElasticDrives) else fitted(flexible, degree, moving)


def shift(machine: Machine, bends: Bends, p: Any, x, xd=None, xdd=None):
    """d (len(task),): from the tool's place to the one that the joints must stand for; m, and a rotation vector in W.

    `p` is a view of `bends`; at rest where xd, xdd are left out.
    """
    if isinstance(bends, ElasticMap):
        d = bends.sag_of(p, x)
        return d if xd is None else d + bends.motion_of(p, x, xd, xdd)
    m, view = bends.stiff, p.stiff
    z = m.coordinates_of(view, x)
    v = m.velocity_of(view, z, ca.SX.zeros(len(m.task)) if xd is None else xd)
    vd = m.acceleration_of(view, z, v, ca.SX.zeros(len(m.task)) if xdd is None else xdd)
    return _of_drives(bends, p, z, v, vd)


def shift_along(machine: Machine, bends: Bends, p: Any, x, xd, xdd):
    """d at rest at the place x, and its rates d', d'' as x moves with xd, xdd.  (len(task),) each."""
    if isinstance(bends, ElasticMap):
        s, sd, sdd = x, xd, xdd
        at, rate, bend = (ca.SX.sym(name, len(machine.task)) for name in ("x", "xd", "xdd"))
        d, flow = bends.sag_of(p, at), rate
    else:
        m, view = bends.stiff, p.stiff
        s = m.coordinates_of(view, x)
        sd = m.velocity_of(view, s, xd)
        sdd = m.acceleration_of(view, s, sd, xdd)
        at, rate, bend = ca.SX.sym("z", s.shape), ca.SX.sym("v", sd.shape), ca.SX.sym("vd", sdd.shape)
        rest = ca.SX.zeros(sd.shape)
        d, flow = _of_drives(bends, p, at, rest, rest), m.rate(view, at, rate)
    dd = ca.jtimes(d, at, flow)
    ddd = ca.jtimes(dd, at, flow) + ca.jtimes(dd, rate, bend)
    return tuple(ca.substitute([d, dd, ddd], [at, rate, bend], [ca.densify(ca.SX(one)) for one in (s, sd, sdd)]))


def _of_drives(bends: ElasticDrives, p, z, v, vd):
    """Eq. (1), at coordinates z of the rigid machine."""
    m, view = bends.stiff, p.stiff
    pi = {key: value for key, (value, _) in m.inertial(view).items()}
    behind = m.motor_load(view, pi)[2]  # of the springs
    f = solve_square_transposed(m.jacobian_of(view, z), m.inverse_force(view, behind, z, v, vd))
    q_c = m.joints_of(view, z) + bends.in_series(p, z).compliance * f
    z_c = z
    for _ in range(2):
        z_c = m.normalised(view, m.stepped(z_c, m.newton_step(view, z_c, q_c)))
    if len(m.task) != 6:
        return m.task_of(view, z_c) - m.task_of(view, z)
    turn = frames.quaternion_product(z_c[3:], frames.conjugate(z[3:]))
    return ca.vertcat(z_c[:3] - z[:3], frames.rotation_vector_of_quaternion(turn))


@lru_cache(maxsize=32)
def _function(machine: Shape, bends: Shape) -> ca.Function:
    """(theta of `bends`, x) -> d at rest."""
    with BUILDING:
        theta = ca.SX.sym("theta", len(bends.part.theta))
        x = ca.SX.sym("x", len(machine.part.task))
        return ca.Function("shift", [theta, x], [shift(machine.part, bends.part, bends.part.at(theta), x)])


def shift_at(machine: Machine, bends: Bends, x: np.ndarray) -> np.ndarray:
    """d at rest at places x (N, len(task)), as a law finds it.  (N, len(task)) m, rad."""
    x = np.atleast_2d(x)
    return np.array(_function(Shape(machine), Shape(bends)).map(len(x))(bends.theta, x.T)).T
