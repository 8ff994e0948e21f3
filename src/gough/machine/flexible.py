"""Machines that give way: what [[compliance]] names, and what every machine with elastic joints can tell.

A machine's `flexible()` is the machine with its elastic joints: more velocities v than joints, q' = J v with J (n, m).
It is for the plant; laws go on believing the rigid one.  Its answers below are from its own equations, at rest:
vibration.py.
"""

from __future__ import annotations

from typing import Any, ClassVar, Literal, NamedTuple

import numpy as np

from ..complaints import under
from ..declare import View
from ..errors import ExperimentError, InputError, Problem, did_you_mean
from ..mechanics.compliance import Compliance
from ..quantities import brief
from . import equilibrium, vibration
from .arrays import column
from .base import Machine


class ElasticJoint(NamedTuple):
    """One joint of a machine that gives way."""

    place: str  # which sort of joint
    number: int  # from 0
    entry: Compliance
    key: str  # of the entry in the sheet


def elastic_joints(machine: Machine) -> list[ElasticJoint]:
    """Every joint that [[compliance]] names, one by one.

    Raises
    ------
    InputError
        a joint that the machine has not, one that cannot give way here, or one that is named twice.
    """
    found: dict[tuple[str, int], ElasticJoint] = {}
    wrong: list[Problem] = []
    for i, entry in enumerate(machine.compliance or ()):
        key = f"compliance.{i}"
        try:
            place, numbers = _named(machine, entry.joint)
            sort = machine.elastic_places[place]
            if sort != "full":  # any number of components will do there
                entry.along() if sort == "axial" else entry.spring()
        except InputError as error:
            wrong += [under(problem, key) for problem in error.at(key="joint").problems]
            continue
        for number in numbers:
            if (place, number) in found:
                told = f"{place} {machine.elastic_numbers(place)[number]}"
                wrong.append(Problem("this joint is there already", key=f"{key}.joint", value=told))
            else:
                found[place, number] = ElasticJoint(place, number, entry, key)
    if wrong:
        raise InputError(problems=wrong)
    return list(found.values())


def _named(machine: Machine, name: str) -> tuple[str, range]:
    """The sort of joint that a name tells, and its numbers from 0."""
    for place in machine.elastic_places:
        numbers = machine.elastic_numbers(place)
        if name == f"{place}s" or (len(numbers) == 1 and name == place):
            return place, range(len(numbers))
        if name.startswith(f"{place} ") and name.removeprefix(f"{place} ").isdecimal():
            number = int(name.removeprefix(f"{place} "))
            if number in numbers:
                return place, range(numbers.index(number), numbers.index(number) + 1)
            told = ", ".join(map(str, numbers))
            raise InputError("no joint of this machine has this number", value=repr(name)[:60], cure=f"there is {told}")
    for place, why in machine.rigid_places.items():
        if name == f"{place}s" or name.rstrip("0123456789 ") == place:
            raise InputError(f"{machine.kind}: the {place} must be rigid: {why}", value=repr(name)[:60])
    known = [f"{place}s" for place in machine.elastic_places]
    cure = did_you_mean(name, known) if known else "this kind of machine has none"
    raise InputError("no joint of this machine that may give way", value=repr(name)[:60], cure=cure)


def check_names(machine: Machine) -> None:
    """Refuse [[compliance]] that names what is not there; see `elastic_joints`."""
    elastic_joints(machine)


def check_options(measured: Any, stiffness: Any) -> None:
    """Refuse options of `Machine.flexible` that are none."""
    if measured not in ("motor", "joint"):
        raise ExperimentError('must be "motor" or "joint"', key="measured", value=repr(measured)[:60])
    if isinstance(stiffness, bool) or not isinstance(stiffness, int | float) or not 0 < stiffness < np.inf:
        raise ExperimentError("must be a number above 0", key="stiffness", value=repr(stiffness)[:60])


def check_given(machine: Machine) -> None:
    """Refuse to make a machine flexible that says of no joint how.

    Raises
    ------
    ExperimentError
        without [[compliance]].
    """
    if not machine.compliance:
        known = ", ".join(f"{place}s" for place in machine.elastic_places)
        raise ExperimentError(
            f"{machine.name} has no [[compliance]]: nothing in it gives way", key="flexible",
            cure=f'give [[compliance]] with joint = ... ({known}) and stiffness = "..."',
        )  # fmt: skip


class FlexibleMachine(Machine):
    """Base of machines with elastic joints: the machine `stiff` that laws believe, and springs.

    Its numbers are those of both.  A form states what machine/base.py asks for, with more velocities than joints.
    """

    pose_is_state: ClassVar[bool] = False

    stiff: Machine
    measured: Literal["motor", "joint"] = "motor"

    @property
    def rigid(self) -> Machine:
        """The machine without elastic joints: what laws believe."""
        return self.stiff

    def __getattr__(self, name: str) -> Any:
        """What is not of the springs is the rigid machine's: its name, drive, friction, limits, joints."""
        if name.startswith("_") or name in ("stiff", "leg_ratio", "reaction_fields", "reactions_of"):
            raise AttributeError(name)
        return getattr(self.stiff, name)

    def at(self, theta: Any) -> View:
        view = super().at(theta)
        inner = view.stiff
        view._values |= {name: getattr(inner, name) for name in type(self.stiff).model_fields if name != "compliance"}
        return view

    def to_file(self) -> dict[str, Any]:
        """The sheet of the rigid machine, [[compliance]] included."""
        return self.stiff.to_file()

    def frictionless(self) -> Machine:
        return self.replace(stiff=self.stiff.frictionless())

    def with_perfect_drives(self) -> Machine:
        return self.replace(stiff=self.stiff.with_perfect_drives())

    # -- what every one can tell ----------------------------------------------------------------------------------

    def at_rest(self, x, wrench=None) -> tuple[np.ndarray, np.ndarray]:
        """z and u (n,) N of rest with the joints where the rigid machine has the pose x (d,); see equilibrium.py."""
        return equilibrium.at_rest(self, x, wrench)

    def settled_pose(self, x, wrench=None) -> np.ndarray:
        """x y z a b c of T in W at rest, the joints where the rigid machine has the pose x (d,).  (6,) m, rad."""
        return equilibrium.pose_of(self, self.at_rest(x, wrench)[0])

    def targets(self, x, wrench=None) -> np.ndarray:
        """Readings of the encoders (n,) m that put the tool at x (d,) at rest, bent as it is; see equilibrium.py."""
        return equilibrium.targets(self, x, wrench)

    def tool_compliance(self, x, wrench=None) -> np.ndarray:
        """[displacement m; turn rad] of the tool tip by [f N; m N m] on it, in W, the motors locked.  (6, 6)."""
        return vibration.tool_compliance(self, x, wrench)

    def static_stiffness(self, x, direction=None, wrench=None) -> Any:
        """Stiffness at the tool tip with the motors locked, at rest at the pose x (d,), N/m.

        Along `direction` (3,) in W: a force there by what the tip gives way along it; along x, y and z (3,) without.
        inf where nothing gives way.
        """
        ways = np.eye(3)
        if direction is not None:
            way = column(direction, 3, "direction")
            if way.ndim != 1 or not way.any():
                raise ExperimentError(
                    "a direction has three numbers, not all 0", key="direction", value=brief(direction)
                )
            ways = way[None] / np.linalg.norm(way)
        C = self.tool_compliance(x, wrench)[:3, :3]
        with np.errstate(divide="ignore"):
            found = 1 / np.einsum("ki,ij,kj->k", ways, C, ways)
        return found if direction is None else float(found[0])

    def modes(self, x, held: bool = True, wrench=None) -> vibration.Modes:
        """Natural frequencies, damping and shapes at rest at the pose x (d,); the motors locked, or free."""
        return vibration.modes(self, x, held, wrench)

    def frequency_response(self, x, frequencies, source: str = "motor", to: str = "tool", wrench=None) -> np.ndarray:
        """Answer to unit forces at rest at the pose x (d,); see `vibration.frequency_response`."""
        return vibration.frequency_response(self, x, frequencies, source, to, wrench)

    # -- the rigid machine's answers ------------------------------------------------------------------------------

    @property
    def arrays(self):
        """Row functions of the rigid machine: kinematics of the nominal geometry."""
        return self.rigid.arrays

    def inverse_kinematics(self, x) -> np.ndarray:
        """Joint coordinates of poses of the rigid machine."""
        return self.rigid.inverse_kinematics(x)

    def forward_kinematics(self, q, near=None, on_fail: str = "raise"):
        """Poses of the rigid machine."""
        return self.rigid.forward_kinematics(q, near, on_fail)

    def jacobian(self, x) -> np.ndarray:
        """J of the rigid machine, q' = J xd."""
        return self.rigid.jacobian(x)

    def tool_pose(self, x) -> np.ndarray:
        """x y z a b c of T in W where nothing bends."""
        return self.rigid.tool_pose(x)

    @property
    def program_zero(self) -> np.ndarray:
        """As of the rigid machine."""
        return self.rigid.program_zero

    def task_motion(self, x, xd, xdd):
        """As of the rigid machine."""
        return self.rigid.task_motion(x, xd, xdd)

    def flexible(self, measured: str = "motor", stiffness: float = 1.0) -> Machine:
        """The same of the rigid machine."""
        return self.rigid.flexible(measured, stiffness)

    def _not_here(self, *_args, **_options):
        raise ExperimentError(
            "a flexible machine has more freedoms than joints: this is asked of the rigid one", cure="use .rigid"
        )

    inverse_dynamics = forward_dynamics = mass_matrix = velocity_mass = regressor = parameters_of = _not_here
    joint_motion = velocity_jacobian = _not_here
