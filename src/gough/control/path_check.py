"""Whether the equations of a path hold on a motion, and lead back to it from all sides: asked before a run."""

from __future__ import annotations

import casadi as ca
import numpy as np

from ..errors import ExperimentError
from .path_equations import frame_at

_SAMPLES = 500  # of a motion that are looked at
_OFF = 1e-6  # m, how far the programmed path may be from the zeros of its equations
_FLAT = 1e-6  # of what it is `_ASIDE` m beside the path: a gradient below is none
_ASIDE = 1e-3
_LEVEL = 1e-6  # volume of the three gradients, each of length 1: below they lie in one plane


def check_equations(law, motion, period: float) -> None:
    """See `EquivalentError.check_motion`."""
    if law.path is None and law.tangential == "distance":
        return  # the path's own frame is one everywhere
    count = motion.count(period)
    stride = max(1, -(-count // _SAMPLES))
    ticks = np.append(np.arange(0, count, stride), count - 1)
    # every so many samples are those of a longer period, in one call; and the last
    rows = motion.sample(0, len(ticks) - 1, stride * period), motion.sample(count - 1, count, period)
    tips, tangents, speeds = (
        np.concatenate([getattr(row, key)[:, :3] for row in rows]) for key in ("x", "tangent", "xd")
    )
    if law.tangential == "distance":  # at rest without a direction the frame keeps the last one
        moving = np.linalg.norm(tangents, axis=1) > 0.5
        ticks, tips, tangents = ticks[moving], tips[moving], tangents[moving]
    along = speeds if law.tangential == "power" else tangents
    if law.path is None:
        values, across = np.zeros((len(tips), 2)), np.array([frame_at(t)[1:] for t in tangents])
    else:
        values, across = _at(law, tips)
    gradients = np.concatenate([across, along[:, None]], axis=1)
    sizes = np.linalg.norm(gradients, axis=-1)

    def place(i):
        line = int(motion.book(int(ticks[i]), int(ticks[i]) + 1, period).line[0])
        return f"t = {ticks[i] * period:.6g} s" + (f", NC line {line}" if line else "")

    usual = [sizes[:, row].max() for row in range(3)]
    if law.path is not None:  # an equation squared has no gradient on the path, and one beside it
        beside = [np.linalg.norm(_at(law, tips + _ASIDE * axis)[1], axis=-1).max(0) for axis in np.eye(3)]
        usual[:2] = np.max(beside, axis=0)
    for row in range(3):
        bad = np.flatnonzero(~(sizes[:, row] > _FLAT * usual[row]))
        if len(bad):
            rule = f"equation {row + 1} of the path is degenerate here: it has no gradient"
            cure = "give equations whose gradients do not vanish on the path, or leave path out"
            if row == 2:
                rule, cure = "the tangential error is degenerate here: the reference rests", 'tangential = "distance"'
            raise ExperimentError(
                rule, key="tangential" if row == 2 else "path", where=place(bad[0]),
                value=f"|gradient| = {sizes[bad[0], row]:.3g}", cure=cure,
            )  # fmt: skip
    off = np.abs(values[:, :2]) / sizes[:, :2]
    if off.max() > _OFF:
        i, row = np.unravel_index(int(off.argmax()), off.shape)
        raise ExperimentError(
            f"equation {row + 1} of the path does not hold on the programmed path", key="path", where=place(i),
            value=f"{off[i, row]:.4g} m off", limit=f"{_OFF:g} m",
            cure="check centre, axes and origin, or leave path out: the law then takes the path's own frame",
        )  # fmt: skip
    volume = np.abs(np.linalg.det(gradients / sizes[..., None]))
    if volume.min() < _LEVEL:
        i = int(volume.argmin())
        raise ExperimentError(
            "the equations of the path are degenerate here: their gradients and the tangent lie in one plane",
            key="path", where=place(i), value=f"volume {volume[i]:.3g} of 1", limit=f"{_LEVEL:g}",
            cure="give two equations whose zeros cross",
        )  # fmt: skip


def _at(law, tips):
    """F (n, 2) and its gradients (n, 2, 3) at tips (n, 3)."""
    values, across = (np.array(out).T for out in _equations(law).map(len(tips))(law.theta, tips.T))
    return values, across.reshape(-1, 2, 3)


def _equations(law) -> ca.Function:
    """(theta, tip) -> F (2,) and its gradients, one behind the other (6,)."""
    theta, tip = ca.SX.sym("theta", len(law.theta)), ca.SX.sym("tip", 3)
    F = law.path.equations(law.at(theta).path, tip)
    return ca.Function("equations", [theta, tip], [F, ca.vec(ca.jacobian(F, tip).T)])
