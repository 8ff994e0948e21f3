"""How fine the plant must be stepped, and whether a law and its sample time go together.

The plant's poles are those of its linearisation at home, at v = 0 where friction is steepest: of d(z', v')/d(z, v) with
the friction's memory held, which RK4 must follow (stable on the real axis for |pole| h < 2.785), and of the same with
the memory as a state, the bristles' spring, which the splitting must follow (a leapfrog: stable for |pole| h < 2).

A law and a period are tried together: the map of one whole sample of the law (sense, control, drive, RK4), without
friction and quantisation, is linearised at rest by central differences; a spectral radius above 1 grows.
"""

from __future__ import annotations

import math
from functools import lru_cache

import casadi as ca
import numpy as np

from ..declare import Shape
from ..errors import ExperimentError
from ..kernel.pack import flatten
from . import tick
from .notes import Notes, StabilityWarning

RK4_REAL = 2.785  # end of RK4's stability interval on the negative real axis
LEAPFROG = 2.0  # end of the splitting's, for an undamped spring
COARSEST = 0.25e-3  # s; a step at which geometry and Coriolis terms of a machine tool are exact to nanometres


def fastest_pole(machine) -> float:
    """Largest magnitude of the poles of the plant at home with friction, rad/s."""
    memory = np.zeros(machine.memory_count)
    u0 = machine.inverse_dynamics(machine.home, *np.zeros((2, len(machine.task))))
    found = _linearised(Shape(machine))(machine.theta, _home(machine), np.zeros(len(machine.velocities)), memory, u0)
    return max(float(np.abs(np.linalg.eigvals(np.array(A))).max()) for A in found)


@lru_cache(maxsize=64)
def _linearised(shape: Shape) -> ca.Function:
    """d(z', v')/d(z, v), and the same with the friction's memory among the states."""
    machine = shape.part
    p, theta, z, v, mem = tick.symbols_of(machine)
    u = ca.SX.sym("u", machine.joints_count)
    rates = ca.vertcat(*tick.rate(machine, p, z, v, mem, u, ca.SX.zeros(6)))
    y = ca.vertcat(z, v)
    whole, whole_rates = y, rates
    if mem.numel():
        bristles = machine.friction.memory_rate(p.friction, machine.jacobian_of(p, z) @ v, mem)
        whole, whole_rates = ca.vertcat(y, mem), ca.vertcat(rates, bristles)
    return ca.Function("A", [theta, z, v, mem, u], [ca.jacobian(rates, y), ca.jacobian(whole_rates, whole)])


def choose_substeps(machine, period: float, given: int | None = None) -> int:
    """Sub-steps a sample: those given, checked, or as many as the fastest pole asks for.

    Raises
    ------
    ExperimentError
        if the given number cannot be stable, with the number that is.
    """
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
    quiet = machine.replace(friction=None, drive=machine.drive.replace(encoder=None, noise=None, torque_limit=None))
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
