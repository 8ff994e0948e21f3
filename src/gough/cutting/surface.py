"""The wall that a milling run leaves: where the teeth were at the instants at which they made it.

A tooth makes its line of the wall at the end of its way through the stock when it cuts down, phi = Phi = pi, and at
the beginning when it cuts up, Phi = 0.  At the height z that is, for the q-th passing tooth,

    t_q(z) = (Phi + k z - phi_0 + q 2 pi / N) / Omega,    tooth j = -q mod N                                        (1)

Then the tool's axis stood, at that height, at  c_q = p(t_q) + z a(t_q) + delta(z; F_y(t_q)) y, with the true tip p and
axis a of the run and the tool's deflection (deflection.py): under the force of that instant for a beam, of the mean
over a turn for the measured law.  The nominal wall at the place s of the programmed path is w(s) = p(s) + z a(s) + R n,
R = D / 2, with n across the path towards the wall.  Of a circle of radius R_j about c_q there is left on the wall

    e_q = (w - c_q) . n - sqrt(R_j^2 - ((w - c_q) . t)^2),       e(s, z) = min over q of e_q                        (2)

so e > 0 is material that stands proud, e < 0 a gouge; marks of the feed and of runout are in it.  Straight and curved
walls are one case.  A machine that gives way does so in p and a already where its plant was flexible; of a run of a
rigid plant, giving.py adds what it would, under the mean force over a turn.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..errors import LogError
from ..frames import rotation_of_abc_np
from ..program.path import Path
from ..program.segments import cross, dot, norm
from .cutting import Cutting
from .giving import Giving

HEIGHTS = 19


class CutWall(NamedTuple):
    """A wall that was cut: `error` (n, m) m proud of the nominal one, at path lengths s (n,) and heights z (m,) m.

    NaN where nothing was cut.
    """

    s: np.ndarray
    z: np.ndarray
    error: np.ndarray

    def along_z(self, first: float, last: float) -> np.ndarray:
        """Mean profile over the height, of the wall from `first` to `last` m of the path.  (m,) m."""
        rows = (self.s >= first) & (self.s <= last) & np.isfinite(self.error).all(1)
        if not rows.any():
            raise LogError("no wall was cut there", value=f"{first:g} m to {last:g} m of the path")
        return self.error[rows].mean(0)

    def along_feed(self, z: float) -> np.ndarray:
        """Profile along the feed at the height nearest to z m.  (n,) m."""
        return self.error[:, int(np.argmin(np.abs(self.z - z)))]

    def inclination(self, first: float, last: float) -> float:
        """As Okuda et al. 2006 measure it: of the line through the highest and the lowest point of `along_z`, rad.

        Above 0 where the wall stands proud towards the tip of the tool.
        """
        profile = self.along_z(first, last)
        high, low = int(np.argmax(profile)), int(np.argmin(profile))
        if high == low:
            return 0.0
        return math.atan((profile[high] - profile[low]) / (self.z[low] - self.z[high]))

    def slope(self, first: float, last: float) -> float:
        """Of the straight line nearest to `along_z` (least squares), rad, signed as `inclination`."""
        return math.atan(-np.polyfit(self.z, self.along_z(first, last), 1)[0])

    def deviation(self, first: float, last: float) -> float:
        """Highest less lowest point of `along_z`, m."""
        return float(np.ptp(self.along_z(first, last)))


class Ran(NamedTuple):
    """What of a run makes the wall: rows over time, as a Log has them."""

    t: np.ndarray  # (n,) s
    x: np.ndarray  # (n, 6) m, rad: true pose
    s_r: np.ndarray  # (n,) m: place of the reference on the course

    @classmethod
    def of(cls, log) -> Ran:
        """Of a Log, or anything that gives its variables by name.  LogError where a pose has no angles."""
        x = np.asarray(log["x"])
        if x.ndim != 2 or x.shape[1] != 6:
            raise LogError("a wall is made by a tool with a pose of six numbers", key="x", value=str(x.shape))
        return cls(np.asarray(log["t"]), x, np.asarray(log["s_r"]))


def cut_wall(cutting: Cutting, nominal: Path, ran: Ran, s, z=None, giving: Giving | None = None) -> CutWall:
    """The wall at the places s (n,) m of the programmed path `nominal` and the heights z (m,) m, eqs. (1), (2).

    `nominal` is the path as placed in W (`motion.path`); `ran` is a run on it, or beside it on purpose; `giving` is
    what a machine gives way that was rigid in that run.
    """
    s = np.asarray(s, float)
    z = np.linspace(0, cutting.wall.axial_depth, HEIGHTS) if z is None else np.asarray(z, float)
    k = 2 * math.tan(cutting.tool.helix) / cutting.tool.diameter
    N, omega = cutting.tool.teeth, cutting.spindle_speed
    Phi = math.pi if cutting.wall.side < 0 else 0.0
    p_w, t_w, n_w, a_w = _frame(nominal, s, cutting.wall.side)
    R = cutting.tool.diameter / 2
    rows = np.flatnonzero(np.diff(ran.s_r, prepend=-1.0) > 0)  # where the tool moves along
    time_at = np.interp(s, ran.s_r[rows], ran.t[rows])
    best = np.full((len(s), len(z)), np.inf)
    here = np.round((omega * time_at[:, None] + cutting.start_angle - Phi - k * z) * N / (2 * math.pi)).astype(int)
    for step in range(-N - 1, N + 2):
        q = here + step
        at = (Phi + k * z - cutting.start_angle + q * (2 * math.pi / N)) / omega
        c, cut = _axis_at(cutting, nominal, ran, at, z, giving)
        d = p_w[:, None] + z[:, None] * a_w[:, None] + R * n_w[:, None] - c
        radius = _radius(cutting, -q % N)
        across = (d * t_w[:, None]).sum(-1)
        with np.errstate(invalid="ignore"):
            e = (d * n_w[:, None]).sum(-1) - np.sqrt(radius**2 - across**2)
        best = np.fmin(best, np.where(cut, e, np.inf))
    stock = cutting.wall.depth(s) > 0
    return CutWall(s, z, np.where(stock[:, None] & np.isfinite(best), best, np.nan))


def _radius(cutting, tooth):
    """R_j of teeth."""
    tool = cutting.tool
    off = 0.0 if tool.runout is None else tool.runout * np.cos(tool.runout_angle - tooth * 2 * np.pi / tool.teeth)
    return tool.diameter / 2 + off


def _frame(path: Path, s, side):
    """Of places on a path: point, tangent, direction across towards the wall, tool axis.  (n, 3) each."""
    i, u = path.locate(s)
    u = np.minimum(u, path.length[i])
    p, t = path.point(i, u), path.tangent(i, u)
    a = path.rotation(path.angles(i, u))[..., 2]
    t = t - dot(t, a)[:, None] * a
    t = t / norm(t)[:, None]
    return p, t, side * cross(a, t), a


def _axis_at(cutting: Cutting, nominal: Path, ran: Ran, at, z, giving):
    """c_q of eq. (2) at times `at` (n, m) s for heights z (m,), and whether the tool moved then.  (n, m, 3), (n, m)."""
    flat = at.ravel()
    p = np.stack([np.interp(flat, ran.t, ran.x[:, i]) for i in range(3)], -1)
    axes = rotation_of_abc_np(ran.x[:, 3:])[..., 2]
    a = np.stack([np.interp(flat, ran.t, axes[:, i]) for i in range(3)], -1)
    a = a / norm(a)[:, None]
    s = np.interp(flat, ran.t, ran.s_r)
    rate = np.gradient(ran.s_r, ran.t)
    speed = np.maximum(np.interp(flat, ran.t, rate), 0.0)
    depth = cutting.wall.depth(s)
    inside = (flat >= ran.t[0]) & (flat <= ran.t[-1])
    _, t, _, _ = _frame(nominal, np.clip(s, 0.0, nominal.s0[-1]), cutting.wall.side)
    y = cross(a, t)
    y = y / norm(y)[:, None]
    height = np.broadcast_to(z, at.shape).ravel()
    c = p + height[:, None] * a
    law, R_a = cutting.deflection, cutting.wall.axial_depth
    mean = np.zeros((len(flat), 4))
    if giving is not None or (law is not None and not law.instant):
        mean = np.where((depth > 0)[:, None], cutting.mean_forces(speed, depth), 0.0)
    if law is not None:
        F = mean[:, 1]
        if law.instant:
            F = cutting.forces(speed, depth, cutting.start_angle + cutting.spindle_speed * flat)[:, 1]
            F = np.where(depth > 0, F, 0.0)
        c = c + law.lateral(cutting.tool, F, R_a / 2, height, R_a)[:, None] * y
    if giving is not None:
        moved, turned = giving.under(s, mean, R_a)
        c = c + (moved + height * turned)[:, None] * y
    return c.reshape(*at.shape, 3), (inside & (speed > 0)).reshape(at.shape)
