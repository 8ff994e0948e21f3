"""What a machine at rest loads its joints with, and how friction that scales with it comes back.

Sub-steps hang on both.  The largest forces are those over a spread of poses of the workspace, at rest and with the
acceleration of [feed] along each axis.  All of it is the same for machines that differ in the numbers of friction
only, so it is kept.
"""

from __future__ import annotations

from functools import lru_cache

import casadi as ca
import numpy as np

from ..declare import Shape
from ..kernel.rows import compile_rows
from ..machine.workspace import random_poses
from . import tick

POSES = 30  # of the workspace, for the largest loads; they vary by a factor of three or so


def largest_loads(machine) -> np.ndarray:
    """The largest forces in the joints that scale friction, N, over poses of the workspace.  (load_count,).

    Of a machine with elastic joints those of the rigid one: it swings about them.
    """
    machine = machine.rigid
    return _largest_loads(Still(machine)) if machine.load_count else np.zeros(0)


class Still:
    """A machine as a key: equal for those that differ at most in the numbers of friction, which no machine at rest
    knows: forces at rest, inertias and what they load the joints with are the same, to the last bit."""

    def __init__(self, machine):
        self.machine, shape = machine, Shape(machine)
        self._key = shape, machine.theta[_still(shape)].tobytes()

    def __hash__(self) -> int:
        return hash(self._key)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Still) and self._key == other._key


@lru_cache(maxsize=64)
def _still(shape: Shape) -> np.ndarray:
    return np.array([not name.startswith(("friction.", "joints.friction.")) for name in shape.part.names], bool)


@lru_cache(maxsize=64)
def at_rest(key: Still) -> tuple[np.ndarray, np.ndarray]:
    """Coordinates and joint forces at home."""
    return key.machine.at_rest(key.machine.home)


@lru_cache(maxsize=64)
def _largest_loads(key: Still) -> np.ndarray:
    machine = key.machine
    d, memory = len(machine.task), np.zeros(machine.memory_count)
    poses, coordinates = _poses(_Geometry(machine))
    pushes = np.eye(d) * np.array([machine.feed.acceleration] * 3 + [machine.feed.angular_acceleration] * 3)[:d]
    a = np.concatenate([np.zeros((1, d)), pushes, -pushes])
    x, z = np.repeat(poses, len(a), axis=0), np.repeat(coordinates, len(a), axis=0)
    a, still = np.tile(a, (len(poses), 1)), np.zeros(d)
    u = machine.inverse_dynamics(x, still, a)
    return _load_rows(Shape(machine))(machine.theta, z, still, memory, a, u)[0].max(axis=0)


class _Geometry:
    """A machine as a key: equal for those that differ at most in what changes no pose: inertias, friction, drives."""

    def __init__(self, machine):
        self.machine, shape = machine, Shape(machine)
        self._key = shape, machine.theta[_geometric(shape)].tobytes()

    def __hash__(self) -> int:
        return hash(self._key)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Geometry) and self._key == other._key


_DYNAMIC = (
    *("platform.", "strut.moving.", "strut.fixed.", "carriage."),
    *("friction.", "joints.friction.", "drive.", "feed."),
)


@lru_cache(maxsize=64)
def _geometric(shape: Shape) -> np.ndarray:
    return np.array([not name.startswith(_DYNAMIC) for name in shape.part.names], bool)


@lru_cache(maxsize=64)
def _poses(key: _Geometry) -> tuple[np.ndarray, np.ndarray]:
    """Home and poses of the workspace (n, d), and their coordinates."""
    machine = key.machine
    poses = [machine.home]
    if machine.limits.workspace is not None:
        poses += list(random_poses(machine, POSES, np.random.default_rng(0)))
    return np.array(poses), machine.coordinates(poses)


@lru_cache(maxsize=64)
def _load_rows(shape: Shape):
    return compile_rows(tick.loads_function(shape.part))


def load_gain(machine, friction: float = 1.0) -> float:
    """How much of a change of the acceleration comes back through loads and breakaway friction, at home; below 1.

    A bound: the sum over the struts of |M^-1 J' e_i| times the slope of that strut's breakaway friction, in the metric
    of the mass matrix; for `friction` times the friction.
    """
    if not (machine.friction and machine.friction.loaded) or machine.rigid is not machine:
        return 0.0  # friction on a motor behind its spring moves nothing that presses on it before the spring bends
    n, law = machine.joints_count, machine.friction
    push, back = _push_and_back(Still(machine))
    mu = friction * np.broadcast_to(law.coulomb if law.static is None else law.static, n)
    return float((mu * push * back).sum())


@lru_cache(maxsize=64)
def _push_and_back(key: Still) -> tuple[np.ndarray, np.ndarray]:
    """What a newton in each strut does, and how its normal force follows the acceleration: (n,) each, at home."""
    machine = key.machine
    n, rest, memory = machine.joints_count, np.zeros(len(machine.velocities)), np.zeros(machine.memory_count)
    z = machine.coordinates(machine.home)
    slopes = np.array(_load_slopes(Shape(machine))(machine.theta, z, rest, memory, rest, np.zeros(n)))
    L = np.linalg.cholesky(machine.mass_matrix(machine.home))
    push = np.linalg.solve(L, machine.jacobian(machine.home).T)
    back = np.linalg.solve(L, slopes[:n].T)
    return np.linalg.norm(push, axis=0), np.linalg.norm(back, axis=0)


@lru_cache(maxsize=64)
def _load_slopes(shape: Shape) -> ca.Function:
    machine = shape.part
    p, theta, z, v, mem = tick.symbols_of(machine)
    vd, u = ca.SX.sym("vd", v.shape), ca.SX.sym("u", machine.joints_count)
    return ca.Function("slopes", [theta, z, v, mem, vd, u], [ca.jacobian(machine.loads_of(p, z, v, vd, mem, u), vd)])
