"""Leaning the spindle against the cut: from a normal force to a corrected pose.

With x along the feed and y = z x x across it, to the left, a normal force d (in y, on the tool) leans the wall by
theta = f(d) (deflection.py) and pushes the tip by delta = R_a tan(theta) along y.  Against it the command is moved and
turned about the tip by

    dp = -delta y,     rho = -theta x  (a rotation vector)                                                          (1)

For a feed along -y of W and the tool upright, y of C is +x of W and x of C is -y: dp = (-delta, 0, 0), and rho is
+theta about +y, so b = +theta, the signs of Okuda et al. 2006, table 3.  With theta as a function of time, and the
frame C turning along the path by w_C = curvature s' (t x n),

    R_c = exp(rho) R,  v_c = v + dp.,  w_c = w + rho.,  and rates alike;  x. = w_C x x,  y. = w_C x y               (2)

to the second order in theta: 1e-6 of the tool's own turning at a twentieth of a degree.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from pydantic import model_validator

from ..declare import Array, quantity
from ..errors import ExperimentError, InputError
from ..frames import abc_of_rotation_np, rotation_of_abc_np, rotation_of_vector_np
from ..program.base import Program
from ..program.path import Path
from ..program.reference import Motion, Reference
from ..program.segments import cross, dot, norm
from .deflection import Leaning


class Command(NamedTuple):
    """What the tool is asked to do against the cut."""

    tilt: Any  # theta, rad
    shift: Any  # delta, m, at the tip


def command(law: Leaning, force, height: float) -> Command:
    """theta and delta of normal forces (...) N on a wall of `height` R_a m; eqs. (15), (16) of Okuda et al. 2006."""
    theta = law.inclination(force)
    return Command(theta, height * np.tan(theta))


class Corrected(Program):
    """A program whose tool leans against the cut: `tilt` from place to place of the path, changed smoothly.

    Between places[i] and places[i + 1] the tool leans by tilt[i]; outside it stands as programmed.  At each place the
    tilt changes along `blend` m of the way, half of it before, without a jump of its rate or of the rate of that: the
    feed goes on.  Errors are still measured against the program's own path.
    """

    program: Program
    places: Array = quantity("m", "where along the path the tilt changes, rising", shape=(-1,))
    tilt: Array = quantity("rad", "theta between them, one fewer", shape=(-1,))
    height: float = quantity("m", "height of the wall, R_a: it is there that the tool stays where it was", above=0)
    blend: float = quantity("m", "along which the tilt changes", default=4e-3, above=0)

    @model_validator(mode="after")
    def _fits(self):
        if len(self.tilt) != len(self.places) - 1 or len(self.places) < 2:
            raise InputError(
                f"{len(self.places)} places have {max(len(self.places) - 1, 0)} tilts between them", key="tilt",
                value=str(len(self.tilt)),
            )  # fmt: skip
        if not (np.diff(self.places) >= self.blend).all():
            raise InputError(
                "places must rise by `blend` at least", key="places", value=f"{np.diff(self.places).min():g} m",
                cure="a shorter blend, or fewer places",
            )  # fmt: skip
        if np.abs(self.tilt).max() > 0.05:
            raise InputError("must be below 0.05 rad: a tool that leans so much is broken", key="tilt")
        return self

    def path(self) -> Path:
        return self.program.path()

    def plan(self, machine) -> Motion:
        return CorrectedMotion(self.program.plan(machine), self)

    def theta(self, s) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """theta at path lengths s (n,) m and its first two derivatives by s.  rad, rad/m, rad/m2."""
        steps = np.diff(np.concatenate([[0.0], self.tilt, [0.0]]))
        u = np.clip((np.asarray(s, float)[:, None] - self.places) / self.blend + 0.5, 0, 1)
        value = u**3 * (10 - 15 * u + 6 * u * u)  # the quintic without rate and its rate at both ends
        rate = 30 * u**2 * (1 - u) ** 2 / self.blend
        bend = 60 * u * (1 - u) * (1 - 2 * u) / self.blend**2
        return value @ steps, rate @ steps, bend @ steps


class CorrectedMotion(Motion):
    """The motion of a Corrected program: that of its program, and eqs. (1), (2)."""

    def __init__(self, base: Motion, of: Corrected):
        if len(base.machine.task) < 6:
            raise ExperimentError(
                "only a machine with six freedoms can lean its tool", key="machine", value=base.machine.name
            )
        self.__dict__.update(base.__dict__)
        self.base, self.of = base, of

    def sample(self, k0: int, k1: int, Ts: float) -> Reference:
        """Samples k0 ... k1 - 1 at the period Ts s."""
        r = self.base.sample(k0, k1, Ts)
        s, sd = r.s[:, 0], r.sd[:, 0]
        sdd = dot(r.xdd[:, :3], r.tangent)
        theta, by_s, by_s2 = self.of.theta(s)
        angle = theta, by_s * sd, by_s2 * sd * sd + by_s * sdd
        x, xd, xdd = corrected(r, sdd, angle, self.of.height)
        q, qd, qdd = self.machine.joint_motion(x, xd, xdd, on_fail="nan")
        axis = rotation_of_abc_np(x[:, 3:])[..., 2]
        return r._replace(x=x, xd=xd, xdd=xdd, q=q, qd=qd, qdd=qdd, axis=axis)

    def book(self, k0: int, k1: int, Ts: float):
        return self.base.book(k0, k1, Ts)


def corrected(r: Reference, sdd, angle, height: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """x, xd, xdd (n, 6) of the rows r with theta, theta', theta'' (n,) each in `angle`, eqs. (1), (2)."""
    theta, rate, acc = (a[:, None] for a in angle)
    tangent = r.tangent - dot(r.tangent, r.axis)[:, None] * r.axis
    size = norm(tangent)
    e_x = tangent / np.where(size > 1e-9, size, 1.0)[:, None]
    e_y = cross(r.axis, e_x)
    turn = cross(r.tangent, r.normal) * r.curvature
    w_C, w_C_rate = turn * r.sd, turn * sdd[:, None]
    tan = np.tan(theta)
    delta, delta_d = height * tan, height * (1 + tan * tan) * rate
    delta_dd = height * (1 + tan * tan) * (acc + 2 * tan * rate * rate)
    dp, dp_d, dp_dd = _turning(-delta, -delta_d, -delta_dd, e_y, w_C, w_C_rate)
    rho, rho_d, rho_dd = _turning(-theta, -rate, -acc, e_x, w_C, w_C_rate)
    abc = abc_of_rotation_np(rotation_of_vector_np(rho) @ rotation_of_abc_np(r.x[:, 3:]))
    abc += 2 * np.pi * np.round((r.x[:, 3:] - abc) / (2 * np.pi))
    x = np.concatenate([r.x[:, :3] + dp, abc], 1)
    return x, r.xd + np.concatenate([dp_d, rho_d], 1), r.xdd + np.concatenate([dp_dd, rho_dd], 1)


def _turning(a, ad, add, e, w, wd):
    """a e and its first two derivatives, of a unit vector e that turns with w, w'.  (n, 3) each."""
    e_d = cross(w, e)
    e_dd = cross(wd, e) + cross(w, e_d)
    return a * e, ad * e + a * e_d, add * e + 2 * ad * e_d + a * e_dd
