"""The machine on arrays: (..., k) in, (..., n) out, by the same equations the kernel runs.

Rows are independent; leading axes broadcast.  Every answer is checked: inputs must be finite, and what divides by the
Jacobian is refused near a singularity.
"""

from __future__ import annotations

from functools import lru_cache

import casadi as ca
import numpy as np

from .. import frames
from ..declare import Shape
from ..errors import ExperimentError, SingularityError
from ..kernel.building import BUILDING
from ..kernel.rows import compile_rows
from ..mechanics.linear import solve_spd, solve_square_transposed
from ..quantities import brief
from . import workspace


class Arrays:
    """Row functions of one machine; `machine.arrays`.  Compiled on first use, from a cache thereafter."""

    def __init__(self, machine):
        self.machine = machine
        self.shape = Shape(machine)
        self.theta = machine.theta

    def run(self, name: str, *columns, checked: bool = True) -> list[np.ndarray]:
        """Evaluate the row function `name` on columns (..., k), broadcast over the leading axes.

        Unless `checked`, rows without an answer are left as NaN, for a caller that looks at every row.
        """
        arrays = [np.asarray(column, float) for column in columns]
        try:
            lead = np.broadcast_shapes(*(a.shape[:-1] for a in arrays))
        except ValueError:
            shapes = ", ".join(str(a.shape) for a in arrays)
            raise ExperimentError("the leading axes do not fit together", value=shapes) from None
        # one row serves all rows as it is; what has leading axes of its own is spread over those of the others
        rows = [a if a.ndim == 1 else np.broadcast_to(a, lead + a.shape[-1:]).reshape(-1, a.shape[-1]) for a in arrays]
        out = _compiled(name, self.shape)(self.theta, *rows)
        if checked and name not in _UNCHECKED:
            self._check_finite(name, out, lead, rows[0])
        return [piece.reshape(lead + piece.shape[-1:]) for piece in out]

    def _check_finite(self, name: str, out: list[np.ndarray], lead: tuple[int, ...], x: np.ndarray) -> None:
        """Refuse an answer that is not a number: a leg that cannot reach, two joints in one place, numbers beyond any
        machine.  x (N, d) or (d,): the poses asked for."""
        for piece in out:
            if _all_finite(piece):
                continue
            bad = np.flatnonzero(~np.isfinite(piece).all(-1))
            if len(bad):
                index = [int(i) for i in np.unravel_index(bad[0], lead)]
                place = f"index {index}" if index else None
                found = self.machine.unreachable(np.atleast_2d(x if x.ndim == 1 else x[bad[0]]))
                if found is not None:
                    raise found[1].at(where=place)
                raise SingularityError(
                    f"{name.replace('_', ' ')} has no finite answer here",
                    where=place,
                    value=str(piece[bad[0]].tolist()),
                    cure="check the pose: a leg of no length, or numbers beyond any machine",
                )


_BLOCK = 1 << 16  # numbers looked at together
_UNCHECKED = ("newton", "landing", "margins", "workspace")  # whoever asks for these looks at every row itself


def _all_finite(array: np.ndarray) -> bool:
    """Whether all numbers are, a block at a time: a million rows need no array of conditions."""
    flat = array.reshape(-1)
    return all(np.isfinite(flat[k : k + _BLOCK]).all() for k in range(0, flat.size, _BLOCK))


def column(value, size: int, what: str) -> np.ndarray:
    """`value` as an array (..., size) of finite numbers.

    Raises
    ------
    ExperimentError
        wrong last axis, or a number that is not finite, with its index.
    """
    try:
        array = np.asarray(value)
        if array.dtype.kind not in "fiu":
            raise TypeError
        array = array.astype(float, copy=False)
    except (TypeError, ValueError):
        raise ExperimentError(f"{what} must be real numbers", value=brief(value)) from None
    if array.ndim == 0 or array.shape[-1] != size:
        raise ExperimentError(f"{what} must have shape (..., {size})", value=str(array.shape))
    if not _all_finite(array):
        bad = np.argwhere(~np.isfinite(array))
        index = tuple(int(i) for i in bad[0])
        raise ExperimentError(f"{what} must be finite", where=f"index {list(index)}", value=str(array[index]))
    return array


def check_determinant(ratio: np.ndarray, least: float) -> None:
    """Refuse rows whose det J, as a fraction of home's, is below `least` (or NaN).

    Raises
    ------
    SingularityError
        with the index of the first row.
    """
    good = ratio[..., 0] >= least
    if not good.all():
        bad = np.argwhere(~good)
        index = tuple(int(i) for i in bad[0])
        raise SingularityError(
            "the joints do not hold the platform here: det J against home",
            where=f"index {list(index)}" if index else None,
            value=f"{ratio[index][0]:.3g}",
            limit=f"{least:g}",
            cure="stay away from the singular pose, or change limits.determinant",
        )


@lru_cache(maxsize=256)
def _compiled(name: str, shape: Shape):
    with BUILDING:
        return compile_rows(row_function(name, shape.part))


def row_function(name: str, m) -> ca.Function:
    """The row function `name` of machine `m` as SX: theta first, then its columns."""
    p, theta = m.symbols
    x, xd, xdd = (ca.SX.sym(s, len(m.task)) for s in ("x", "xd", "xdd"))
    u, w = ca.SX.sym("u", m.joints_count), ca.SX.sym("w", 6)
    z = m.coordinates_of(p, x)
    v = m.velocity_of(p, z, xd)
    pi = {key: value for key, (value, _) in m.inertial(p).items()}
    J = m.jacobian_of(p, z)
    if name == "inverse_kinematics":
        return ca.Function(name, [theta, x], [m.joints_of(p, z)])
    if name == "jacobian":
        return ca.Function(name, [theta, x], [ca.vec(m.task_jacobian_of(p, z).T)])
    if name == "velocity_jacobian":
        return ca.Function(name, [theta, x], [ca.vec(J.T)])
    vd = m.acceleration_of(p, z, v, xdd)
    if name == "joint_motion":
        return ca.Function(name, [theta, x, xd, xdd], [m.joints_of(p, z), J @ v, m.joint_acceleration(p, z, v, vd)])
    if name == "tool_pose":
        position, quat = m.tool_pose_of(p, z)
        abc = frames.abc_of_rotation(frames.rotation_of_quaternion(quat))
        return ca.Function(name, [theta, x], [ca.vertcat(position, abc)])
    if name == "coordinates":
        return ca.Function(name, [theta, x], [z])
    if name in ("newton", "landing", "margins", "workspace"):
        z_, q = ca.SX.sym("z", m.coordinate_count), ca.SX.sym("q", m.joints_count)
        if name == "newton":
            return ca.Function(name, [theta, z_, q], [*_newton_step(m, p, z_, q)])
        if name == "landing":
            away = ca.mmax(ca.fabs(ca.vertcat(q - m.joints_of(p, z_), m.closure_of(p, z_))))
            inside = ca.vertcat(workspace.workspace_of(m, p, z_), m.margins(p, z_)[1])
            return ca.Function(name, [theta, z_, q], [m.task_of(p, z_), away, inside])
        if name == "workspace":
            return ca.Function(name, [theta, z_], [workspace.workspace_of(m, p, z_)])
        return ca.Function(name, [theta, z_], [m.margins(p, z_)[1]])
    if name == "inverse_dynamics":
        force = m.inverse_force(p, pi, z, v, vd) - m.wrench_of(p, z, w)
        return ca.Function(name, [theta, x, xd, xdd, w], [solve_square_transposed(J, force), m.determinant_of(p, z)])
    if name == "forward_dynamics":
        M, h = m.mass_and_bias(p, pi, z, v)
        vd = solve_spd(M, J.T @ u + m.wrench_of(p, z, w) - h)
        return ca.Function(name, [theta, x, xd, u, w], [m.task_acceleration_of(p, z, v, vd)])
    if name == "mass":
        M, h = m.mass_and_bias(p, pi, z, v)
        if not m.pose_is_state:  # from v to the task rate
            J_v = m.task_velocities_of(p, z)
            h = J_v.T @ (h + M @ m.acceleration_of(p, z, v, ca.SX(len(m.task), 1)))
            M = J_v.T @ M @ J_v
        return ca.Function(name, [theta, x, xd], [ca.vec(M), h])
    if name == "reactions":
        net = solve_square_transposed(J, m.inverse_force(p, pi, z, v, vd) - m.wrench_of(p, z, w))
        found = [ca.vec(piece) for piece in m.reactions_of(p, z, v, vd, net, w=w) if piece is not None]
        return ca.Function(name, [theta, x, xd, xdd, w], [ca.vertcat(*found), m.determinant_of(p, z)])
    if name == "regressor":
        symbols = {key: ca.SX.sym(key) for key in pi}
        force = m.inverse_force(p, symbols, z, v, vd)
        Y = ca.jacobian(force, ca.vertcat(*symbols.values()))
        return ca.Function(
            name, [theta, x, xd, xdd], [ca.vec(solve_square_transposed(J, Y).T), m.determinant_of(p, z), J @ v]
        )
    raise KeyError(name)


def _newton_step(m, p, z, q):
    """z after one step of eq. (1) of forward.py, shortened, and the largest entry of the step taken; 0 where J is
    singular: the search ends there."""
    reach = m.stride_of(p)
    d = m.newton_step(p, z, q)
    sound = ca.mmax(ca.fabs(d)) < np.inf
    for i in range(d.numel()):  # mmax overlooks a NaN behind a number
        sound = ca.logic_and(sound, ca.fabs(d[i]) < np.inf)
    size = ca.fmax(ca.norm_2(d[:3]) / reach, ca.norm_2(d[3:]) / 0.3)
    d = ca.if_else(sound, d / ca.fmax(size, 1), 0)
    return m.normalised(p, m.stepped(z, d)), ca.mmax(ca.fabs(d))
