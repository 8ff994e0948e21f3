"""Columns of a torque in each base joint of a hexapod, against the turning of its strut: t_0j of Okuda et al. 2006.

    u = ... - sum_j J^-T B_j t_0j                                                                                   (1)

B_j is eq. (3) of observe/kinetic.py with 1 N m in joint j; Okuda, Ibaraki, Kakino, Nakagawa, Matsushita, Disturbance
estimation on a hexapod-type parallel kinematic machine tool, 2006, eqs. (11), (13).  A torque that is constant is what
their model has; where joints rub in proportion to their load it comes out wrong (docs/studies/okuda2006.md).
Theory: docs/theory/identification.md.
"""

from __future__ import annotations

from functools import lru_cache

import casadi as ca
import numpy as np

from ..declare import Shape
from ..errors import ExperimentError
from ..kernel.rows import compile_rows
from ..mechanics.linear import solve_square
from ..observe.kinetic import base_torques

KIND = "base_torque"
REST = 1e-4  # m/s of a platform joint across its strut, below which its torque has no direction


def check(machine) -> None:
    """Refuse a machine without base joints.

    Raises
    ------
    ExperimentError
        it has no struts.
    """
    if not hasattr(machine, "struts"):
        raise ExperimentError(
            "only a machine of struts has base joints with a torque", key="friction", value=machine.name
        )


def columns(machine, x, xd) -> np.ndarray:
    """-J^-T B of eq. (1) on motions x, xd (N, 6).  (N, 6, 6): joints, then columns."""
    flat = _rows(Shape(machine))(machine.theta, x, xd)[0]
    return flat.reshape(-1, 6, 6).swapaxes(1, 2)  # CasADi stores columns first


@lru_cache(maxsize=16)
def _rows(shape: Shape):
    m = shape.part
    p, theta = m.symbols
    x, xd = ca.SX.sym("x", 6), ca.SX.sym("xd", 6)
    z = m.coordinates_of(p, x)
    found = -solve_square(m.jacobian_of(p, z).T, base_torques(m, p, z, xd, REST))
    return compile_rows(ca.Function("base_torques", [theta, x, xd], [ca.densify(ca.vec(found))]))
