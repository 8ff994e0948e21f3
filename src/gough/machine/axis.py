"""One axis: a carriage on a straight rail, driven by a linear motor or a screw.

    x the place of the carriage along the rail, m;  p_WT = x d,  R_WT = 1                                           (1)
    (m + m_r) x'' - m g . d = u - friction + d . f                                                                  (2)

d is the direction of the rail in W (unit), m the moving mass, m_r what the turning parts of a screw's drive add
(`drives.reflected_mass`), f the force on the tool.  With a screw, u = torque 2 pi / lead: the feed drive of Okuda,
Ibaraki, Kakino, Nakagawa, Matsushita 2006, eq. (3), K_t i / R with R = lead / 2 pi.
"""

from __future__ import annotations

from typing import ClassVar, Literal

import casadi as ca
import numpy as np
from pydantic import Field, model_validator

from ..declare import Array, Part, quantity
from ..errors import InputError, SheetError
from ..mechanics.load_friction import FrictionLaw
from .base import Feed, Machine
from .drives import LinearMotor, Screw, reflected_mass
from .limits import Limits
from .record import RecordMap

_UNIT = 1e-6  # how far from 1 the length of a direction may be
_ALWAYS = "near a singularity: det J against home"


class AxisCarriage(Part):
    """What moves."""

    input_error = SheetError

    mass: float = quantity("kg", "all that moves along the rail", above=0)


class Rail(Part):
    """Where it moves."""

    input_error = SheetError

    direction: Array = quantity("1", "direction of the rail, unit, in W", default=[1.0, 0.0, 0.0], shape=(3,))

    @model_validator(mode="after")
    def _unit(self):
        length = float(np.linalg.norm(self.direction))
        if abs(length - 1) > _UNIT:
            raise InputError("must have length 1", key="direction", value=f"{length:g}")
        return self


class AxisLimits(Limits):
    """How far it moves."""

    travel: Array = quantity("m", "least and greatest place of the carriage", shape=(2,))

    @model_validator(mode="after")
    def _ordered(self):
        if not self.travel[0] < self.travel[1]:
            raise InputError("the least comes first", key="travel", value=f"{self.travel.tolist()} m")
        return self


class Axis(Machine):
    """One carriage.  Fields are the tables of its data sheet."""

    task: ClassVar = (("x", "m"),)
    velocities: ClassVar = ("x'",)
    joint_names: ClassVar = ("carriage",)
    adaptable: ClassVar = ("carriage.mass",)
    pose_is_state: ClassVar = False

    elastic_places: ClassVar = {"drive": "axial"}

    kind: Literal["axis"] = "axis"
    name: str = Field(default="axis", max_length=64, pattern=r"^[A-Za-z0-9][A-Za-z0-9_.-]*$")
    gravity: Array = quantity("m/s2", "gravity, in W", default=[0.0, 0.0, -9.81], shape=(3,))
    carriage: AxisCarriage
    rail: Rail = Rail()
    drive: Screw | LinearMotor
    friction: FrictionLaw | None = None
    limits: AxisLimits
    feed: Feed = Feed()
    home: Array = quantity("m", "place at rest", shape=(1,))
    record: RecordMap | None = None
    source: dict[str, str] = Field(default_factory=dict)

    @model_validator(mode="before")
    @classmethod
    def _tables(cls, data):
        """A sheet writes the place at rest as a table, [home] place = ["0 m"]; a drive with a lead has a screw."""
        if not isinstance(data, dict):
            return data
        data = dict(data)
        if isinstance(data.get("home"), dict) and set(data["home"]) != {"unit", "value"}:
            if set(data["home"]) != {"place"}:
                raise InputError("[home] has one key, place", key="home", value=", ".join(map(str, data["home"])))
            data["home"] = data["home"]["place"]
        if isinstance(data.get("drive"), dict):
            try:
                data["drive"] = (Screw if "lead" in data["drive"] else LinearMotor)(**data["drive"])
            except InputError as error:
                raise type(error)(problems=[_under("drive", p) for p in error.problems]) from None
        return data

    @model_validator(mode="after")
    def _sound(self):
        if self.friction is not None and self.friction.loaded:
            raise InputError(
                f"{self.friction.kind} scales with forces between the tubes of a strut", key="friction.kind",
                cure="an axis has stribeck or lugre",
            )  # fmt: skip
        for key in () if self.friction is None else self.friction.specs():
            if np.ndim(getattr(self.friction, key)) and len(getattr(self.friction, key)) != 1:
                raise InputError("friction needs one value", key=f"friction.{key}")
        if not self.limits.travel[0] <= self.home[0] <= self.limits.travel[1]:
            raise InputError("home is beyond the rail", key="home", value=f"{self.home[0]:g} m")
        return self

    # -- coordinates: z = x, v = x' -------------------------------------------------------------------------------

    @property
    def coordinate_count(self) -> int:
        """One."""
        return 1

    @property
    def program_zero(self) -> np.ndarray:
        """The place of home, with the axes of W."""
        return np.concatenate([self.home[0] * self.rail.direction, np.zeros(3)])

    def task_motion(self, x, xd, xdd):
        """The parts along the rail of poses, twists and their rates (..., 6): (..., 1) each."""
        d = self.rail.direction
        return x[..., :3] @ d[:, None], xd[..., :3] @ d[:, None], xdd[..., :3] @ d[:, None]

    def tool_pose(self, x) -> np.ndarray:
        """x y z a b c of T in W.  (..., 1) -> (..., 6)."""
        x = super().tool_pose(x)
        return np.concatenate([x * self.rail.direction, np.zeros((*x.shape[:-1], 3))], -1)

    def standing(self, x) -> np.ndarray:
        """z of places.  (..., 1) -> (..., 1)."""
        return np.asarray(x, float)

    @staticmethod
    def coordinates_of(p, x):
        """z = x."""
        return x

    @staticmethod
    def tool_pose_of(p, z):
        """Position and quaternion of T in W, eq. (1).  (3,), (4,)."""
        return z * p.rail.direction, ca.SX([1, 0, 0, 0])

    @staticmethod
    def home_rotation(p):
        """R_WT at home.  (3, 3)."""
        return ca.SX.eye(3)

    @staticmethod
    def task_of(p, z):
        """x, of z."""
        return z

    @staticmethod
    def rate(p, z, v):
        """z' = v."""
        return v

    @staticmethod
    def normalised(p, z):
        """z: there is nothing to pull it back to."""
        return z

    @staticmethod
    def stepped(z, d):
        """z + d."""
        return z + d

    @staticmethod
    def between(z_before, z):
        """The v that leads from z_before to z in a second."""
        return z - z_before

    @staticmethod
    def target(p, r, z):
        """Error x_r - x, x_r' and x_r''."""
        return r.x - z, r.xd, r.xdd

    # -- kinematics -----------------------------------------------------------------------------------------------

    @staticmethod
    def joints_of(p, z):
        """q = x.  (1,) m."""
        return z

    @staticmethod
    def jacobian_of(p, z):
        """q' = v.  (1, 1)."""
        return ca.SX.eye(1)

    @staticmethod
    def task_velocities_of(p, z):
        """v by the task rate.  (1, 1)."""
        return ca.SX.eye(1)

    @staticmethod
    def newton_step(p, z, q):
        """The whole way."""
        return q - z

    @staticmethod
    def joint_acceleration(p, z, v, vd):
        """q'' = v'."""
        return vd

    @staticmethod
    def wrench_of(p, z, w):
        """The part of the force along the rail."""
        return ca.dot(ca.SX(p.rail.direction), w[:3])

    def carrying(self, mass, center):
        """The carriage heavier by a mass (kg): where it sits does not matter."""
        return self.replace(**{"carriage.mass": self.carriage.mass + mass})

    # -- dynamics -------------------------------------------------------------------------------------------------

    def inertial(self, p):
        """The parameters the dynamics are linear in: {name: (SX, unit)}.

        The moving mass; a screw's turning parts apart from it only where gravity tells them apart.
        """
        turning = reflected_mass(p.drive) if isinstance(self.drive, Screw) else 0.0
        if isinstance(self.drive, Screw) and self.drive.inertia is not None:
            return {"carriage.m": (p.carriage.mass, "kg"), "drive.m": (turning, "kg")}
        return {"carriage.m": (p.carriage.mass, "kg")}

    @staticmethod
    def _along(p):
        """g . d."""
        return ca.dot(ca.SX(p.gravity), ca.SX(p.rail.direction))

    def inverse_force(self, p, pi, z, v, vd):
        """(m + m_r) x'' - m g . d, eq. (2).  (1,) N."""
        return (pi["carriage.m"] + pi.get("drive.m", 0)) * vd - pi["carriage.m"] * self._along(p)

    def mass_and_bias(self, p, pi, z, v):
        """M (1, 1) and h (1,)."""
        M = ca.SX(1, 1)
        M[0, 0] = pi["carriage.m"] + pi.get("drive.m", 0)
        return M, self.inverse_force(p, pi, z, v, ca.SX(1, 1))

    @staticmethod
    def motor_load(p, pi):
        """The reflected mass of screw and motor; no weight.  (1,) kg, (1,) N, pi without it."""
        rest = {key: value for key, value in pi.items() if key != "drive.m"}
        return ca.SX(pi.get("drive.m", 0)), ca.SX(1, 1), rest

    # -- limits ---------------------------------------------------------------------------------------------------

    @staticmethod
    def determinant_of(p, z):
        """det J as a fraction of home's: always 1."""
        return ca.SX(1)

    def margins(self, p, z):
        """Names and values of all that must be >= 0: the ends of the rail; the last is that of det J."""
        names = ("carriage: beyond the start of its rail", "carriage: beyond the end of its rail", _ALWAYS)
        travel = p.limits.travel
        return names, ca.vertcat(z - travel[0], travel[1] - z, 1 - p.limits.determinant)

    def limit_told(self, index: int, margin: float) -> tuple[str, str, str]:
        """Rule, value and limit in words of the margin `index` that is `margin` < 0."""
        bound = self.limits.travel[min(index, 1)]
        return self.limit_names[index], f"{bound + margin if index == 0 else bound - margin:.8g} m", f"{bound:g} m"

    @staticmethod
    def stride_of(p):
        """The length of the rail, m."""
        return p.limits.travel[1] - p.limits.travel[0]

    def possible(self, q):
        """Every finite place is one."""
        return np.ones(len(q), bool), lambda row: ("is no place", "carriage")

    def drawing(self, x):
        """The machine as polylines in W with its carriage at x (1,).  List of {"name", "points"}."""
        d = self.rail.direction
        at = float(np.asarray(x, float).ravel()[0])
        ends = [(s * d).tolist() for s in self.limits.travel]
        half = 0.05 * (self.limits.travel[1] - self.limits.travel[0])
        return [
            {"name": "rail", "points": ends},
            {"name": "carriage", "points": [((at - half) * d).tolist(), ((at + half) * d).tolist()]},
        ]


def _under(table: str, problem):
    import dataclasses

    return dataclasses.replace(problem, key=f"{table}.{problem.key}" if problem.key else table)
