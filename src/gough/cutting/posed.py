"""Chatter on a machine that gives way: stability lobes at any pose, and the depth that is stable over the workspace.

Force and displacement of the tip stand in the frame C of force.py, x along the feed as far as it is across the tool, y
= z x x.  With e = [x y] (3, 2) and the response G of machine/vibration.py, eq. (15), from the wrench on the tool to it,

    H_m(f) = e' G(f)[:3, :3] e                          the joints free, under constant forces of the drives         (1)
    H_m(f) = e' W' N (s^2 N'MN + s N'DN + N'KN)^-1 N' W e    the joints held, J N = 0: ever so stiff servos         (2)
    H(f)   = H_m(f) + H_t(f) 1                          the tool's own bending in series                            (3)

of which lobes.py makes the border of stability.  (1) is right above the bandwidth of the servos only, below it a free
mass would seem to shake at any depth; (2) forgets that servos give way: what a law makes of it stands between, and
simulate/receptance.py tells.  H_t is the first bending mode of the round bar
of deflection.py, eq. (2), clamped and free, L its free length, A = pi (`core` D)^2 / 4:

    w_1 = 1.8751^2 sqrt(E I / (rho A L^4)),   H_t = (4 / (rho A L)) / (w_1^2 - w^2 + 2 i zeta w_1 w)                (4)

(its modal mass at the tip is a quarter of the bar's; statically it is 0.971 of L^3 / 3 E I).  (3) takes the tool as
light against what holds it.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..errors import ExperimentError, RunError
from ..frames import rotation_of_abc_np
from ..machine import vibration
from ..machine.arrays import column
from ..machine.equilibrium import unmoved
from ..quantities import brief
from . import force
from .cutting import Cutting
from .deflection import Beam
from .lobes import Lobes, Modes, lobes
from .numeric import ARRAYS

CARBIDE = 14_500.0  # kg/m3, cemented carbide with some 10 % cobalt (ISO K20 to K40: 14.3e3 to 14.9e3)
_ROOT = 1.875104068711961  # of cos x cosh x = -1


class TipResponse(NamedTuple):
    """What the tip of a tool gives way to a force on it, at one pose."""

    frequency: np.ndarray  # (n,) Hz
    response: np.ndarray  # (n, 2, 2) m/N, in x (feed) and y of C


def across(flexible, x, feed) -> np.ndarray:
    """[x y] of C as columns, in W, at the pose x (d,) and a feed along `feed` (3,) in W.  (3, 2).

    Raises
    ------
    ExperimentError
        a feed that is no direction, or goes along the tool.
    """
    axis = rotation_of_abc_np(flexible.rigid.tool_pose(column(x, len(flexible.rigid.task), "pose"))[3:])[:, 2]
    way = column(feed, 3, "feed")
    e_x = way - (way @ axis) * axis
    if way.ndim != 1 or np.linalg.norm(e_x) <= 1e-6 * max(np.linalg.norm(way), 1e-300):
        raise ExperimentError(
            "the feed must go across the tool: along its axis no wall is milled", key="feed", value=brief(feed)
        )
    e_x = e_x / np.linalg.norm(e_x)
    return np.stack([e_x, np.cross(axis, e_x)], 1)


def tool_mode(tool, damping: float = 0.02, density: float = CARBIDE) -> Modes:
    """The tool's own first bending, alike in x and y, eq. (4).

    Raises
    ------
    ExperimentError
        a tool without its free length; a damping ratio that is none.
    """
    if tool.extension is None:
        raise ExperimentError(
            "a tool that bends needs its length", key="tool.extension", cure='write e.g. extension = "75 mm"'
        )
    if not (0 < damping < 1 and density > 0 and np.isfinite(density)):
        raise ExperimentError("a damping ratio is above 0 and below 1, a density above 0", key="damping",
                              value=f"{damping:g}, {density:g} kg/m3")  # fmt: skip
    mass = density * math.pi * (tool.core * tool.diameter) ** 2 / 4 * tool.extension
    w = _ROOT**2 * math.sqrt(Beam().stiffness(tool) / (mass * tool.extension**3))
    return Modes(np.full(2, w / (2 * np.pi)), np.full(2, damping), np.eye(2) * 2 / math.sqrt(mass))


def tip_modes(flexible, x, feed, tool=None, tool_damping: float = 0.02) -> Modes:
    """The modes that carry the tip with the joints held, eq. (2), and the tool's own where `tool` has a length.

    Damping as far as it is each mode's own: exact where it is in proportion to stiffness.
    """
    from scipy.linalg import eigh

    e, one = across(flexible, x, feed), vibration.small_motions(flexible, x)
    N = unmoved(one.J)
    M, D, K = (N.T @ part @ N for part in (one.M, one.D, (one.K + one.K.T) / 2))
    squares, U = eigh(K, (M + M.T) / 2)
    w = np.sqrt(squares)
    found = Modes(w / (2 * np.pi), np.einsum("ij,ik,kj->j", U, D, U) / (2 * w), e.T @ one.W[:, :3].T @ N @ U)
    if tool is None or tool.extension is None:
        return found
    own = tool_mode(tool, tool_damping)
    return Modes(*(np.concatenate(pair, -1) for pair in zip(found, own, strict=True)))


def tip_response(flexible, x, frequency, feed, joints="held", tool=None, tool_damping: float = 0.02) -> TipResponse:
    """H of eq. (3) at the pose x (d,) of a machine's `flexible()`, at frequencies (n,) Hz above 0.

    `joints` "held" is eq. (2), "free" eq. (1); or a function of (machine, x, frequencies) -> (n, 6, 6), as of a law:
    lambda m, x, f: receptance(m, law, f, x).  `tool`, an EndMill with a length, bends in series.

    Raises
    ------
    ExperimentError
        frequencies not above 0, a feed along the tool, no such state of the joints.
    """
    e = across(flexible, x, feed)
    if callable(joints):
        G = joints(flexible, x, frequency)
    elif joints == "free":
        G = flexible.frequency_response(x, frequency, source="tool", to="tool")
    elif joints == "held":
        G = vibration.held_response(flexible, x, frequency)
    else:
        raise ExperimentError('must be "held", "free" or a function', key="joints", value=brief(joints))
    H = e.T @ G[:, :3, :3] @ e
    if tool is not None and tool.extension is not None:
        H = H + tool_mode(tool, tool_damping).response(frequency)
    return TipResponse(np.asarray(frequency, float), H)


def lobes_at(flexible, x, cutting: Cutting, feed, frequency=None, radial: float | None = None, joints="held") -> Lobes:
    """The border of stability of a cut at the pose x (d,), its feed along `feed` (3,) in W.

    `frequency` (n,) Hz is where chatter is looked for: by default up to twice the highest mode that carries the tip,
    finest about each mode.  `radial` m is the depth into the wall; the wall's greatest by default.
    """
    tool = cutting.tool
    if frequency is None:
        frequency = _grid(tip_modes(flexible, x, feed, tool))
    found = tip_response(flexible, x, frequency, feed, joints, tool)
    return lobes(*found, cutting.coefficients, tool.teeth, *engaged(cutting, radial))


def engaged(cutting: Cutting, radial: float | None = None) -> tuple[float, float]:
    """phi_1, phi_2 of a radial depth m (default: the wall's greatest), rad."""
    depth = float(cutting.wall.radial.max()) if radial is None else radial
    if not 0 < depth <= cutting.tool.diameter:
        raise ExperimentError(
            "no chip, or more than a full slot", key="radial", value=f"{depth:g} m",
            limit=f"{cutting.tool.diameter:g} m",
        )  # fmt: skip
    first, last = force.window(ARRAYS, cutting.tool, np.array(depth), cutting.wall.side)
    return float(first), float(last)


def depth_map(
    flexible, poses, cutting: Cutting, feed, radial: float | None = None, joints="held"
) -> dict[str, np.ndarray]:
    """Chatter-free axial depths at poses (N, d); NaN where the machine cannot stand.

    {"least": (N,) m, stable at every speed; "limit": (N,) m, at the cut's spindle speed (inf: no lobe there);
    "frequency": (N,) Hz, of the chatter that sets `least`}
    """
    rows = []
    for x in np.atleast_2d(np.asarray(poses, float)):
        try:
            found = lobes_at(flexible, x, cutting, feed, None, radial, joints)
        except RunError:
            rows.append([np.nan] * 3)
            continue
        at = np.nan if not len(found.depth) else found.frequency[found.depth.argmin()]
        rows.append([found.least, float(found.limit(cutting.spindle_speed)), at])
    return dict(zip(("least", "limit", "frequency"), np.array(rows).T, strict=True))


def _grid(modes: Modes, each: int = 60) -> np.ndarray:
    """Frequencies on which no mode is passed over: each resonance within 20 of its half widths, and in between."""
    f, width = modes.frequency, modes.frequency * np.maximum(modes.damping, 1e-4)
    near = f[:, None] + width[:, None] * np.linspace(-20, 20, each)
    wide = np.geomspace(f.min() / 4, 2 * f.max(), 400)
    every = np.unique(np.concatenate([near.ravel(), wide]))
    return every[every >= f.min() / 4]
