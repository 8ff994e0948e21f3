"""Elastic drives: between the motor and the joint of each leg a spring and a damper, of all that gives way there.

    z = (z_r, q_m),   v = (v_r, q_m')           z_r, v_r those of the rigid machine, q_m the motors, at their joints

    s = q_m - q(z_r),   U = sum of s^2 / 2 c(z_r)                                                                   (4)
    f = s / c + d s'                                                                                                (5)
    M_r v_r' + h_r = J_r' f + (dc/dz_r S)' (s / c)^2 / 2 + w,   z_r' = S v_r                                        (6)
    m q_m'' - g = u - friction - f                                                                                  (7)

c and d are those of mechanics/compliance.py, (2), (3), of the elastic joints of a leg in series: what the drive's force
bends on its way to the platform, at this pose.  The second force in (6) is that of a spring whose compliance hangs on
the pose; with it U is a potential.  m is the mass on the motor's side (turning parts of a screw's drive, a carriage), g
its weight along the joint; M_r, h_r are the rest of the machine.

Exact for legs without mass that only push and pull: struts, legs of a hexaglide.  Where a leg has mass, its own modes
and the little it sags across are left out.  What carries forces across the drives (hinges of a 3-PRS) must be rigid.
Friction of a drive acts on its motor.  docs/theory/compliance.md.
"""

from __future__ import annotations

import casadi as ca
import numpy as np

from ..declare import si_numbers
from ..errors import ExperimentError
from ..mechanics.compliance import Springs, in_series
from .base import Machine
from .flexible import FlexibleMachine, check_given, check_options, elastic_joints


def elastic_drives(machine: Machine, measured: str, stiffness: float) -> ElasticDrives:
    """The machine with elastic drives; see `Machine.flexible`."""
    check_given(machine)
    check_options(measured, stiffness)
    _check_masses(machine)
    with si_numbers():
        return ElasticDrives(stiff=machine, springs=springs_of(machine, stiffness), measured=measured)


def _check_masses(machine: Machine) -> None:
    pi = {key: value for key, (value, _) in machine.inertial(machine).items()}
    mass = np.array(ca.evalf(ca.SX(machine.motor_load(machine, pi)[0]))).ravel()
    if not (mass > 0).all():
        raise ExperimentError(
            "an elastic drive needs mass on its motor's side of the spring", key="drive.inertia",
            value=f"{mass.min():g} kg at {machine.joint_names[int(mass.argmin())]}",
            cure="give drive.inertia (a screw), or use a machine whose motors are heavy",
        )  # fmt: skip


def springs_of(machine: Machine, stiffness: float = 1.0) -> Springs:
    """The elastic joints of [[compliance]] as numbers, every one `stiffness` times as stiff.

    Joints that give way alike in all directions and carry no moment meet a force as long as the leg's, whatever its
    direction: they are compliance along the leg.

    Raises
    ------
    ExperimentError
        a drive that nothing makes elastic.
    """
    n = machine.joints_count
    constant, leg, full, centers = np.zeros((2, n)), np.zeros((2, n)), {}, {}
    ratio = hasattr(machine, "leg_ratio")
    for place, number, entry, _ in elastic_joints(machine):
        if machine.elastic_places[place] == "axial":
            target = leg if ratio and place != "drive" else constant
            target[:, number] += np.array(entry.along()) / stiffness
            continue
        C, E = (part / stiffness for part in entry.matrices())
        if entry.center is None and _alike(C) and _alike(E) and place != "guide":
            (leg if ratio else constant)[:, number] += C[0, 0], E[0, 0]
            continue
        full.setdefault(place, np.zeros((2, n, 36)))[:, number] = C.ravel(), E.ravel()
        centers.setdefault(place, np.zeros((n, 3)))[number] = 0 if entry.center is None else entry.center
    _check_all_elastic(machine, constant + leg, full)
    places = tuple(full)
    tables = np.concatenate([full[place] for place in places], 1) if places else None
    center = np.concatenate([centers[place] for place in places]) if places else None
    return Springs(
        constant=constant[0], constant_loss=_some(constant[1]),
        leg=_some(leg[0]), leg_loss=_some(leg[1]), places=places,
        full=None if tables is None else tables[0], full_loss=None if tables is None else _some(tables[1]),
        center=None if center is None else _some(center),
    )  # fmt: skip


def _alike(C: np.ndarray) -> bool:
    return np.allclose(C[:3, :3], C[0, 0] * np.eye(3), rtol=1e-12, atol=0) and not C[:3, 3:].any()


def _some(values: np.ndarray) -> np.ndarray | None:
    return values if values.any() else None


def _check_all_elastic(machine, along, full) -> None:
    soft = along[0] > 0
    for table in full.values():
        soft = soft | table[0].any(-1)
    if not soft.all():
        stiff = ", ".join(name for name, one in zip(machine.joint_names, soft, strict=True) if not one)
        raise ExperimentError(
            "every drive needs an elastic joint on its way to the platform", key="compliance", value=f"none of {stiff}",
            cure="name all of a sort, as in joint = \"drives\"; a stiff one gets a large stiffness",
        )  # fmt: skip


class ElasticDrives(FlexibleMachine):
    """A machine `stiff` with springs at its drives; its numbers are those of that machine and of the springs."""

    springs: Springs

    # -- coordinates ----------------------------------------------------------------------------------------------

    @property
    def velocities(self) -> tuple[str, ...]:
        """Those of the rigid machine, then the motors'."""
        return (*self.stiff.velocities, *(f"motor of {name}" for name in self.stiff.joint_names))

    @property
    def coordinate_count(self) -> int:
        """Coordinates of the rigid machine and one a motor."""
        return self.stiff.coordinate_count + self.joints_count

    def _parts(self, z):
        """z_r, q_m."""
        k = self.stiff.coordinate_count
        return z[:k], z[k:]

    def _rates(self, v):
        """v_r, q_m'."""
        k = len(self.stiff.velocities)
        return v[:k], v[k:]

    def coordinates_of(self, p, x):
        """z of a pose with no spring bent."""
        z = self.stiff.coordinates_of(p.stiff, x)
        return ca.vertcat(z, self.stiff.joints_of(p.stiff, z))

    def coordinates(self, x) -> np.ndarray:
        """z of poses with no spring bent.  (..., d) -> (..., len(z))."""
        return np.concatenate([self.stiff.coordinates(x), self.stiff.inverse_kinematics(x)], -1)

    def rate(self, p, z, v):
        """z' = (z_r', q_m')."""
        (z_r, _), (v_r, w) = self._parts(z), self._rates(v)
        return ca.vertcat(self.stiff.rate(p.stiff, z_r, v_r), w)

    def normalised(self, p, z):
        """z with z_r back on its manifold."""
        z_r, q = self._parts(z)
        return ca.vertcat(self.stiff.normalised(p.stiff, z_r), q)

    def joints_of(self, p, z):
        """q_m: what the drives move.  (n,)."""
        return self._parts(z)[1]

    def measured_of(self, p, z):
        """What the encoders are on: the motors, or the joints behind the springs.  (n,)."""
        z_r, q = self._parts(z)
        return q if self.measured == "motor" else self.stiff.joints_of(p.stiff, z_r)

    def jacobian_of(self, p, z):
        """q_m' = [0 1] v.  (n, len(v))."""
        return ca.horzcat(ca.SX(self.joints_count, len(self.stiff.velocities)), ca.SX.eye(self.joints_count))

    def tool_pose_of(self, p, z):
        return self.stiff.tool_pose_of(p.stiff, self._parts(z)[0])

    def task_of(self, p, z):
        return self.stiff.task_of(p.stiff, self._parts(z)[0])

    def task_rate_of(self, p, z, v):
        return self.stiff.task_rate_of(p.stiff, self._parts(z)[0], self._rates(v)[0])

    def wrench_of(self, p, z, w):
        return ca.vertcat(self.stiff.wrench_of(p.stiff, self._parts(z)[0], w), ca.SX(self.joints_count, 1))

    def home_rotation(self, p):
        return self.stiff.home_rotation(p.stiff)

    def determinant_of(self, p, z):
        return self.stiff.determinant_of(p.stiff, self._parts(z)[0])

    def margins(self, p, z):
        """Those of the rigid machine, where the platform really is."""
        return self.stiff.margins(p.stiff, self._parts(z)[0])

    def limit_told(self, index, margin):
        return self.stiff.limit_told(index, margin)

    # -- dynamics -------------------------------------------------------------------------------------------------

    def inertial(self, p):
        """The parameters of the rigid machine."""
        return self.stiff.inertial(p.stiff)

    def in_series(self, p, z_r):
        """c and the loss of every leg, mechanics/compliance.py, (2), (3)."""
        ratio = self.stiff.leg_ratio(p.stiff, z_r) if self.springs.leg is not None else None
        return in_series(self.springs, p.springs, ratio, lambda place: self.stiff.carried_by(place, p.stiff, z_r))

    def drive_forces(self, p, z, v):
        """f of eq. (5), and the part s / c of it.  (n,), (n,) N."""
        (z_r, q), (v_r, w) = self._parts(z), self._rates(v)
        c, loss = self.in_series(p, z_r)
        elastic = (q - self.stiff.joints_of(p.stiff, z_r)) / c
        if loss is None:
            return elastic, elastic
        slip = w - self.stiff.jacobian_of(p.stiff, z_r) @ v_r
        return elastic + loss / (c * c) * slip, elastic

    def mass_and_bias(self, p, pi, z, v):
        """M and h of eqs. (6), (7): M v' + h = J' (u - friction) + w."""
        (z_r, _), (v_r, _) = self._parts(z), self._rates(v)
        mass, weight, rest = self.stiff.motor_load(p.stiff, pi)
        M, h = self.stiff.mass_and_bias(p.stiff, rest, z_r, v_r)
        f, elastic = self.drive_forces(p, z, v)
        h = h - self.stiff.jacobian_of(p.stiff, z_r).T @ f - self._follow(p, z_r, v_r, elastic)
        return ca.diagcat(M, ca.diag(mass)), ca.vertcat(h, f - weight)

    def _follow(self, p, z_r, v_r, elastic):
        """(dc/dz_r S)' (s / c)^2 / 2 of eq. (6).  (len(v_r),)."""
        z = ca.SX.sym("z", z_r.shape)
        slope = ca.jacobian(self.in_series(p, z).compliance, z)
        if slope.nnz() == 0:
            return ca.SX(*v_r.shape)
        v = ca.SX.sym("v", v_r.shape)
        S = ca.jacobian(self.stiff.rate(p.stiff, z, v), v)
        turned = ca.substitute(ca.densify((slope @ S).T), z, ca.densify(ca.SX(z_r)))
        return turned @ (elastic * elastic) / 2

    def inverse_force(self, p, pi, z, v, vd):
        """M v' + h, on v."""
        M, h = self.mass_and_bias(p, pi, z, v)
        return M @ vd + h

    def elastic_energy(self, p, z):
        """U of eq. (4), J."""
        z_r, q = self._parts(z)
        s = q - self.stiff.joints_of(p.stiff, z_r)
        return ca.sum1(s * s / self.in_series(p, z_r).compliance) / 2

    # -- friction that scales with forces in the joints -----------------------------------------------------------

    @property
    def load_count(self) -> int:
        """As of the rigid machine."""
        return self.stiff.load_count

    def loads_of(self, p, z, v, vd, memory, u):
        """The forces in the joints that make friction: those of legs that carry what their springs carry."""
        (z_r, _), (v_r, _), (a_r, _) = self._parts(z), self._rates(v), self._rates(vd)
        pi = {key: value for key, (value, _) in self.inertial(p).items()}
        rest = self.stiff.motor_load(p.stiff, pi)[2]
        return self.stiff.loads_carried(p.stiff, rest, z_r, v_r, a_r, self.drive_forces(p, z, v)[0])

    def joint_friction(self, p, z, v, loads):
        found = self.stiff.joint_friction(p.stiff, self._parts(z)[0], self._rates(v)[0], loads)
        return ca.vertcat(found, ca.SX(self.joints_count, 1))
