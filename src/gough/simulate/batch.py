"""Many runs of one program: plants, laws or seeds that differ in numbers, side by side in the lanes of one kernel.

The reference is sampled and checked once a chunk and shared.  The runs go in slabs of eight, whatever the lanes, over
one buffer: a slab runs a chunk, is measured, and the next one takes its place, so memory grows neither with the number
of runs nor, without rows, with the program.  Plants whose friction asks for other sub-steps have another kernel.  A
run's noise hangs on its seed and its number alone; so no bit of a run depends on the others.
"""

from __future__ import annotations

import time
from collections import defaultdict
from typing import NamedTuple

import numpy as np

from .. import kernel as kernels
from ..errors import ExperimentError, RunError
from ..kernel import noise
from ..kernel.building import BUILDING
from ..log import Log
from ..log.batch import changes
from ..log.build import LogBuilder
from ..measure.contour import ContourMeter
from ..measure.summary import Accumulator
from ..program.reference import Reference
from . import columns, cut, law_tasks, leaning, observed, provenance, stability, start, stopped
from .kept import Kept
from .notes import EffortWarning, Notes
from .reach import Reach
from .single import CHUNK, MOST_ROWS, SATURATED
from .structure import same_structure
from .supervise import supervision_of
from .trip import trip_of

SLAB = 8  # runs over one buffer; a multiple of every number of lanes


class _Ready(NamedTuple):
    """What is known of a run before its first sample: all that is asked of its true machine."""

    substeps: int
    parameters: dict[str, np.ndarray]
    start: start.Start | None
    error: RunError | None


class Batch:
    """The runs of one batch: what is fixed before them, and what they collect."""

    def __init__(
        self, machine, laws, program, plants, seeds, labels, run, keep: str, lanes, strict: bool, observer=None,
        compensation=None,
    ):  # fmt: skip
        with BUILDING:
            self.run_part, self.program, self.believed, self.labels = run, program, machine, labels
            self.plants, self.plant, self.lanes, self.rows_kept = plants, plants[0], lanes, keep == "rows"
            self.count, self.seeds = len(plants), seeds
            self.laws = self._bound(laws)
            self.observer = None if observer is None else observer.on(machine, run.period)
            self.law = self.laws[0]
            self.compensation = compensation
            leaning.check(machine, self.observer, compensation)
            same_structure("controller", self.laws)
            law_tasks.same_rates(self.laws, run.period)
            if not self.law.symbolic and any(law != self.law for law in self.laws):
                raise ExperimentError(
                    "laws of a batch that differ must be symbolic: the step of this one is plain NumPy",
                    key="controller",
                    value=type(self.law).__name__,
                    cure="run them one after the other, or write the step in CasADi's operations",
                )
            self.motion = program.plan(machine)
            for law in {id(law): law for law in self.laws}.values():
                law.check_motion(self.motion, run.period)
            cut.check_batch([plant.cutting for plant in plants])
            for plant in {id(plant): plant for plant in plants}.values():
                cut.check(plant.cutting, self.motion)
            leaning.check_air(compensation, self.motion)
            self.ticks = self.motion.count(run.period)
            self._check_rows()
            self.asked = supervision_of(machine, run, trip_of(machine, run.ferror, run.min_ferror))
            self.shared = columns.SHARED if self.asked.ramp is None else ("t",)
            self.ends: list[stopped.End] = [stopped.End((), None)] * self.count
            self.notes = Notes()
            self.reach = Reach(machine, self.motion, run.period, self.notes)
            self.meter = ContourMeter(self.motion)
            self.sums = [Accumulator(run.period, keep_reversals=self.rows_kept) for _ in plants]
            self.samples = np.zeros(self.count, int)
            self.errors: list[RunError | None] = [None] * self.count
            self.hit: list[dict | None] = [None] * self.count
            self.kept = Kept(self.ticks, run.log_every, self.count, self.shared)
            self.faults = max(len(plant.faults) for plant in plants)
            self.drifts = any(plant.friction_drift for plant in plants)
            first = self.motion.sample(0, 1, run.period)
            self.row = Reference(*(column[0] for column in first))
            _, unreachable = self.reach.of(0, first.x)
            if unreachable is not None:
                raise unreachable
            ready = self._ready()
            self.substeps_of = [one.substeps for one in ready]
            self.substeps = max(self.substeps_of)
            self.radii = {
                key: stability.check_loop(
                    self.true if self.plant.flexible else machine, law, run.period, self.substeps, strict, self.notes
                )
                for key, law in {id(law): law for law in self.laws}.items()
            }
            self.radius = None if None in self.radii.values() else max(self.radii.values())
            self._start(ready)

    def _bound(self, laws):
        known = {}
        for law in laws:  # what is the same object stays one
            if id(law) not in known:
                known[id(law)] = law.on(self.believed, self.run_part.period)
        return [known[id(law)] for law in laws]

    def _check_rows(self):
        run = self.run_part
        rows = -(-self.ticks // run.log_every) * self.count
        if self.rows_kept and rows > MOST_ROWS:
            raise ExperimentError(
                f"{self.count} runs of {self.motion.duration:.4g} s: the log would have {rows} rows",
                key="run.log_every",
                limit=f"{MOST_ROWS} rows",
                cure=f'give keep="metrics", or log_every = {-(-rows * run.log_every // MOST_ROWS)} or more',
            )

    def _ready(self) -> list[_Ready]:
        """What the kernel needs of every run; a true machine, some 100 kB, is not kept."""
        run, known, steps, first = self.run_part, {}, {}, None
        for i, plant in enumerate(self.plants):
            law = self.laws[i]
            key = id(plant), id(law)
            if key not in known:
                true = plant.true_machine
                first = first or true
                same_structure("plant", [first, true], i)
                start.check_faults(plant, true, f"plant.{i}.faults")
                if id(plant) not in steps:
                    steps[id(plant)] = stability.substeps_of(true, plant, self.motion.duration, run)
                substeps = steps[id(plant)]
                parameters = start.parameters(
                    self.believed, true, law, plant, run.period, self.faults, self.asked, self.drifts
                ) | observed.parameters(self.observer)
                parameters |= leaning.parameters(self.believed, self.compensation)
                try:
                    at_rest = start.at_rest(self.believed, true, law, plant, self.row)
                except RunError as error:  # a machine that cannot stand there has failed already
                    known[key] = _Ready(substeps, parameters, None, error)
                else:
                    known[key] = _Ready(substeps, parameters, at_rest, None)
            self.errors[i] = known[key].error
        self.true = first
        return [known[id(plant), id(law)] for plant, law in zip(self.plants, self.laws, strict=True)]

    def _start(self, ready: list[_Ready]):
        """The slabs: runs of one number of sub-steps, at rest at the first reference."""
        run, true = self.run_part, self.true
        started = [one.start for one in ready if one.start is not None]
        self.state = started[0].law if started else self.law.init(self.row, np.zeros(len(self.row.q)))
        told = (*observed.logged(self.observer), *(leaning.VARIABLES if self.compensation is not None else ()))
        self.signals = columns.chosen(run.signals, self.state, true, self.drifts, told)
        groups = defaultdict(list)
        for i, one in enumerate(ready):
            if one.start is not None:
                groups[one.substeps].append(i)
        self.slabs, self.kernel = [], None
        for substeps, members in groups.items():
            schedule = start.schedule_of(
                self.believed, true, self.law, self.state, self.row, run.period, substeps, self.faults, self.asked,
                self.signals, self.drifts, self.plant.cutting,
            )  # fmt: skip
            schedule = observed.with_observer(schedule, self.observer)
            schedule = leaning.with_leaning(schedule, self.believed, self.row, self.compensation)
            self.kernel = kernels.compile(schedule, lanes=self.lanes)
            for at in range(0, len(members), SLAB):
                self.slabs.append(self._slab(schedule, members[at : at + SLAB], ready))

    def _slab(self, schedule, members, ready):
        run = self.run_part
        parameters = [ready[i].parameters for i in members]
        begun = observed.states(self.observer, self.row.x) | leaning.states(self.compensation)
        states = [start.states(schedule, ready[i].start, self.row) | begun for i in members]
        keys = [noise.run_key(run.seed, i) if self.seeds is None else noise.run_key(self.seeds[i], 0) for i in members]
        simulation = self.kernel.start(_stacked(parameters), _stacked(states), runs=len(members), keys=keys)
        return self.kernel, simulation, np.array(members)

    # -- the loop -------------------------------------------------------------------------------------------------

    def run(self, progress) -> tuple[Log, RunError | None]:
        started, k, period = time.perf_counter(), 0, self.run_part.period
        buffers = {}
        while k < self.ticks and any(simulation.alive.any() for _, simulation, _ in self.slabs):
            n = min(CHUNK, self.ticks - k)
            reference = self.motion.sample(k, k + n, period)
            good, error = self.reach.of(k, reference.x)
            reference = Reference(*(column[:good] for column in reference))
            if good:
                book, tables = self.motion.book(k, k + good, period), start.inputs(reference, k, self.kernel.schedule)
                for kernel, simulation, members in self.slabs:
                    shape = -(-len(members) // kernel.lanes) * kernel.lanes, kernel.width
                    if shape not in buffers:
                        buffers[shape] = np.empty((CHUNK, *shape))
                    self._advance(k, reference, book, tables, kernel, simulation, members, buffers[shape])
            if error is not None:
                self.errors = [error if known is None else known for known in self.errors]
                break
            k += n
            if progress is not None:
                progress(min(k, self.ticks - 1) * period, (self.ticks - 1) * period)
        self._supervised()
        return self._log(time.perf_counter() - started), next((e for e in self.errors if e is not None), None)

    def _supervised(self):
        """What supervision says of every run."""
        for _, simulation, members in self.slabs:
            for j, i in enumerate(members):
                end = stopped.end_of(
                    self.asked, simulation, j, int(self.samples[i]), self.true, self.motion, self.run_part.period
                )
                self.ends[i] = end
                self.errors[i] = stopped.first(end, self.errors[i], simulation.stops[j])
        stopped.warn(self.notes, self.true, self.ends, self.labels)

    def _advance(self, k, reference, book, tables, kernel, simulation, members, buffer):
        """Simulate a chunk of the runs of one slab, measure and keep."""
        run, n = self.run_part, len(reference.x)
        before = simulation.alive
        if not before.any():
            return
        out = simulation.advance(n, tables, out=buffer)
        ends = np.where(before, n, 0)
        for j in np.flatnonzero(before & ~simulation.alive):
            stop = simulation.stops[j]
            ends[j] = stop.tick - k
            i = members[j]
            self.hit[i] = {"limit": stop.label, "reason": stop.reason, "time": stop.time, "value": stop.value}
            self.errors[i] = columns.explain(
                stop, self.plants[i].true_machine, self.motion, run.period, self.asked.ends_at_once
            )
        live = np.flatnonzero(ends)
        self.samples[members] += ends
        if not len(live):
            return
        n = len(out)
        out = out if len(live) == out.shape[1] else out[:, live]
        reference, book = (type(part)(*(column[:n] for column in part)) for part in (reference, book))
        row = {name: out[..., where] for name, where in kernel.columns.items()}
        if "stopping" in row:
            book = stopped.held(book, row["stopping"][..., 0], run.stop_ramp, self.motion, k, run.period)
        contour = self.meter(k, k + n, run.period, columns.tool_rows(row), book)
        counted = np.broadcast_to(book.counted.reshape(n, -1), (n, len(live)))
        line = np.broadcast_to(book.line.reshape(n, -1), (n, len(live)))
        for j, lane in enumerate(live):
            part = slice(0, ends[lane])
            self.sums[members[lane]].update(
                contour_error=contour.contour_error[part, j], orientation_error=contour.orientation_error[part, j],
                lag=contour.lag[part, j], counted=counted[part, j], line=line[part, j], q_r=reference.q[part],
                qd_r=reference.qd[part], q=row["q"][part, j], qd=row["qd"][part, j], u=row["u"][part, j],
                saturated=row["saturated"][part, j],
            )  # fmt: skip
        if self.rows_kept:
            wrench = np.array([self.plants[i].wrench for i in members[live]])
            part = slice(-k % run.log_every, None, run.log_every)
            found = columns.columns(
                run.period, k, part, reference, row, book, contour, wrench, self.state, self.signals
            )
            found |= observed.columns(self.observer, row, part, self.signals)
            found |= leaning.columns(row, part, self.signals)
            self.kept.take(k, found, members[live], ends[live])

    # -- what is said of it ---------------------------------------------------------------------------------------

    def _log(self, wall: float) -> Log:
        run = self.run_part
        rows = -(-self.samples // run.log_every) if self.rows_kept else np.zeros(self.count, int)
        kept = self.kept.until(int(rows.max()))
        builder = LogBuilder(
            kept.pop("t", np.zeros(0)), self.believed.task, self.believed.joints_count, runs=self.count
        )
        for name, values in kept.items():
            dim, units, meaning = observed.told(self.observer, name) or columns.told(self.law, name)
            builder.add(name, values, dim, units, meaning, shared=name in self.shared)
        metrics = [sums.result() for sums in self.sums]
        failed = np.array([error is not None for error in self.errors])
        builder.add_runs(metrics, failed)
        self._warn_of_effort(metrics)
        reason = ""
        if failed.any():
            worst = int(np.argmax(failed))
            reason = f"{failed.sum()} of {self.count} runs; run {self.labels[worst]}: {self.errors[worst]}"
        info = provenance.of_batch(self, wall, self._told(rows))
        return builder.build(info, "failed" if failed.any() else "done", reason)

    def _warn_of_effort(self, metrics):
        share = np.array([one["saturated"] or 0.0 for one in metrics])
        if (share > SATURATED).any():
            worst = int(np.argmax(share))
            self.notes.warn(
                f"{self.law.kind}: a drive is at its limit in more than {100 * SATURATED:g} % of the samples of "
                f"{(share > SATURATED).sum()} runs; in run {self.labels[worst]}, {100 * share[worst]:.3g} %",
                EffortWarning,
            )

    def _told(self, rows) -> list[dict]:
        """What the log says of each run."""
        out = []
        plant, law = self.plant.to_file(), _without_machine(self.law)
        differs = {id(self.plant): {}}, {id(self.law): {}}
        for i in range(self.count):
            for known, part, first, table in (
                (differs[0], self.plants[i], plant, lambda p: p.to_file()),
                (differs[1], self.laws[i], law, _without_machine),
            ):
                if id(part) not in known:
                    known[id(part)] = changes(table(part), first)
            error = self.errors[i]
            told = {
                "label": self.labels[i],
                "status": "done" if error is None else "failed",
                "reason": "" if error is None else str(error),
                "seed": self.run_part.seed if self.seeds is None else self.seeds[i],
                "simulated_time": float(self.samples[i] * self.run_part.period),
                "plant": differs[0][id(self.plants[i])],
                "controller": differs[1][id(self.laws[i])],
                "spectral_radius": self.radii[id(self.laws[i])],
                "limit_hit": self.hit[i],
            }
            if self.rows_kept:
                told |= {"rows": int(rows[i]), "reversals": self.sums[i].reversals}
            out.append(told)
        return out


def _without_machine(law) -> dict:
    table = law.to_file()
    table.pop("machine", None)
    return table


def _stacked(runs: list[dict[str, np.ndarray]]) -> dict[str, np.ndarray]:
    return {name: np.array([run[name] for run in runs], float) for name in runs[0]}
