"""One run: the loop over its chunks, and its Log.

A chunk is some hundredths of a second of computing: sample the reference, check it against the machine's limits, let
the kernel simulate, measure against the programmed path, keep the rows that are logged.  Between chunks Ctrl-C and
progress have their turn.  A run that cannot go on keeps all it has and says why.
"""

from __future__ import annotations

import time

import numpy as np

from .. import kernel as kernels
from ..errors import ExperimentError, RunError
from ..kernel.building import BUILDING
from ..log import Log
from ..log.build import LogBuilder
from ..measure.contour import ContourMeter
from ..measure.summary import Accumulator
from ..program.reference import Reference
from . import columns, cut, leaning, observed, provenance, stability, start, stopped
from .notes import EffortWarning, Notes
from .reach import Reach
from .supervise import supervision_of
from .trip import trip_of

SATURATED = 0.05  # share of samples with a drive at its limit from which a run warns
MOST_ROWS = 2_000_000  # of a log; some 5 GB
CHUNK = 2048  # ticks; 20 ms of computing, so progress and Ctrl-C are prompt and calls cost nothing


class Single:
    """One run: what is fixed before it, and what it collects."""

    def __init__(self, machine, controller, program, plant, run, strict: bool, observer=None, compensation=None):
        with BUILDING:
            self.run_part, self.program, self.plant, self.believed = run, program, plant, machine
            self.true = plant.true_machine
            self.law = controller.on(machine, run.period)
            self.observer = None if observer is None else observer.on(machine, run.period)
            self.compensation = compensation
            leaning.check(machine, self.observer, compensation)
            self.motion = program.plan(machine)
            self.law.check_motion(self.motion, run.period)
            cut.check(plant.cutting, self.motion)
            leaning.check_air(compensation, self.motion)
            self.ticks = self.motion.count(run.period)
            rows = -(-self.ticks // run.log_every)
            if rows > MOST_ROWS:
                raise ExperimentError(
                    f"the program takes {self.motion.duration:.4g} s: the log would have {rows} rows",
                    key="run.log_every",
                    limit=f"{MOST_ROWS} rows",
                    cure=f"give log_every = {-(-self.ticks // MOST_ROWS)} or more, or check the feed",
                )
            self.substeps = stability.substeps_of(self.true, plant, self.motion.duration, run)
            self.notes = Notes()
            seen = self.true if plant.flexible else machine
            self.radius = stability.check_loop(seen, self.law, run.period, self.substeps, strict, self.notes)
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
        run, plant = self.run_part, self.plant
        self.asked = supervision_of(self.believed, run, trip_of(self.believed, run.ferror, run.min_ferror))
        self.faults = start.check_faults(plant, self.true)
        first = start.at_rest(self.believed, self.true, self.law, plant, self.row)
        self.state = first.law
        drifts = bool(plant.friction_drift)
        self.signals = columns.chosen(run.signals, self.state, self.true, drifts, self._told())
        schedule = start.schedule_of(
            self.believed, self.true, self.law, self.state, self.row, run.period, self.substeps, self.faults,
            self.asked, self.signals, drifts, plant.cutting,
        )  # fmt: skip
        schedule = observed.with_observer(schedule, self.observer)
        self.kernel = kernels.compile(leaning.with_leaning(schedule, self.believed, self.row, self.compensation))
        self.simulation = self.kernel.start(
            start.parameters(self.believed, self.true, self.law, plant, run.period, self.faults, self.asked, drifts)
            | observed.parameters(self.observer)
            | leaning.parameters(self.believed, self.compensation),
            start.states(schedule, first, self.row)
            | observed.states(self.observer, self.row.x)
            | leaning.states(self.compensation),
            seed=run.seed,
        )

    def _told(self) -> tuple[str, ...]:
        """Variables of the log that observer and compensation add."""
        return (*observed.logged(self.observer), *(leaning.VARIABLES if self.compensation is not None else ()))

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
                error = columns.explain(stop, self.true, self.motion, self.run_part.period, self.asked.ends_at_once)
            k += done
            if progress is not None:
                progress(min(k, self.ticks - 1) * self.run_part.period, (self.ticks - 1) * self.run_part.period)
        end = stopped.end_of(self.asked, self.simulation, 0, k, self.true, self.motion, self.run_part.period)
        stopped.warn(self.notes, self.true, [end])
        error = stopped.first(end, error, self.simulation.stops[0])
        return self._log(k, time.perf_counter() - started, error), error

    def _advance(self, k: int, reference: Reference) -> int:
        """Simulate the rows of the reference, measure and keep.  How many ticks were good."""
        run, n = self.run_part, len(reference.x)
        out = self.simulation.advance(n, start.inputs(reference, k, self.kernel.schedule))[:, 0]
        n = len(out)
        if n == 0:
            return 0
        reference = Reference(*(column[:n] for column in reference))
        row = {name: out[:, columns] for name, columns in self.kernel.columns.items()}
        book = self.motion.book(k, k + n, run.period)
        if "stopping" in row:
            book = stopped.held(book, row["stopping"][:, 0], run.stop_ramp, self.motion, k, run.period)
        contour = self.meter(k, k + n, run.period, columns.tool_rows(row), book)
        self.sums.update(
            contour_error=contour.contour_error, orientation_error=contour.orientation_error, lag=contour.lag,
            counted=book.counted, line=book.line, q_r=reference.q, qd_r=reference.qd, q=row["q"], qd=row["qd"],
            u=row["u"], saturated=row["saturated"],
        )  # fmt: skip
        part = slice(-k % run.log_every, None, run.log_every)
        self.kept.append(
            columns.columns(
                run.period, k, part, reference, row, book, contour, self.plant.wrench, self.state, self.signals
            )
            | observed.columns(self.observer, row, part, self.signals)
            | leaning.columns(row, part, self.signals)
        )
        return n

    # -- what is said of it ---------------------------------------------------------------------------------------

    def _log(self, ticks: int, wall: float, error: RunError | None) -> Log:
        names = self.kept[0] if self.kept else ()
        joined = {name: np.concatenate([chunk[name] for chunk in self.kept]) for name in names}
        builder = LogBuilder(joined.pop("t", np.zeros(0)), self.believed.task, self.believed.joints_count)
        for name, values in joined.items():
            dim, units, meaning = observed.told(self.observer, name) or columns.told(self.law, name)
            builder.add(name, values, dims=dim, units=units, long_name=meaning)
        status = "done" if error is None else "failed"
        metrics = self.sums.result()
        share = metrics["saturated"] or 0.0
        if share > SATURATED:
            self.notes.warn(
                f"{self.law.kind}: a drive is at its limit in {100 * share:.3g} % of the samples", EffortWarning
            )
        return builder.build(provenance.of(self, metrics, ticks, wall), status, "" if error is None else str(error))
