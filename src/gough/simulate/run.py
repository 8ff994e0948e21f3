"""simulate(): a machine, a law and a program in, a Log out.

The run goes in chunks of some hundredths of a second of computing: sample the reference, check it against the
machine's limits, let the kernel simulate, measure against the programmed path, keep the rows that are logged.  Between
chunks Ctrl-C and progress have their turn.  A run that cannot go on keeps all it has and says why.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence

import numpy as np
from pydantic import Field

from .. import kernel as kernels
from ..control.base import Controller
from ..declare import Part, quantity
from ..errors import DivergedError, ExperimentError, RunError, did_you_mean
from ..frames import abc_of_rotation_np, quaternion_of_abc_np, rotation_of_quaternion_np
from ..kernel.pack import fields
from ..log import Log
from ..log.build import VARIABLES, LogBuilder
from ..machine.base import Machine
from ..machine.workspace import beyond
from ..measure.contour import ContourMeter
from ..measure.summary import Accumulator
from ..program.base import Program
from ..program.reference import Reference
from ..quantities import brief
from . import provenance, stability, tick
from .notes import EffortWarning, Notes
from .plant import Plant
from .reach import Reach

_MAKE = {
    "machine": 'gk.load_machine("nist-octahedral")',
    "controller": "gk.PID(bandwidth=10.0)",
    "program": 'gk.load_program("part.ngc") or gk.Circle(radius=0.1, feed=0.05)',
    "plant": "gk.Plant(machine=machine, payload=20.0), or a machine",
}
SATURATED = 0.05  # share of samples with a drive at its limit from which a run warns
MOST_ROWS = 2_000_000  # of a log; some 5 GB
CHUNK = 2048  # ticks; 20 ms of computing, so progress and Ctrl-C are prompt and calls cost nothing


class Run(Part):
    """How a simulation is computed: the [run] table of an experiment."""

    period: float = quantity("s", "sample period of the controllers", default=1e-3, above=0, at_most=1)
    substeps: int | None = Field(
        None, ge=1, le=10_000, description="steps of the plant a period; chosen where left out"
    )
    seed: int = Field(0, ge=0, lt=2**63, description="of the noise")
    log_every: int = Field(1, ge=1, description="the log keeps one of so many samples; metrics use all")
    signals: list[str] | None = Field(None, description="variables of the log; all where left out")


def simulate(
    machine: Machine,
    controller: Controller,
    program: Program,
    plant: Plant | Machine | None = None,
    seed: int = 0,
    period: float = 1e-3,
    substeps: int | None = None,
    log_every: int = 1,
    signals: Sequence[str] | None = None,
    *,
    progress: Callable[[float, float], None] | None = None,
    on_fail: str = "return",
    strict: bool = False,
) -> Log:
    """Run `program` on `plant` (default: `machine` itself) under `controller`, which believes `machine`.

    `progress(simulated, total)` is called after every chunk, in seconds.  A run that leaves the machine's limits or
    diverges ends there: its log has status "failed" and the reason; `on_fail="raise"` raises the error instead, with
    the log as its attribute `log`.  `strict` turns the warning about an unstable loop into an error.

    Returns
    -------
    Log
        as CONTRACT.md 3 describes it; `log.dataset` is an xarray dataset.

    Raises
    ------
    InputError
        what was handed in does not fit together.
    RunError
        only with on_fail="raise".
    """
    run = Run(
        period=period,
        substeps=substeps,
        seed=seed,
        log_every=log_every,
        signals=signals if signals is None or isinstance(signals, str) else list(signals),
    )
    if on_fail not in ("return", "raise"):
        raise ExperimentError('on_fail must be "return" or "raise"', value=repr(on_fail))
    if isinstance(plant, Machine):
        plant = Plant(machine=plant)
    for value, kind, name in (
        (machine, Machine, "machine"),
        (controller, Controller, "controller"),
        (program, Program, "program"),
        (plant, Plant | None, "plant"),
    ):
        if not isinstance(value, kind):
            raise ExperimentError(f"must be a {name.capitalize()}", key=name, value=brief(value), cure=_MAKE[name])
    job = _Job(machine, controller, program, plant or Plant(machine=machine), run, strict)
    log, error = job.run(progress)
    if error is not None and on_fail == "raise":
        error.log = log
        raise error
    return log


class _Job:
    """One run: what is fixed before it, and what it collects."""

    def __init__(self, machine, controller, program, plant, run: Run, strict: bool):
        self.run_part, self.program, self.plant, self.believed = run, program, plant, machine
        self.true = plant.true_machine
        self.law = controller.on(machine, run.period)
        self.motion = program.plan(machine)
        self.ticks = self.motion.count(run.period)
        rows = -(-self.ticks // run.log_every)
        if rows > MOST_ROWS:
            raise ExperimentError(
                f"the program takes {self.motion.duration:.4g} s: the log would have {rows} rows",
                key="run.log_every",
                limit=f"{MOST_ROWS} rows",
                cure=f"give log_every = {-(-self.ticks // MOST_ROWS)} or more, or check the feed",
            )
        self.substeps = stability.choose_substeps(self.true, run.period, run.substeps)
        self.notes = Notes()
        self.radius = stability.check_loop(machine, self.law, run.period, self.substeps, strict, self.notes)
        self.reach = Reach(machine, self.motion, run.period, self.notes)
        self.meter = ContourMeter(self.motion)
        self.sums = Accumulator(run.period)
        first = self.motion.sample(0, 1, run.period)
        self.row = Reference(*(column[0] for column in first))
        _, unreachable = self.reach.of(0, first.x)
        if unreachable is not None:
            raise unreachable
        self.kept: list[dict[str, np.ndarray]] = []
        self._start()

    def _start(self):
        """The plant at rest at the first reference, the law so that nothing moves."""
        x0, d = self.row.x, len(self.believed.task)
        if np.abs(self.true.inverse_kinematics(x0) - self.row.q).max() > 1e-12:  # joints as read, on the true geometry
            x0 = self.true.forward_kinematics(self.row.q, near=x0)
        u0 = self.true.inverse_dynamics(x0, np.zeros(d), np.zeros(d), self.plant.wrench)
        state = self.law.init(self.row, u0)
        self.state = state
        self.signals = self._chosen(self.run_part.signals)
        schedule = tick.build(self.true, self.law, state, self.row, self.run_part.period, self.substeps)
        self.kernel = kernels.compile(schedule)
        self.simulation = self.kernel.start(
            {"theta_plant": self.true.theta, "theta_law": self.law.theta, "wrench": self.plant.wrench},
            tick.first_states(schedule, np.concatenate([x0[:3], quaternion_of_abc_np(x0[3:])]), state, u0),
            seed=self.run_part.seed,
        )

    def _chosen(self, signals) -> set[str] | None:
        """The variables of the log that were asked for; None for all."""
        if signals is None:
            return None
        states = [name if name.startswith("observer.") else f"controller.{name}" for name in fields(self.state)]
        known = [*VARIABLES, *states, *(["plant.friction_memory"] if self.true.memory_count else [])]
        for i, name in enumerate(signals):
            if name not in known:
                cure = did_you_mean(name, known)
                raise ExperimentError(
                    "the log has no such variable", key=f"run.signals.{i}", value=brief(name), cure=cure
                )
        return set(signals)

    # -- the loop -------------------------------------------------------------------------------------------------

    def run(self, progress) -> tuple[Log, RunError | None]:
        started, error, k = time.perf_counter(), None, 0
        while k < self.ticks and error is None:
            n = min(CHUNK, self.ticks - k)
            reference = self.motion.sample(k, k + n, self.run_part.period)
            good, error = self.reach.of(k, reference.x)
            done = self._advance(k, Reference(*(column[:good] for column in reference))) if good else 0
            stop = self.simulation.stops[0]
            if stop is not None:  # what happened comes before what would have happened
                error = self._explain(stop)
            k += done
            if progress is not None:
                progress(min(k, self.ticks - 1) * self.run_part.period, (self.ticks - 1) * self.run_part.period)
        return self._log(k, time.perf_counter() - started, error), error

    def _advance(self, k: int, reference: Reference) -> int:
        """Simulate the rows of the reference, measure and keep.  How many ticks were good."""
        run, n = self.run_part, len(reference.x)
        out = self.simulation.advance(n, {"reference": np.concatenate(reference, axis=1)})[:, 0]
        n = len(out)
        if n == 0:
            return 0
        reference = Reference(*(column[:n] for column in reference))
        row = {name: out[:, columns] for name, columns in self.kernel.columns.items()}
        book = self.motion.book(k, k + n, run.period)
        contour = self.meter(k, k + n, run.period, row["z"])
        self.sums.update(
            contour_error=contour.contour_error, orientation_error=contour.orientation_error, lag=contour.lag,
            counted=book.counted, line=book.line, q_r=reference.q, qd_r=reference.qd, q=row["q"], qd=row["qd"],
            u=row["u"], saturated=row["saturated"],
        )  # fmt: skip
        part = slice(-k % run.log_every, None, run.log_every)
        self.kept.append(self._columns(k, part, reference, row, book, contour))
        return n

    def _columns(self, k, part, reference, row, book, contour) -> dict[str, np.ndarray]:
        z = row["z"][part]
        x = np.concatenate([z[:, :3], abc_of_rotation_np(rotation_of_quaternion_np(z[:, 3:]))], -1)
        x[:, 3:] += (
            2 * np.pi * np.round((reference.x[part][:, 3:] - x[:, 3:]) / (2 * np.pi))
        )  # the turn nearest the reference
        found = {
            "t": (np.arange(k, k + len(row["z"]))[part]) * self.run_part.period,
            "x_r": reference.x[part], "x": x, "xd_r": reference.xd[part], "xd": row["v"][part],
            "q_r": reference.q[part], "s_r": book.s[part],
            "line": book.line[part], "block": book.block[part], "counted": book.counted[part],
            "wrench": np.broadcast_to(self.plant.wrench, (len(z), 6)),
        }  # fmt: skip
        found |= {name: row[name][part] for name in ("q", "q_m", "u_c", "u", "friction", "saturated")}
        found |= {name: value[part] for name, value in contour._asdict().items()}
        for name, where in fields(self.state).items():
            owner, values = "controller." + name, row["law"][part][:, where]
            found[name if name.startswith("observer.") else owner] = values[:, 0] if values.shape[1] == 1 else values
        if "memory" in row:
            found["plant.friction_memory"] = row["memory"][part]
        if self.signals is not None:
            found = {name: value for name, value in found.items() if name == "t" or name in self.signals}
        return {name: np.ascontiguousarray(value) for name, value in found.items()}

    # -- what is said of it ---------------------------------------------------------------------------------------

    def _explain(self, stop) -> RunError:
        """The kernel's stop as an error of the machine."""
        line = int(self.motion.book(stop.tick, stop.tick + 1, self.run_part.period).line[0])
        place = f"NC line {line}" if line else None
        if stop.reason == "not finite":
            return DivergedError(
                f"{stop.signal} is no longer finite",
                where=place,
                key=stop.label,
                value=str(stop.value),
                time=stop.time,
                cure="the loop is most likely unstable: lower the bandwidth or shorten the period",
            )
        return beyond(self.true, stop.index, stop.value, place, stop.time)

    def _log(self, ticks: int, wall: float, error: RunError | None) -> Log:
        names = self.kept[0] if self.kept else ()
        joined = {name: np.concatenate([chunk[name] for chunk in self.kept]) for name in names}
        builder = LogBuilder(joined.pop("t", np.zeros(0)), self.believed.task, self.believed.joints_count)
        for name, values in joined.items():
            dim, units, meaning = self._told(name)
            builder.add(name, values, dims=dim, units=units, long_name=meaning)
        status = "done" if error is None else "failed"
        metrics = self.sums.result()
        share = metrics["saturated"] or 0.0
        if share > SATURATED:
            self.notes.warn(
                f"{self.law.kind}: a drive is at its limit in {100 * share:.3g} % of the samples", EffortWarning
            )
        return builder.build(provenance.of(self, metrics, ticks, wall), status, "" if error is None else str(error))

    def _told(self, name: str) -> tuple:
        """Dimension, unit and meaning of a state, as its law tells; variables of the contract have theirs."""
        if name == "plant.friction_memory":
            return ("joint",), "m", "deflection of the friction's bristles"
        told = self.law.states.get(name.removeprefix("controller."))
        return (None, "", "") if told is None else ((told[0],), told[1], told[2])
