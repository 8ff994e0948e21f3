"""The two engines that carry out ticks on the same buffers: machine code, and CasADi's interpreter.

The interpreter is the oracle of the tests, the way out where no machine code can be made, and what runs plain Python
tasks.
"""

from __future__ import annotations

import ctypes
import threading

import casadi as ca
import numpy as np

from ..errors import InputError
from . import noise
from .layout import Layout
from .schedule import Schedule, Task


class Native:
    """@run of module.py."""

    def __init__(self, library):
        self._library = library  # keeps the code in memory
        integer, pointer = ctypes.c_int64, ctypes.c_void_p
        kind = ctypes.CFUNCTYPE(
            integer, pointer, pointer, pointer, pointer, pointer, integer, integer, integer, integer, integer
        )
        self._run = kind(library.address)  # a CFUNCTYPE call releases the GIL

    def run(self, ws, kept, words, tables, log, lane: int, k0: int, i: int, n: int) -> int:
        """Ticks k0 + i ... k0 + n - 1 of the W runs from `lane` on; n, or the i at whose end one of them failed."""
        _, runs, width = log.shape
        pointers = (ctypes.c_void_p * max(1, len(tables)))(*(table.ctypes.data for table in tables))
        return self._run(
            ws.ctypes.data,
            kept.ctypes.data,
            words.ctypes.data,
            ctypes.addressof(pointers),
            log.ctypes.data + 8 * lane * width,
            width,
            runs * width,
            k0,
            i,
            n,
        )


class Interpreter:
    """The same ticks, one run at a time, by casadi.Function or plain Python."""

    def __init__(self, schedule: Schedule, layout: Layout):
        self._schedule, self._layout = schedule, layout
        # the functions keep their arguments here, for all simulations of a kernel; a plain function may run one itself
        self._lock = threading.RLock()
        at = lambda name: layout.at(name, schedule.by_name[name].size)  # noqa: E731
        self._inputs = [at(s.name) for s in schedule.of_kind("input")]
        self._noise = [(s.name, s.size, at(s.name)) for s in schedule.of_kind("noise") if s.size]
        self._limits = at(schedule.limit_signal) if schedule.limits else slice(0, 0)
        calls = {}
        for task in schedule.all_tasks:
            reads, writes = [at(name) for name in task.reads], [at(name) for name in task.writes]
            calls[task.name] = (
                _Symbolic(task, reads, writes) if task.symbolic else _Plain(task, reads, writes, schedule)
            )
        self._tasks = [(task.every, calls[task.name]) for task in schedule.tasks]
        self._substep = [calls[task.name] for task in schedule.substep]
        self._last = [calls[schedule.limits.name]] if schedule.limits else []

    def run(self, ws, kept, words, tables, log, lane: int, k0: int, i: int, n: int) -> int:
        ws, kept = ws.reshape(-1), kept.reshape(-1)
        states = self._layout.states
        key = int(words[1, 0]) & (1 << 64) - 1
        with self._lock, np.errstate(all="ignore"):
            while i < n:
                good = self._tick(ws, tables, log, lane, k0 + i, i, key)
                good = good and bool(np.isfinite(ws[states]).all()) and bool((ws[self._limits] >= 0).all())
                if words[0, 0] and not good:
                    words[2, 0] = -1
                    return i
                kept[:] = ws[states]
                i += 1
        return n

    def _tick(self, ws, tables, log, lane: int, tick: int, i: int, key: int) -> bool:
        for where, table in zip(self._inputs, tables, strict=True):
            ws[where] = table[i]
        for name, size, where in self._noise:
            ws[where] = noise.normals(name, size, key, tick)
        for every, call in self._tasks:
            if tick % every == 0:
                call(ws)
        row = log[i, lane]
        row[:] = ws[: self._layout.width]
        for _ in range(self._schedule.substeps):
            for call in self._substep:
                call(ws)
        for call in self._last:
            call(ws)
        return bool(np.isfinite(row).all())


class _Symbolic:
    """A casadi.Function called on ranges of the workspace."""

    def __init__(self, task: Task, reads, writes):
        function = dense(task.function)
        self._reads, self._writes = reads, writes
        self._arguments = [np.zeros(w.stop - w.start) for w in reads]
        self._results = [np.zeros(w.stop - w.start) for w in writes]
        self._buffer, self._call = function.buffer()
        self._function = function
        for position, array in enumerate(self._arguments):
            self._buffer.set_arg(position, memoryview(array))
        for position, array in enumerate(self._results):
            self._buffer.set_res(position, memoryview(array))

    def __call__(self, ws):
        for array, where in zip(self._arguments, self._reads, strict=True):
            array[:] = ws[where]
        self._call()
        for array, where in zip(self._results, self._writes, strict=True):
            ws[where] = array


def dense(function: ca.Function) -> ca.Function:
    """The same function with dense inputs and outputs: its buffers then hold all entries."""
    sparsities = [function.sparsity_in(i) for i in range(function.n_in())]
    if all(s.is_dense() for s in sparsities + [function.sparsity_out(j) for j in range(function.n_out())]):
        return function
    symbols = [ca.SX.sym(f"i{i}", s.size1(), s.size2()) for i, s in enumerate(sparsities)]
    results = function.call([ca.project(x, s) for x, s in zip(symbols, sparsities, strict=True)])
    return ca.Function(function.name(), symbols, [ca.densify(r) for r in results])


class _Plain:
    """A Python callable: arrays (size,) in, an array or a tuple of arrays out."""

    def __init__(self, task: Task, reads, writes, schedule: Schedule):
        self._task, self._reads, self._writes = task, reads, writes
        self._sizes = schedule.sizes(task.writes)

    def __call__(self, ws):
        results = self._task.function(*(ws[where].copy() for where in self._reads))
        results = results if isinstance(results, tuple) else (results,)
        where = f"task {self._task.name}"
        if len(results) != len(self._writes):
            raise InputError(f"must return {len(self._writes)} arrays", where=where, value=str(len(results)))
        for name, size, target, result in zip(self._task.writes, self._sizes, self._writes, results, strict=True):
            array = np.asarray(result, np.float64).reshape(-1)
            if array.size != size:
                raise InputError(f"must return {size} numbers for {name}", where=where, value=str(array.size))
            ws[target] = array
