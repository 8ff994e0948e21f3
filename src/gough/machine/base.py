"""What every machine is: a Part with equations of motion on independent velocities.

    coordinates z, velocities v, z' = rate(z, v);  joints q(z), q' = J v;  tool pose;
    M(z) v' + h(z, v) = J' (u - friction) + w                                                                    (1)

with w the wrench on the tool, [f; m] at the tip in W.  Everything is written once, as functions of a view `p` of the
machine (its numbers as entries of theta) and of `pi`, the inertial parameters in which (1) is linear; NumPy comes in
and goes out through `arrays.Arrays`.
"""

from __future__ import annotations

from functools import cached_property
from typing import Any, ClassVar, NamedTuple

import casadi as ca
import numpy as np
from pydantic import Field, model_validator

from ..declare import Array, Part, quantity
from ..errors import SheetError
from ..frames import rotation_of_abc_np
from ..mechanics.compliance import Compliance
from ..mechanics.linear import solve_square
from . import forward
from .arrays import Arrays, check_determinant, column


class Feed(Part):
    """What the axes of the tool are driven at when a program does not say."""

    input_error = SheetError

    rapid: float = quantity("m/s", "speed of rapids (G0)", default=0.2, above=0)
    acceleration: float = quantity("m/s2", "acceleration along the path", default=2.0, above=0)
    jerk: float | None = quantity(
        "m/s3", "jerk along the path, for jerk-limited programs", default=None, theta=False, above=0
    )
    angular_rate: float = quantity("rad/s", "greatest rate of the tool axis", default=0.5, above=0)
    angular_acceleration: float = quantity("rad/s2", "greatest angular acceleration", default=5.0, above=0)


class Parameters(NamedTuple):
    """The parameters in which the dynamics are linear."""

    names: tuple[str, ...]
    values: Array
    units: tuple[str, ...]


class Machine(Part):
    """Base of all machines.  A kind fills in the equations below; views and arrays come from here."""

    input_error = SheetError
    task: ClassVar[tuple[tuple[str, str], ...]]  # (name, unit) of each task coordinate

    # -- what a kind states (symbolic; p a view of the machine) ---------------------------------------------------
    #   joint_names, task, velocities
    #   coordinate_count                 how many entries z has
    #   coordinates_of(p, x)             task coordinates -> z, SX
    #   tool_pose_of(p, z)               z -> position (3,), quaternion (4,) of T in W
    #   task_of(p, z)                    z -> task coordinates, angles within a turn
    #   rate(p, z, v), normalised(p, z)  z', and z pulled back to its manifold
    #   stepped(z, d), between(z_, z)    z moved by a small step d, and the velocities that lead from z_ to z in 1 s
    #   target(p, r, z)                  what the velocities v should be: error, V_r and V_r' of a reference
    #   joints(p, z)                     q
    #   jacobian_of(p, z)                J, q' = J v
    #   newton_step(p, z, q)             d of a Newton step towards q (default: J d = q - q(z))
    #   stride_of(p)                     m, the longest such step
    #   possible(q)                      which rows of joint coordinates some pose may have, and why not the others
    #   joint_acceleration(p, z, v, vd)  q''
    #   inertial(p)                      pi as {name: SX}, in which the next is linear
    #   inverse_force(p, pi, z, v, vd)   M v' + h, on v
    #   mass_and_bias(p, pi, z, v)       M, h
    #   margins(p, z)                    (names, SX): all >= 0 inside the limits, the last one that of det J
    #   limit_told(index, margin)        rule, value and limit of one that is not, in words
    #   unreachable(x)                   first row of poses that no joint coordinates have, and its error
    # and where friction scales with forces in the joints (load_count > 0)
    #   loads_of(p, z, v, vd, memory, u) those forces
    #   joint_friction(p, z, v, loads)   what passive joints' friction adds to J' (u - friction), on v
    #   friction_load(p, pi, z, v, vd)   the normal forces alone, of a motion
    # and where v is not z' itself (a twist)
    #   bracket(v, w)                    [v, w] of the velocities' frame
    # and where v is not the task rate xd, or z not the pose of the tool (pose_is_state = False)
    #   velocity_of(p, z, xd), acceleration_of(p, z, v, xdd)       v and v' of a motion of the task coordinates
    #   task_rate_of(p, z, v), task_acceleration_of(p, z, v, vd)   and back
    #   wrench_of(p, z, w)               what a wrench w on the tool does on v
    #   closure_of(p, z)                 what must be zero, m
    # adaptable                          numbers of the sheet that an adaptive law learns, "a + b" by one factor
    # and where its joints may give way (compliance.md)
    #   elastic_places                   {sort of joint: "axial", "full" or "spring"}; rigid_places {sort: why not}
    #   leg_ratio(p, z)                  force along each leg by its drive's
    #   carried_by(place, p, z)          force at that joint per newton of each drive, and what the drive takes of it
    #   motor_load(p, pi)                mass and weight on each motor's own side, and pi without them

    compliance: list[Compliance] | None = Field(None, max_length=100, description="joints that give way")
    elastic_places: ClassVar[dict[str, str]] = {}
    rigid_places: ClassVar[dict[str, str]] = {}

    @model_validator(mode="after")
    def _elastic(self):
        if self.compliance:
            from .flexible import check_names

            check_names(self)
        return self

    def elastic_numbers(self, place: str) -> tuple[int, ...]:
        """The numbers by which joints of a sort of `elastic_places` are told."""
        return tuple(range(1, self.joints_count + 1))

    def flexible(self, measured: str = "motor", stiffness: float = 1.0) -> Machine:
        """This machine with the joints of [[compliance]] elastic, all of them `stiffness` times as stiff as it says.

        For the plant: laws go on believing this one.  `measured`: encoders read the "motor", or the "joint" behind its
        springs, as a direct scale does.

        Raises
        ------
        ExperimentError
            without [[compliance]], a drive without mass, a drive that nothing makes elastic.
        """
        from .elastic_drives import elastic_drives

        return elastic_drives(self, measured, stiffness)

    @property
    def rigid(self) -> Machine:
        """The machine as laws believe it: without elastic joints."""
        return self

    def at_rest(self, x, wrench=None) -> tuple[np.ndarray, np.ndarray]:
        """z and the joint forces (n,) N of standing at the pose x (d,) under a wrench (6,) on the tool.

        Raises
        ------
        WorkspaceError, SingularityError
            the machine cannot stand there.
        """
        still = np.zeros(len(self.task))
        return self.standing(np.asarray(x, float)), self.inverse_dynamics(x, still, still, wrench)

    def with_perfect_drives(self) -> Machine:
        """This machine without limits of its drives, and encoders without steps and noise."""
        return self.replace(drive=self.drive.perfect())

    def measured_of(self, p, z):
        """What the encoders are on: q.  (n,)."""
        return self.joints_of(p, z)

    @cached_property
    def symbols(self) -> tuple[Any, Any]:
        """(view, theta): this machine on a fresh symbolic theta."""
        theta = ca.SX.sym("theta", len(self.theta))
        return self.at(theta), theta

    @cached_property
    def arrays(self) -> Arrays:
        """The row functions behind the methods below."""
        return Arrays(self)

    @cached_property
    def limit_names(self) -> tuple[str, ...]:
        """What each value of `margins` says when it is negative."""
        p, _ = self.symbols
        return self.margins(p, self.coordinates_of(p, p.home))[0]

    @property
    def joints_count(self) -> int:
        """How many actuated joints, n."""
        return len(self.joint_names)

    @property
    def memory_count(self) -> int:
        """How many numbers the friction of all joints remembers."""
        return self.joints_count * (self.friction.memory_per_joint if self.friction else 0)

    def newton_system(self, p, z, q):
        """K (n, n) and r (n,) of a Newton step K d = r from coordinates z towards joint coordinates q."""
        return self.jacobian_of(p, z), q - self.joints_of(p, z)

    def newton_step(self, p, z, q):
        """d of a Newton step from coordinates z towards joint coordinates q, for `stepped`."""
        return solve_square(*self.newton_system(p, z, q))

    def unreachable(self, x) -> tuple[int, Exception] | None:
        """The first of the poses x (N, d) that no joint coordinates have, and the error that says so."""
        return None

    # -- tool and velocities: where z is the pose of the tool and v its task rate ---------------------------------

    pose_is_state: ClassVar[bool] = True

    @property
    def program_zero(self) -> np.ndarray:
        """Pose of program zero in W where a program does not say, (6,)."""
        return self.home

    @staticmethod
    def task_motion(x, xd, xdd):
        """Of poses, twists and their rates (..., 6) of T: task coordinates and their rates, (..., d) each."""
        return x, xd, xdd

    @staticmethod
    def velocity_of(p, z, xd):
        """v of a task rate."""
        return xd

    @staticmethod
    def acceleration_of(p, z, v, xdd):
        """v' of the rate of a task rate."""
        return xdd

    @staticmethod
    def task_rate_of(p, z, v):
        """The task rate of velocities v."""
        return v

    @staticmethod
    def task_acceleration_of(p, z, v, vd):
        """The rate of the task rate of v and v'."""
        return vd

    @staticmethod
    def wrench_of(p, z, w):
        """What a wrench w (6,) [f; m] on the tool tip, in W, does on v."""
        return w

    @staticmethod
    def closure_of(p, z):
        """What must be zero where coordinates depend on each other, m; (0,) where none do."""
        return ca.SX(0, 1)

    def task_jacobian_of(self, p, z):
        """J with q' = J xd.  (n, d)."""
        return self.jacobian_of(p, z)

    # -- friction -------------------------------------------------------------------------------------------------

    def frictionless(self) -> Machine:
        """This machine without friction anywhere."""
        return self.replace(friction=None)

    @property
    def load_count(self) -> int:
        """How many forces in the joints friction asks for; see `loads_of`."""
        return 0

    def strut_friction(self, p, qd, memory, loads=None):
        """Friction of the joints against their speed qd (n,), at the first n of `loads` where it scales.  (n,) N."""
        if self.friction is None:
            return ca.SX.zeros(qd.shape)
        if self.friction.loaded:
            return self.friction.force(p.friction, qd, memory, loads[: self.joints_count])
        return self.friction.force(p.friction, qd, memory)

    def memory_advanced(self, p, qd, memory, h, loads=None):
        """The friction's memory after h seconds with speeds qd (n,) and loads held."""
        load = loads[: self.joints_count] if self.friction.loaded else None
        return self.friction.advance(p.friction, qd, memory, h, load)

    def memory_rate(self, p, qd, memory, loads=None):
        """Rate of the friction's memory at speeds qd (n,)."""
        load = loads[: self.joints_count] if self.friction.loaded else None
        return self.friction.memory_rate(p.friction, qd, memory, load)

    def friction_load(self, p, pi, z, v, vd):
        """The normal forces that scale the joints' friction on a motion, (n,) N; None where nothing scales it."""
        return

    # -- what adaptive laws need ----------------------------------------------------------------------------------

    adaptable: ClassVar[tuple[str, ...]] = ()

    def drag(self, p):
        """Viscous friction of the drives that no load scales and that counts as their own, N s/m: one, or (n,)."""
        law = p.friction
        return law.viscous_offset if self.friction is not None and self.friction.loaded else 0

    @staticmethod
    def bracket(v, w):
        """[v, w] of the frame in which velocities are given: 0 where v = z' of independent coordinates."""
        return ca.SX(*v.shape)

    def passive_force(self, p, pi, z, v, v_r, vd_r):
        """M v_r' + C(v) v_r + g with M' - 2 C(v) skew, on v: inverse dynamics in two velocities.  (len(v),).

        C is that of the Levi-Civita connection of M, from two calls of h; docs/theory/sliding.md, eqs. (3)-(6).
        """
        turned = vd_r + self.bracket(v, v_r) / 2
        rest = ca.SX(*v.shape)
        mean = self.inverse_force(p, pi, z, (v + v_r) / 2, turned)
        half = self.inverse_force(p, pi, z, (v - v_r) / 2, rest)
        return mean - (half - self.inverse_force(p, pi, z, rest, rest))

    def carrying(self, mass: float, center) -> Machine:
        """This machine with a point mass (kg) on what carries the tool, at `center` (3,) m of T."""
        center, tool = np.asarray(center, float), getattr(self, "tool", None)
        if tool is not None:  # the platform's numbers are in P
            center = tool.position + rotation_of_abc_np(tool.angles) @ center
        return self.replace(platform=self.platform.joined(mass, center))

    # -- arrays ---------------------------------------------------------------------------------------------------

    def coordinates(self, x) -> np.ndarray:
        """z of poses.  (..., d) -> (..., len(z))."""
        return self.arrays.run("coordinates", column(x, len(self.task), "pose"))[0]

    def inverse_kinematics(self, x) -> np.ndarray:
        """Joint coordinates of poses.  (..., d) -> (..., n).  One answer or none; limits are not checked here.

        Raises
        ------
        WorkspaceError
            no joint coordinates have this pose: which leg cannot reach, and by how much.
        """
        return self.arrays.run("inverse_kinematics", column(x, len(self.task), "pose"))[0]

    def forward_kinematics(self, q, near=None, on_fail: str = "raise"):
        """Poses of joint coordinates, each sought from `near` (default: home).  (..., n) -> (..., d).

        A pose is returned only when its residual is below 1e-10 m, it is inside the limits and the workspace, and
        det J has the sign it has at home.  `on_fail="nan"` returns (poses, status) instead of raising: rows of NaN
        with a status other than 0, see `forward.STATUS`.

        Raises
        ------
        KinematicsError
            joint coordinates that no pose has, no convergence, another assembly mode; index of the first such row.
        WorkspaceError
            the pose found is outside the limits or the workspace.
        """
        return forward.forward_kinematics(self, q, near, on_fail)

    def jacobian(self, x) -> np.ndarray:
        """J with q' = J xd.  (..., d) -> (..., n, d)."""
        x = column(x, len(self.task), "pose")
        return self.arrays.run("jacobian", x)[0].reshape(x.shape[:-1] + (self.joints_count, len(self.task)))

    def velocity_jacobian(self, x) -> np.ndarray:
        """J with q' = J v, v the machine's own velocities.  (..., d) -> (..., n, len(v))."""
        if self.pose_is_state:
            return self.jacobian(x)
        x = column(x, len(self.task), "pose")
        shape = x.shape[:-1] + (self.joints_count, len(self.velocities))
        return self.arrays.run("velocity_jacobian", x)[0].reshape(shape)

    def joint_motion(self, x, xd, xdd, on_fail: str = "raise") -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """q, q', q'' of a motion x, xd, xdd.  Each (..., d) -> (..., n).

        Poses that no joint coordinates have raise WorkspaceError; with `on_fail="nan"` their rows are NaN.
        """
        columns = self._columns(x, xd, xdd)
        return tuple(self.arrays.run("joint_motion", *columns, checked=on_fail != "nan"))

    def inverse_dynamics(self, x, xd, xdd, wrench=None) -> np.ndarray:
        """Joint forces of a motion, without friction.  (..., d) each -> (..., n) N.

        `wrench` (..., 6) [f; m] acts on the tool at its tip, in W.

        Raises
        ------
        SingularityError
            where det J has fallen below limits.determinant of home's.
        """
        u, ratio = self.arrays.run("inverse_dynamics", *self._columns(x, xd, xdd), self._wrench(wrench))
        check_determinant(ratio, self.limits.determinant)
        return u

    def forward_dynamics(self, x, xd, u, wrench=None) -> np.ndarray:
        """xdd of joint forces u, without friction.  (..., d), (..., d), (..., n) -> (..., d)."""
        d = len(self.task)
        u = column(u, self.joints_count, "joint forces")
        return self.arrays.run(
            "forward_dynamics", column(x, d, "pose"), column(xd, d, "rate"), u, self._wrench(wrench)
        )[0]

    def mass_matrix(self, x) -> np.ndarray:
        """M on the task rate.  (..., d) -> (..., d, d)."""
        x = column(x, len(self.task), "pose")
        d = len(self.task)
        return self.arrays.run("mass", x, np.zeros(d))[0].reshape(x.shape[:-1] + (d, d))

    def velocity_mass(self, x) -> np.ndarray:
        """M on the machine's own velocities v.  (..., d) -> (..., len(v), len(v))."""
        M = self.mass_matrix(x)
        if self.pose_is_state:
            return M
        rate = np.linalg.solve(self.jacobian(x), self.velocity_jacobian(x))  # xd = rate v
        return np.swapaxes(rate, -1, -2) @ M @ rate

    def regressor(self, x, xd, xdd, friction: bool = False) -> np.ndarray:
        """Y with u = Y @ parameters.values.  (..., d) each -> (..., n, p).

        With `friction`, the columns of Coulomb and viscous friction of each joint follow; values of both by
        `parameters_of(friction=True)`.
        """
        flat, ratio, qd = self.arrays.run("regressor", *self._columns(x, xd, xdd))
        check_determinant(ratio, self.limits.determinant)
        n = self.joints_count
        Y = flat.reshape(flat.shape[:-1] + (n, -1))
        if friction:
            eye = np.eye(n)
            Y = np.concatenate([Y, eye * np.sign(qd)[..., None, :], eye * qd[..., None, :]], -1)
        return Y

    @property
    def parameters(self) -> Parameters:
        """What `regressor` is linear in: names, values, units."""
        return self.parameters_of()

    def parameters_of(self, friction: bool = False) -> Parameters:
        """`parameters`, with `friction` also those of the joints; what scales with a load is not among them."""
        found = self.inertial(self)
        names, units = list(found), [unit for _, unit in found.values()]
        values = [float(ca.evalf(ca.SX(value))) for value, _ in found.values()]
        if friction:
            constant = self.friction.unloaded if self.friction else (0.0, 0.0)
            for key, unit, value in zip(("coulomb", "viscous"), ("N", "N s/m"), constant, strict=True):
                names += [f"friction.{key}[{i}]" for i in range(self.joints_count)]
                units += [unit] * self.joints_count
                values += list(np.broadcast_to(value, self.joints_count))
        return Parameters(tuple(names), np.array(values), tuple(units))

    def tool_pose(self, x) -> np.ndarray:
        """x y z a b c of T in W.  (..., d) -> (..., 6)."""
        return column(x, len(self.task), "pose")

    def _columns(self, *values):
        return [
            column(value, len(self.task), name)
            for value, name in zip(values, ("pose", "rate", "acceleration"), strict=True)
        ]

    def _wrench(self, wrench):
        return np.zeros(6) if wrench is None else column(wrench, 6, "wrench")
