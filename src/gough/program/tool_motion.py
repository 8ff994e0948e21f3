"""Pose, twist and twist rate of the tool on a path, from the extent travelled and its derivatives by time.

With the tip at p(s), the angles at abc(u), both along the path (u the extent travelled in its block):

    v = p' s',  v' = p' s'' + p'' s'^2;    abc. = abc' u',  abc.. = abc' u'' + abc'' u'^2
    w = E abc.,  w' = E abc.. + E. abc.                                                                            (1)

w and w' are turned by R_WO from the program's frame into W.  The T of the data sheet stands at o from the tip of the
tool in use, along the axes of T (a tool offset, G43):

    p_T = p + R o,   v_T = v + w x R o,   v_T' = v' + w' x R o + w x (w x R o)                                     (2)
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..frames import abc_rate_matrix_dot_np, abc_rate_matrix_np
from .blocks import REST
from .path import Path
from .segments import cross, rotated


class ToolMotion(NamedTuple):
    """Of n places: pose x (n, 6) of T in W, twist xd, its rate xdd; tangent and bend (n, 3) of the path; R_WT."""

    x: np.ndarray
    xd: np.ndarray
    xdd: np.ndarray
    tangent: np.ndarray
    bend: np.ndarray
    R_WT: np.ndarray


def tool_motion(path: Path, i, u, ud, udd) -> ToolMotion:
    """Equations (1) and (2) at the extent u (n,) of the blocks i (n,), with its rates.  Rows do not see each other."""
    moving = path.kind[i] != REST
    length, sd, sdd = (np.where(moving, a, 0.0) for a in (u, ud, udd))
    position, tangent, bend = path.frame(i, length)
    v = tangent * sd[:, None]
    vd = tangent * sdd[:, None] + bend * (sd * sd)[:, None]
    abc, k = path.angles(i, u), path.angle_rate(i, u)
    rate, acc = k * ud[:, None], k * udd[:, None] + path.angle_bend(i, u) * (ud * ud)[:, None]
    E, Ed = abc_rate_matrix_np(abc), abc_rate_matrix_dot_np(abc, rate)
    w = rotated(path.R_WO, rotated(E, rate))
    wd = rotated(path.R_WO, rotated(E, acc) + rotated(Ed, rate))
    R_WT = path.rotation(abc)
    if path.tool.any():
        arm = rotated(R_WT, path.tool[i])
        about = cross(w, arm)
        position, v, vd = position + arm, v + about, vd + cross(wd, arm) + cross(w, about)
    x = np.concatenate([position, path.pose_angles(abc)], 1)
    return ToolMotion(x, np.concatenate([v, w], 1), np.concatenate([vd, wd], 1), tangent, bend, R_WT)
