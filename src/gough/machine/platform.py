"""What all machines share that carry one free platform with the tool on it, whatever drives them.

Coordinates z = [p_WT (3), quaternion of R_WT (4)], velocities V = V_WT = [v; w], both in W, frames as in hexapod.py.
The platform is one rigid body with joints B at p_TB; a kind adds what hangs on these joints.
"""

from __future__ import annotations

from typing import Any, ClassVar

import casadi as ca
import numpy as np
from pydantic import model_validator

from .. import frames
from ..errors import InputError
from ..mechanics import bodies
from ..mechanics.linear import determinant_6
from .base import Machine

SINGULAR = "near a singularity: det J against home"
_CONE = "joint beyond its cone"


class PlatformMachine(Machine):
    """Six joints hold a platform in all its freedoms.  A kind has the fields platform, joints, tool, limits, home."""

    task: ClassVar = (("x", "m"), ("y", "m"), ("z", "m"), ("a", "rad"), ("b", "rad"), ("c", "rad"))
    velocities: ClassVar = tuple(f"{name}_WT" for name in ("vx", "vy", "vz", "wx", "wy", "wz"))

    @model_validator(mode="before")
    @classmethod
    def _home_table(cls, data: Any) -> Any:
        """A sheet writes the pose at rest as a table, [home] pose = [...]."""
        if isinstance(data, dict) and isinstance(data.get("home"), dict):
            if set(data["home"]) != {"pose"}:
                raise InputError("[home] has one key, pose", key="home", value=", ".join(map(str, data["home"])))
            data = {**data, "home": data["home"]["pose"]}
        return data

    def _check_friction(self) -> None:
        """Refuse friction with another number of values than one, or one a joint."""
        for key in () if self.friction is None else self.friction.specs():
            numbers = getattr(self.friction, key)
            if np.ndim(numbers) and len(numbers) != 6:
                raise InputError("friction needs one value or six", key=f"friction.{key}", value=str(len(numbers)))

    # -- coordinates ----------------------------------------------------------------------------------------------

    coordinate_count: ClassVar = 7

    @staticmethod
    def coordinates_of(p, x):
        """z of a pose x y z a b c.  (6,) -> (7,)."""
        return ca.vertcat(x[:3], frames.quaternion_of_abc(x[3:]))

    @staticmethod
    def tool_pose_of(p, z):
        """Position and quaternion of T in W.  (7,) -> (3,), (4,)."""
        return z[:3], z[3:]

    @staticmethod
    def home_rotation(p):
        """R_WT at home.  (3, 3)."""
        return frames.rotation_of_abc(p.home[3:])

    @staticmethod
    def standing(x) -> np.ndarray:
        """z of poses, in NumPy; NaN where a machine has none.  (..., 6) -> (..., 7)."""
        return np.concatenate([x[..., :3], frames.quaternion_of_abc_np(x[..., 3:])], -1)

    @staticmethod
    def task_of(p, z):
        """x y z a b c of T in W.  (7,) -> (6,)."""
        return ca.vertcat(z[:3], frames.abc_of_rotation(frames.rotation_of_quaternion(z[3:])))

    @staticmethod
    def rate(p, z, v):
        """z' of coordinates (7,) and twist (6,).  (7,)."""
        return ca.vertcat(v[:3], frames.quaternion_rate(z[3:], v[3:]))

    @staticmethod
    def normalised(p, z):
        """z with its quaternion of unit length again.  (7,)."""
        return ca.vertcat(z[:3], z[3:] / ca.norm_2(z[3:]))

    @staticmethod
    def stepped(z, d):
        """z moved by a small twist d = [dp; rotation vector in W]: a step on SO(3), not on angles.  (7,)."""
        return ca.vertcat(z[:3] + d[:3], frames.quaternion_product(frames.quaternion_of_rotation_vector(d[3:]), z[3:]))

    @staticmethod
    def between(z_before, z):
        """The mean twist that leads from coordinates z_before to z in a second.  (6,)."""
        turn = frames.rotation_vector_of_quaternion(frames.quaternion_product(z[3:], frames.conjugate(z_before[3:])))
        return ca.vertcat(z[:3] - z_before[:3], turn)

    @staticmethod
    def target(p, r, z):
        """[p_r - p; log(R_r R')] (6,) m and rad of a reference r and coordinates z, its twist and the rate of that."""
        turn = frames.quaternion_product(frames.quaternion_of_abc(r.x[3:]), frames.conjugate(z[3:]))
        e = ca.vertcat(r.x[:3] - z[:3], frames.rotation_vector_of_quaternion(turn))
        return e, r.xd, r.xdd

    @staticmethod
    def bracket(v, w):
        """[v, w] of twists in axes of W: translations commute, turnings do not.  (6,)."""
        return ca.vertcat(ca.SX(3, 1), ca.cross(w[3:], v[3:]))

    # -- the platform ---------------------------------------------------------------------------------------------

    @staticmethod
    def platform_joints(p):
        """p_TB, in T.  (3, 6)."""
        if p.tool is None:
            return p.joints.platform.T
        R_TP = frames.rotation_of_abc(p.tool.angles).T
        return R_TP @ (p.joints.platform.T - ca.repmat(p.tool.position, 1, 6))

    def platform_joints_np(self) -> np.ndarray:
        """p_TB as numbers.  (6, 3)."""
        return self.joints.platform if self.tool is None else np.array(ca.DM(self.platform_joints(self))).T

    @staticmethod
    def platform_inertial(p):
        """The platform's part of `inertial`: m, m c and I about the origin of T, in T.  {name: (SX, unit)}."""
        m, mc, I = bodies.first_moments(p.platform)
        if p.tool is not None:  # from P to T
            R_TP = frames.rotation_of_abc(p.tool.angles).T
            shifted = mc - m * p.tool.position
            S, Sc = bodies.skew(p.tool.position), bodies.skew(mc)
            I = R_TP @ (I + Sc @ S + S @ Sc - m * S @ S) @ R_TP.T
            mc = R_TP @ shifted
        return bodies.named("platform", m, mc, I)

    @staticmethod
    def _platform_in_W(pi, R):
        """m, m c (3,) and I (3, 3) of the platform about the origin of T, in axes of W."""
        return bodies.turned("platform", pi, R)

    # -- limits ---------------------------------------------------------------------------------------------------

    def determinant_of(self, p, z):
        """det J as a fraction of home's; 0 at a singular pose, negative in another assembly mode."""
        home = self.coordinates_of(p, p.home)
        return determinant_6(self.jacobian_of(p, z)) / determinant_6(self.jacobian_of(p, home))

    @staticmethod
    def cone_margins(p, names, ends, z, home, n, n_home):
        """Names and values of how far joints are inside limits.cone; n, n_home (3, 6) along the legs, in W.

        `ends` names the joint that stands in W and the one in T.
        """
        if p.limits.cone is None:
            return [], []
        R, R_home = (frames.rotation_of_quaternion(y[3:]) for y in (z, home))
        least = ca.cos(p.limits.cone)
        told = [f"{name}: {end} {_CONE}" for end in ends for name in names]
        return told, [ca.sum1(n * n_home).T - least, ca.sum1((R.T @ n) * (R_home.T @ n_home)).T - least]

    def singular_margin(self, p, z):
        """Name and value of what is left of det J, in lists of one."""
        return [SINGULAR], [self.determinant_of(p, z) - p.limits.determinant]

    def limit_told(self, index: int, margin: float) -> tuple[str, str, str]:
        """Rule, value and limit in words, where `margins` is `margin` < 0 at `index`.  A kind tells what is its own."""
        limits, name = self.limits, self.limit_names[index]
        if name == SINGULAR:
            return name, f"{limits.determinant + margin:.3g} of it", f"{limits.determinant:g}"
        cosine = np.cos(limits.cone) + margin
        angle = np.degrees(np.arctan2(np.sqrt(max(0.0, 1 - cosine * cosine)), cosine))
        return name, f"{angle:.4g} deg", f"{np.degrees(limits.cone):g} deg"


def outline(points) -> list:
    """A closed polyline through points (6, 3), in their order around the middle."""
    d = points - points.mean(0)
    _, _, axes = np.linalg.svd(d)  # the first two span the plane of the points
    order = np.argsort(np.arctan2(d @ axes[1], d @ axes[0]))
    return points[[*order, order[0]]].tolist()


def columns(function, A, B):
    """`function` of the columns of A and B, side by side."""
    return ca.horzcat(*[function(A[:, i], B[:, i]) for i in range(A.shape[1])])
