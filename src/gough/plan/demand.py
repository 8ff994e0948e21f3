"""What a motion asks of a machine, row by row: each of its limits as a share that is used, 1 at the limit.

    use = 1 - m / m_home          of a margin m of `Machine.margins`: stroke, cones, singularity; 0 at home          (1)
    use = |q'| / speed,  |q''| / acceleration,  |u| / force                                                        (2)

The force u is that of the drives on the motion, against the weight and a steady force on the tool, friction included:
friction with a memory counts at its
steady value, g(v) sign(v) + f_v v (mechanics/friction.py), friction that scales with a load at the load of this motion.
"""

from __future__ import annotations

import re
from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple

import casadi as ca
import numpy as np

from ..declare import Shape
from ..errors import SheetError
from ..kernel.building import BUILDING
from ..kernel.rows import compile_rows
from ..machine.drives import force_limit
from ..mechanics.friction import level
from ..mechanics.linear import solve_square_transposed

if TYPE_CHECKING:
    from ..simulate.plant import Plant

POSE, SPEED, ACCELERATION, FORCE = "pose", "speed", "acceleration", "force"
_UNITS = {SPEED: "m/s", ACCELERATION: "m/s2", FORCE: "N"}
_NUMBERED = re.compile(r"(\D+\d+(?: and \d+)?):? (.*)")  # "strut 3: too long", "carriages 1 and 2: too close"
_BESIDE = ("cutting", "flexible", "friction_drift", "faults")  # of a plant, that no demand has
_LEAST_SPAN = 1e-6  # of a margin at home: a machine that stands at its limit there has no scale of its own


class Demand:
    """The limits of a machine, and how much of each a motion uses.

    `plant` is what the machine really is, where that is known: its numbers, its payload and the steady force on its
    tool are asked; `unjudged` names what else it has that is not in the demand.  `kinds` (k,) says of each column
    whether it is of the pose, a speed, an acceleration or a force; `unchecked` which of the last three the sheet has no
    limit for.

    Raises
    ------
    SheetError
        no limit of joints at all beside those of the pose, with `driven`.
    """

    def __init__(self, machine, driven: bool = False, plant: Plant | None = None):
        self.machine = machine = (machine if plant is None else plant.true_machine).rigid
        self.wrench = np.zeros(6) if plant is None else np.asarray(plant.wrench, float)
        self.unjudged = tuple(key for key in _BESIDE if plant is not None and getattr(plant, key))
        self.limits = {
            SPEED: machine.limits.speed,
            ACCELERATION: machine.limits.acceleration,
            FORCE: force_limit(machine.drive),
        }
        self.unchecked = tuple(kind for kind, limit in self.limits.items() if limit is None)
        if driven and len(self.unchecked) == 3:
            raise SheetError(
                "the machine has no limit of its joints' speed, acceleration or force", key="limits",
                value=machine.name, cure='write speed = "18 m/min" and acceleration = "10 m/s2" in [limits]',
            )  # fmt: skip
        self.bounded = [kind for kind, limit in self.limits.items() if limit is not None]
        home = machine.arrays.run("margins", machine.standing(np.atleast_2d(machine.home)))[0][0]
        self.scale = np.maximum(home, _LEAST_SPAN)
        n = machine.joints_count
        self.kinds = np.array([POSE] * len(home) + [kind for kind in self.bounded for _ in range(n)])
        self.pose_count = len(home)
        self._rows = _compiled(Shape(machine))

    def __len__(self) -> int:
        return len(self.kinds)

    def uses(self, x, xd, xdd) -> tuple[np.ndarray, np.ndarray]:
        """How much of each limit rows (N, d) of task coordinates and their rates use, and which rows cannot be stood.

        (N, k) and (N,) bool.  Where a pose is outside its limits nothing is asked of the drives: 0; and 0 is what is no
        number where the machine cannot stand at all.
        """
        margins, qd, qdd, u = self._rows(self.machine.theta, x, xd, xdd, self.wrench)
        found = dict(zip((SPEED, ACCELERATION, FORCE), (qd, qdd, u), strict=True))
        n, k = qd.shape[1], self.pose_count
        out = np.empty((len(qd), len(self)))
        np.divide(margins, -self.scale, out=out[:, :k])
        out[:, :k] += 1
        for i, kind in enumerate(self.bounded):
            at = out[:, k + i * n : k + (i + 1) * n]
            np.abs(found[kind], out=at)
            at /= self.limits[kind]
        broken = ~np.isfinite(out.sum(1))  # a NaN or inf anywhere
        if broken.any():
            out[broken] = np.where(np.isfinite(out[broken]), out[broken], 0.0)
        outside = broken | (out[:, :k] > 1).any(1)
        if outside.any():
            out[outside, k:] = 0.0
        return out, broken

    def values(self, x, xd, xdd) -> dict[str, np.ndarray]:
        """q' m/s, q'' m/s2 and drive forces N of rows (N, d), by kind.  (N, n) each."""
        _, qd, qdd, u = self._rows(self.machine.theta, x, xd, xdd, self.wrench)
        return {SPEED: qd, ACCELERATION: qdd, FORCE: u}

    def told(self, column: int, use: float) -> Told:
        """What the limit `column` is called, the value that uses `use` of it, and the limit, in words."""
        machine, k = self.machine, self.pose_count
        if column < k:
            rule, value, limit = machine.limit_told(column, (1 - use) * self.scale[column])
            return Told(POSE, *parted(rule), value, limit)
        kind, joint = str(self.kinds[column]), (column - k) % machine.joints_count
        bound = self.limits[kind]
        value, limit = (f"{number:.4g} {_UNITS[kind]}" for number in (use * bound, bound))
        return Told(kind, machine.joint_names[joint], f"{kind} too high" if use > 1 else kind, value, limit)

    def name(self, column: int) -> tuple[str, str]:
        """Joint (or "pose") and what is limited, of a column."""
        if column < self.pose_count:
            return parted(self.machine.limit_names[column])
        return self.machine.joint_names[(column - self.pose_count) % self.machine.joints_count], str(self.kinds[column])


class Told(NamedTuple):
    """A limit in words."""

    kind: str
    joint: str
    what: str
    value: str
    limit: str


def parted(rule: str) -> tuple[str, str]:
    """Joint and what is wrong with it, of what a machine says of a limit; "pose" where it is of no joint."""
    numbered = _NUMBERED.match(rule)
    if numbered:
        return numbered[1], numbered[2]
    joint, _, what = rule.partition(": ")
    return (joint, what) if what and not joint.startswith("near") else ("pose", rule)


@lru_cache(maxsize=32)
def _compiled(shape: Shape):
    with BUILDING:
        return compile_rows(_function(shape.part))


def _function(m) -> ca.Function:
    """theta, x, xd, xdd, w on the tool in W -> margins, q', q'', u of the drives."""
    p, theta = m.symbols
    w = ca.SX.sym("w", 6)
    x, xd, xdd = (ca.SX.sym(s, len(m.task)) for s in ("x", "xd", "xdd"))
    z = m.coordinates_of(p, x)
    v = m.velocity_of(p, z, xd)
    vd = m.acceleration_of(p, z, v, xdd)
    pi = {key: value for key, (value, _) in m.inertial(p).items()}
    J = m.jacobian_of(p, z)
    qd, wanted = J @ v, m.inverse_force(p, pi, z, v, vd) - m.wrench_of(p, z, w)
    u, loads = solve_square_transposed(J, wanted), None
    if m.load_count:
        loads = m.loads_carried(p, pi, z, v, vd, u)
        u = solve_square_transposed(J, wanted - m.joint_friction(p, z, v, loads))
    u = u + _steady_friction(m, p, qd, loads)
    out = [m.margins(p, z)[1], qd, m.joint_acceleration(p, z, v, vd), u]
    return ca.Function("demand", [theta, x, xd, xdd, w], out)


def _steady_friction(m, p, qd, loads):
    """Friction of the joints at steady speeds qd.  (n,) N."""
    law = m.friction
    if law is None or not law.memory_per_joint:
        return m.strut_friction(p, qd, ca.SX(0, 1), loads)
    numbers = law.at_load(p.friction, loads[: m.joints_count]) if law.loaded else p.friction
    return level(numbers, qd) * ca.sign(qd) + numbers.viscous * qd
