"""How fine the plant must be stepped, and whether a law and its sample time go together.

The plant's poles are those of its linearisation at home, at v = 0 where friction is steepest: of d(z', v')/d(z, v) with
the friction's memory held, which RK4 must follow (stable on the real axis for |pole| h < 2.785), and of the same with
the memory as a state, the bristles' spring, which the splitting must follow (a leapfrog: stable for |pole| h < 2).
Where friction scales with forces in the joints, these are the largest that a spread of poses of the workspace needs, at
rest and with the acceleration of [feed] along each axis.

Those forces come from the acceleration a sub-step before: a -> loads -> friction -> a+ must contract, else it grows
from step to step.  (Nor does it settle in nature: there friction holds more than the drive pushes: the strut jams.)

A law and a period are tried together: in one whole sample of the law at rest, or one cycle of its tasks (loop.py), a
spectral radius above 1 grows.
"""

from __future__ import annotations

import math
from functools import lru_cache

import casadi as ca
import numpy as np

from ..declare import Shape
from ..errors import ExperimentError, InputError
from ..machine.strut_limits import check_loads
from . import cut, law_tasks
from .drift import drifts, scale
from .linear import plant_jacobians
from .loads import Still, at_rest, largest_loads, load_gain
from .loop import loop_eigenvalues
from .notes import LawWarning, Notes, StabilityWarning

RK4_REAL = 2.785  # end of RK4's stability interval on the negative real axis
LEAPFROG = 2.0  # end of the splitting's, for an undamped spring
MOST = 10_000  # sub-steps a sample, as in the [run] table
COARSEST = 0.25e-3  # s; a step at which geometry and Coriolis terms of a machine tool are exact to nanometres


def fastest_pole(machine, friction: float = 1.0) -> float:
    """Largest magnitude of the poles of the plant at home with `friction` times its friction, rad/s."""
    rest = np.zeros(len(machine.velocities))
    z, u0 = at_rest(Still(machine))
    theta = machine.theta if friction == 1 else np.where(drifts(machine), friction, 1.0) * machine.theta
    memory, loads = np.zeros(machine.memory_count), largest_loads(machine)
    found = _rates_jacobians(Shape(machine))(theta, z, rest, memory, u0, loads)
    return max(float(np.abs(np.linalg.eigvals(np.array(A))).max()) for A in found)


@lru_cache(maxsize=64)
def _rates_jacobians(shape: Shape) -> ca.Function:
    """The first two of `plant_jacobians`."""
    whole = plant_jacobians(shape)
    inputs = [ca.SX.sym(whole.name_in(i), whole.sparsity_in(i)) for i in range(whole.n_in())]
    return ca.Function("rates_jacobians", inputs, whole.call(inputs)[:2])


def choose_substeps(machine, period: float, given: int | None = None, friction: float = 1.0) -> int:
    """Sub-steps a sample: those given, checked, or as many as the fastest pole asks for.

    `friction` is how many times its friction the machine may come to have.

    Raises
    ------
    ExperimentError
        if the given number cannot be stable, with the number that is; if friction jams the struts, or the tubes leave
        their sleeves; if the pole asks for more than MOST.
    """
    try:
        check_loads(machine)
    except InputError as error:
        raise ExperimentError(problems=error.problems) from None
    grown = f"with {friction:.4g} times the friction, " if friction != 1 else ""
    gain = load_gain(machine, friction)
    if not gain < 1:
        raise ExperimentError(
            f"{grown}friction grows faster with the acceleration than the drives push: the struts may jam",
            key="friction.static" if machine.friction.static is not None else "friction.coulomb",
            value=f"a gain of {gain:.3g} from acceleration to friction to acceleration, at home", limit="1",
            cure="lower the coefficients, or let the tubes overlap more (strut.sleeve, strut.tube)",
        )  # fmt: skip
    pole = fastest_pole(machine, friction)
    stable = LEAPFROG if machine.memory_count else RK4_REAL
    # a third of the stability limit keeps the fastest pole's own error below a percent of its (tiny) response
    needed = max(math.ceil(period / COARSEST - 1e-9), math.ceil(pole * period / (stable / 3)))
    if given is None:
        if needed > MOST:
            raise ExperimentError(
                f"{grown}the plant's fastest pole asks for more sub-steps than a run takes", key="run.period",
                value=f"{pole:.3g} 1/s: {needed} sub-steps of a sample of {period * 1e3:g} ms", limit=f"{MOST}",
                cure="lower what sets it: stiffness and damping of friction or springs",
            )  # fmt: skip
        return needed
    h = period / given
    if pole * h >= stable:
        least = math.floor(pole * period / stable) + 1
        raise ExperimentError(
            f"{grown}{given} sub-steps of {h * 1e3:.4g} ms cannot follow the plant's fastest pole",
            key="run.substeps",
            value=f"pole x step = {pole * h:.3g}",
            limit=f"{stable}",
            cure=f"give at least {least}, or leave it out for {needed}; friction and springs set the pole",
        )
    return given


def substeps_of(true, plant, duration: float, run) -> int:
    """Sub-steps a sample for a run of `duration` s on a plant whose machine is `true`, as the [run] table asks.

    Raises
    ------
    ExperimentError
        as `choose_substeps`, for the most friction that the plant comes to have.
    """
    most = max(1.0, scale(plant.friction_drift, duration))
    needed = choose_substeps(true, run.period, run.substeps, most)
    return cut.substeps_of(plant.cutting, run.period, needed, run.substeps)


def spectral_radius(machine, law, period: float, substeps: int) -> float:
    """Of the linearised closed loop at home and rest, per sample of the law, which is bound by `law.on`."""
    radius = float(np.abs(loop_eigenvalues(machine, law, period, substeps)).max())
    return radius ** (law.period / law_tasks.cycle(law, period))


def check_loop(machine, law, period, substeps, strict: bool = False, notes: Notes | None = None) -> float | None:
    """Warn (`strict`: refuse) when law and period do not go together on this machine; `notes` keeps the warnings.

    What the law doubts itself is warned of too.

    The spectral radius a sample of the law; None for a law in plain NumPy.

    Raises
    ------
    ExperimentError
        only with `strict`.
    """
    notes = Notes() if notes is None else notes
    for doubt in law.doubts():
        notes.warn(f"{law.kind}: {doubt}", LawWarning)
    if not law.symbolic:
        return None
    radius = spectral_radius(machine, law.standing(), period, substeps)
    # the integrals and the kept command sit at 1 or below; 1e-6 is ten times the error of the differences
    if radius > 1 + 1e-6:
        growth = math.log(2) / math.log(radius) * law.period
        rule = f"{law.kind}: the loop at a period of {law.period * 1e3:g} ms is unstable on {machine.name}"
        value = f"spectral radius {radius:.6g} a sample (doubles in {growth * 1e3:.3g} ms)"
        cure = "lower the bandwidth or shorten the period"
        if strict:
            raise ExperimentError(rule, key="controller", value=value, limit="1", cure=cure)
        notes.warn(f"{rule}: {value}; {cure}", StabilityWarning)
    return radius
