"""How fine the plant must be stepped, and whether a law and its sample time go together.

The plant's poles are those of its linearisation at home, at v = 0 where friction is steepest: of d(z', v')/d(z, v) with
the friction's memory held, which RK4 must follow (stable on the real axis for |pole| h < 2.785), and of the same with
the memory as a state, the bristles' spring, which the splitting must follow (a leapfrog: stable for |pole| h < 2).
Where friction scales with forces in the joints, these are the largest that a spread of poses of the workspace needs, at
rest and with the acceleration of [feed] along each axis.

Those forces come from the acceleration a sub-step before: a -> loads -> friction -> a+ must contract, else it grows
from step to step.  (Nor does it settle in nature: there friction holds more than the drive pushes: the strut jams.)

A law and a period are tried together: the map of one whole sample of the law (sense, control, drive, RK4), without
friction and quantisation, is linearised at rest by central differences; a spectral radius above 1 grows.
"""

from __future__ import annotations

import math
from functools import lru_cache

import casadi as ca
import numpy as np

from ..declare import Shape
from ..errors import ExperimentError, InputError
from ..frames import quaternion_of_abc_np
from ..kernel.pack import flatten
from ..machine.strut_limits import check_loads
from ..machine.workspace import random_poses
from . import tick
from .notes import Notes, StabilityWarning

RK4_REAL = 2.785  # end of RK4's stability interval on the negative real axis
LEAPFROG = 2.0  # end of the splitting's, for an undamped spring
POSES = 30  # of the workspace, for the largest loads; they vary by a factor of three or so
COARSEST = 0.25e-3  # s; a step at which geometry and Coriolis terms of a machine tool are exact to nanometres


def fastest_pole(machine) -> float:
    """Largest magnitude of the poles of the plant at home with friction, rad/s."""
    memory = np.zeros(machine.memory_count)
    u0 = machine.inverse_dynamics(machine.home, *np.zeros((2, len(machine.task))))
    rest = np.zeros(len(machine.velocities))
    loads = largest_loads(machine)
    found = _linearised(Shape(machine))(machine.theta, _home(machine), rest, memory, u0, loads)
    return max(float(np.abs(np.linalg.eigvals(np.array(A))).max()) for A in found)


@lru_cache(maxsize=64)
def _linearised(shape: Shape) -> ca.Function:
    """d(z', v')/d(z, v), and the same with the friction's memory among the states."""
    machine = shape.part
    p, theta, z, v, mem = tick.symbols_of(machine)
    u, loads = ca.SX.sym("u", machine.joints_count), tick.loads_symbol(machine)
    rates = ca.vertcat(*tick.rate(machine, p, z, v, mem, u, ca.SX.zeros(6), loads))
    y = ca.vertcat(z, v)
    whole, whole_rates = y, rates
    if mem.numel():
        bristles = machine.memory_rate(p, machine.jacobian_of(p, z) @ v, mem, loads)
        whole, whole_rates = ca.vertcat(y, mem), ca.vertcat(rates, bristles)
    return ca.Function("A", [theta, z, v, mem, u, loads], [ca.jacobian(rates, y), ca.jacobian(whole_rates, whole)])


def largest_loads(machine) -> np.ndarray:
    """The largest forces in the joints that scale friction, N, over poses of the workspace.  (load_count,)."""
    if not machine.load_count:
        return np.zeros(0)
    d, memory = len(machine.task), np.zeros(machine.memory_count)
    poses = [machine.home]
    if machine.limits.workspace is not None:
        poses += list(random_poses(machine, POSES, np.random.default_rng(0)))
    pushes = np.eye(d) * np.array([machine.feed.acceleration] * 3 + [machine.feed.angular_acceleration] * 3)[:d]
    a = np.concatenate([np.zeros((1, d)), pushes, -pushes])
    x, a = np.repeat(np.array(poses), len(a), axis=0), np.tile(a, (len(poses), 1))
    z = np.concatenate([x[:, :3], quaternion_of_abc_np(x[:, 3:])], -1)
    u, still = machine.inverse_dynamics(x, np.zeros(d), a), np.zeros(d)
    found = tick.loads_function(machine).map(len(x))(machine.theta, z.T, still, memory, a.T, u.T)
    return np.array(found).max(axis=1)


def load_gain(machine) -> float:
    """How much of a change of the acceleration comes back through loads and breakaway friction, at home; below 1.

    A bound: the sum over the struts of |M^-1 J' e_i| times the slope of that strut's breakaway friction, in the metric
    of the mass matrix.
    """
    if not (machine.friction and machine.friction.loaded):
        return 0.0
    n, d = machine.joints_count, len(machine.velocities)
    rest, memory = np.zeros(d), np.zeros(machine.memory_count)
    slopes = np.array(_load_slopes(Shape(machine))(machine.theta, _home(machine), rest, memory, rest, np.zeros(n)))
    law = machine.friction
    mu = np.broadcast_to(law.coulomb if law.static is None else law.static, n)
    L = np.linalg.cholesky(machine.mass_matrix(machine.home))
    push = np.linalg.solve(L, machine.jacobian(machine.home).T)  # columns: what a newton in a strut does
    back = np.linalg.solve(L, slopes[:n].T)  # columns: how its normal force follows the acceleration
    return float((mu * np.linalg.norm(push, axis=0) * np.linalg.norm(back, axis=0)).sum())


@lru_cache(maxsize=64)
def _load_slopes(shape: Shape) -> ca.Function:
    machine = shape.part
    p, theta, z, v, mem = tick.symbols_of(machine)
    vd, u = ca.SX.sym("vd", v.shape), ca.SX.sym("u", machine.joints_count)
    return ca.Function("slopes", [theta, z, v, mem, vd, u], [ca.jacobian(machine.loads_of(p, z, v, vd, mem, u), vd)])


def choose_substeps(machine, period: float, given: int | None = None) -> int:
    """Sub-steps a sample: those given, checked, or as many as the fastest pole asks for.

    Raises
    ------
    ExperimentError
        if the given number cannot be stable, with the number that is; if friction jams the struts, or the tubes leave
        their sleeves.
    """
    try:
        check_loads(machine)
    except InputError as error:
        raise ExperimentError(problems=error.problems) from None
    gain = load_gain(machine)
    if not gain < 1:
        raise ExperimentError(
            "friction grows faster with the acceleration than the drives push: the struts may jam",
            key="friction.static" if machine.friction.static is not None else "friction.coulomb",
            value=f"a gain of {gain:.3g} from acceleration to friction to acceleration, at home", limit="1",
            cure="lower the coefficients, or let the tubes overlap more (strut.sleeve, strut.tube)",
        )  # fmt: skip
    pole = fastest_pole(machine)
    stable = LEAPFROG if machine.memory_count else RK4_REAL
    # a third of the stability limit keeps the fastest pole's own error below a percent of its (tiny) response
    needed = max(math.ceil(period / COARSEST - 1e-9), math.ceil(pole * period / (stable / 3)))
    if given is None:
        return needed
    h = period / given
    if pole * h >= stable:
        least = math.floor(pole * period / stable) + 1
        raise ExperimentError(
            f"{given} sub-steps of {h * 1e3:.4g} ms cannot follow the plant's fastest pole",
            key="run.substeps",
            value=f"pole x step = {pole * h:.3g}",
            limit=f"{stable}",
            cure=f"give at least {least}, or leave it out for {needed}; friction's numbers set the pole",
        )
    return given


def spectral_radius(machine, law, period: float, substeps: int) -> float:
    """Of the linearised closed loop at home and rest, per sample of the law, which is bound by `law.on`."""
    return float(np.abs(loop_eigenvalues(machine, law, period, substeps)).max())


def loop_eigenvalues(machine, law, period: float, substeps: int) -> np.ndarray:
    """Eigenvalues of the sampled closed loop at home and rest, without friction: one a state, the law's included."""
    quiet = machine.frictionless().replace(drive=machine.drive.perfect())
    rest = tick.rest_row(quiet, quiet.home)
    u0 = quiet.inverse_dynamics(quiet.home, *np.zeros((2, len(quiet.task))))
    state = law.init(rest, u0)
    schedule = tick.build(quiet, law, state, rest, period, substeps)
    fixed = {"theta_plant": quiet.theta, "theta_law": law.theta, "wrench": np.zeros(6), "reference": flatten(rest)}
    states = {name: value for name, value in tick.first_states(schedule, _home(quiet), state, u0).items() if value.size}
    names, sizes = list(states), [value.size for value in states.values()]
    symbols = [ca.MX.sym(name, size) for name, size in zip(names, sizes, strict=True)]
    values = {name: ca.MX(ca.DM(value)) for name, value in fixed.items()}
    values |= {signal.name: ca.MX(0, 1) for signal in schedule.of_kind("state") if signal.size == 0}
    values |= dict(zip(names, symbols, strict=True))
    every = max(task.every for task in schedule.tasks)
    for k in range(every):
        for task in (*schedule.tasks, *(schedule.substep * substeps)):
            if k % task.every == 0:
                out = task.function(*[values[name] for name in task.reads])
                values.update(zip(task.writes, out if isinstance(out, tuple) else (out,), strict=True))
    step = ca.Function("step", symbols, [ca.vertcat(*[values[name] for name in names])])
    x0 = np.concatenate([states[name] for name in names])
    cut = np.cumsum(sizes)[:-1]
    scale = 1e-6 * np.maximum(np.abs(x0), 1e-2)
    columns = [
        np.array(step(*np.split(x0 + d, cut)) - step(*np.split(x0 - d, cut))).ravel() / (2 * d.max())
        for d in np.diag(scale)
    ]
    return np.linalg.eigvals(np.stack(columns, -1))


def check_loop(machine, law, period, substeps, strict: bool = False, notes: Notes | None = None) -> float | None:
    """Warn (`strict`: refuse) when law and period do not go together on this machine; `notes` keeps the warning.

    The spectral radius a sample of the law; None for a law in plain NumPy.

    Raises
    ------
    ExperimentError
        only with `strict`.
    """
    if not law.symbolic:
        return None
    radius = spectral_radius(machine, law, period, substeps)
    # the integrals and the kept command sit at 1 or below; 1e-6 is ten times the error of the differences
    if radius > 1 + 1e-6:
        growth = math.log(2) / math.log(radius) * law.period
        rule = f"{law.kind}: the loop at a period of {law.period * 1e3:g} ms is unstable on {machine.name}"
        value = f"spectral radius {radius:.6g} a sample (doubles in {growth * 1e3:.3g} ms)"
        cure = "lower the bandwidth or shorten the period"
        if strict:
            raise ExperimentError(rule, key="controller", value=value, limit="1", cure=cure)
        (Notes() if notes is None else notes).warn(f"{rule}: {value}; {cure}", StabilityWarning)
    return radius


def _home(machine):
    return np.array(ca.DM(machine.coordinates_of(ca.DM(machine.home)))).ravel()
