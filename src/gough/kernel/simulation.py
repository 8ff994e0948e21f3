"""A started simulation of one or many runs: buffers, chunks, and what becomes of a run that fails."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..errors import InputError, did_you_mean
from . import noise

_BROKEN = "this simulation was left in the middle of a chunk, by an interruption or an error"


@dataclass(frozen=True)
class Stop:
    """Why a run ended: at tick `tick`, `time` seconds, entry `index` of `signal` had `value`.

    `reason` is "limit" (an entry of the limits was not >= 0) or "not finite" (a state or a logged value was inf or
    NaN).
    """

    tick: int
    time: float
    reason: str
    signal: str
    index: int
    label: str
    value: float


class Simulation:
    """Runs side by side, W in a group; made by Kernel.start.  `tick` is the next tick to be simulated."""

    def __init__(self, kernel, parameters, states, seed: int, runs: int, first_run: int, keys=None):
        if not isinstance(runs, (int, np.integer)) or runs < 1:
            raise InputError("the number of runs must be 1, 2, 3 ...", value=repr(runs))
        layout, width = kernel.layout, kernel.lanes
        self.kernel, self.runs, self.tick = kernel, int(runs), 0
        self.stops: list[Stop | None] = [None] * self.runs
        self._groups = -(-self.runs // width)
        self._broken = False
        self._ws = _aligned((self._groups, layout.slots + width, width))
        self._words = _aligned((self._groups, 3, width)).view(np.int64)
        self._fill("parameter", parameters or {}, np.isnan, "must not be NaN")
        self._fill("state", states or {}, lambda x: ~np.isfinite(x), "must be finite")
        self._kept = _aligned((self._groups, layout.states.stop - layout.states.start, width))
        self._kept[:] = self._ws[:, layout.states]
        if keys is None:
            keys = [noise.run_key(seed, first_run + run) for run in range(self.runs)]
        elif len(keys) != self.runs:
            raise InputError(f"{self.runs} keys of the noise are needed", value=str(len(keys)))
        # what fills the last group is a copy of the last run that nobody asks for: it is never alive
        for run in range(self._groups * width):
            group, lane = divmod(run, width)
            key = keys[min(run, self.runs - 1)]
            self._words[group, :2, lane] = -(run < self.runs), np.uint64(key).astype(np.int64)

    @property
    def alive(self) -> np.ndarray:
        """Which runs go on, (runs,)."""
        return np.array([stop is None for stop in self.stops])

    def state(self, name: str) -> np.ndarray:
        """The state after the last good tick of each run, (runs, size)."""
        if self._broken:
            raise InputError(_BROKEN, cure="start a new one")
        schedule = self.kernel.schedule
        names = [s.name for s in schedule.of_kind("state")]
        if name not in names:
            raise InputError(f"no state is called {name!r}", cure=did_you_mean(name, names))
        where = self.kernel.layout.at(name, schedule.by_name[name].size)
        return self._ws[:, where].transpose(0, 2, 1).reshape(-1, where.stop - where.start)[: self.runs].copy()

    def advance(self, n: int, inputs: dict | None = None, out: np.ndarray | None = None) -> np.ndarray:
        """Simulates at most n ticks; gives the log rows, (ticks, runs, width): `kernel.columns` says what lies where.

        `inputs[name]` is (n, size): a row for each of these ticks.  Rows of a run from the tick of its stop on are
        NaN; the rows end where the last run does.  `out`, (>= n, runs padded to a multiple of W, width), is used
        instead of new memory.
        """
        if self._broken:
            raise InputError(_BROKEN, cure="start a new one")
        if not isinstance(n, (int, np.integer)) or n < 0:
            raise InputError("the number of ticks must be 0, 1, 2 ...", value=repr(n))
        tables = self._tables(int(n), inputs or {})
        shape = (int(n), self._groups * self.kernel.lanes, self.kernel.width)
        if out is None:
            out = np.empty(shape)
        elif not isinstance(out, np.ndarray) or not out.flags.writeable or not out.flags.c_contiguous:
            raise InputError("out must be a C-contiguous array that may be written", value=type(out).__name__)
        elif out.dtype != np.float64 or out.shape[0] < n or out.shape[1:] != shape[1:]:
            raise InputError(f"out must be a C-contiguous float64 array of shape {shape}", value=str(out.shape))
        log, done = out[:n], 0
        self._broken = True  # until the groups are at the same tick again
        for group in range(self._groups):
            done = max(done, self._advance_group(group, int(n), tables, log))
        self._broken = False
        self.tick += done
        return log[:done, : self.runs]

    def _advance_group(self, group: int, n: int, tables, log) -> int:
        """How many ticks a run of this group still had to give, at most n."""
        width = self.kernel.lanes
        ws, kept, words = self._ws[group], self._kept[group], self._words[group]
        first, i, done = group * width, 0, 0
        ends = np.where(words[0] != 0, n, 0)  # per lane: its rows are valid before this one
        while words[0].any():
            i = done = self.kernel.engine.run(ws, kept, words, tables, log, first, self.tick, i, n)
            if i == n:
                break
            failed = np.flatnonzero(words[2])
            for lane in failed:
                self.stops[first + lane] = self._why(i, log[i, first + lane], ws[:, lane])
            ends[failed], words[0, failed], words[2] = i, 0, 0
            self._keep(ws, kept, words[0] != 0)
            i += 1
        for lane, end in enumerate(ends):
            log[end:, first + lane] = np.nan
        return done

    def _keep(self, ws, kept, live):
        """The end of a tick with a failure: living runs keep their new states, the others get the old ones back."""
        states = self.kernel.layout.states
        kept[:] = np.where(live, ws[states], kept)
        ws[states] = kept

    def _why(self, i: int, row: np.ndarray, slots: np.ndarray) -> Stop:
        """The first entry that was not as it must be: in the log row, the states, the limits."""
        kernel, layout = self.kernel, self.kernel.layout
        schedule = kernel.schedule
        after = slots.copy()
        after[: layout.width] = row
        candidates = [(name, "not finite", after) for name in schedule.log]
        candidates += [(s.name, "not finite", slots) for s in schedule.of_kind("state")]
        if schedule.limits:
            candidates.append((schedule.limit_signal, "limit", slots))
        for name, reason, numbers in candidates:
            signal = schedule.by_name[name]
            values = numbers[layout.at(name, signal.size)]
            bad = ~np.isfinite(values) if reason == "not finite" else ~(values >= 0)
            if bad.any():
                index = int(np.argmax(bad))
                tick = self.tick + i
                return Stop(
                    tick, tick * schedule.period, reason, name, index, signal.label(index), float(values[index])
                )
        raise AssertionError("a run failed without a cause")  # engine and this page disagree: a mistake of ours

    def _tables(self, n: int, inputs: dict) -> list[np.ndarray]:
        signals = self.kernel.schedule.of_kind("input")
        _same_names("input", [s.name for s in signals], inputs)
        tables = []
        for signal in signals:
            try:
                table = np.ascontiguousarray(inputs[signal.name], np.float64)
            except (TypeError, ValueError):
                value = type(inputs[signal.name]).__name__
                raise InputError("the table must be numbers", where=f"input {signal.name}", value=value) from None
            if table.shape != (n, signal.size) and not (signal.size == 1 and table.shape == (n,)):
                raise InputError(
                    f"the table must have shape {(n, signal.size)}",
                    where=f"input {signal.name}",
                    value=str(table.shape),
                )
            table = table.reshape(n, signal.size)
            bad = np.argwhere(~np.isfinite(table))
            if len(bad):
                row, entry = bad[0]
                raise InputError(
                    "the table must be finite",
                    where=f"input {signal.name}",
                    value=f"{table[row, entry]} in row {row}, {signal.label(int(entry))}",
                )
            tables.append(table)
        return tables

    def _fill(self, kind: str, given: dict, wrong, rule: str):
        signals = self.kernel.schedule.of_kind(kind)
        _same_names(kind, [s.name for s in signals], given)
        padded = np.minimum(np.arange(self._groups * self.kernel.lanes), self.runs - 1)
        for signal in signals:
            where = f"{kind} {signal.name}"
            try:
                values = np.array(given[signal.name], np.float64)
            except (TypeError, ValueError):
                raise InputError("must be numbers", where=where, value=type(given[signal.name]).__name__) from None
            if values.shape not in ((signal.size,), (self.runs, signal.size)) and not (
                signal.size == 1 and values.ndim == 0
            ):
                raise InputError(
                    f"must have shape {(signal.size,)} or {(self.runs, signal.size)}",
                    where=where,
                    value=str(values.shape),
                )
            values = np.broadcast_to(values, (self.runs, signal.size))
            bad = np.argwhere(wrong(values))
            if len(bad):
                run, entry = bad[0]
                raise InputError(
                    rule, where=where, value=f"{values[run, entry]} for {signal.label(int(entry))} of run {run}"
                )
            lanes = values[padded].reshape(self._groups, self.kernel.lanes, signal.size)
            self._ws[:, self.kernel.layout.at(signal.name, signal.size)] = lanes.transpose(0, 2, 1)


def _same_names(kind: str, expected: list[str], given: dict):
    for name in given:
        if name not in expected:
            raise InputError(f"no {kind} is called {name!r}", cure=did_you_mean(name, expected))
    missing = [name for name in expected if name not in given]
    if missing:
        raise InputError(f"a value is missing for {kind} {', '.join(missing)}", cure="give every one of them")


def _aligned(shape: tuple[int, ...]) -> np.ndarray:
    """Zeros that begin at a multiple of 64 bytes: a vector of 8 is loaded aligned."""
    count = int(np.prod(shape))
    raw = np.zeros(count + 8)
    start = -raw.ctypes.data % 64 // 8
    return raw[start : start + count].reshape(shape)
