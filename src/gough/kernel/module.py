"""A schedule as one LLVM module: the functions of its tasks, and @run, which calls them tick after tick.

    i64 run(ws, kept, lanes, tables, log, lane stride, row stride, k0, i, n)

runs ticks k0 + i ... k0 + n - 1 and gives n, or the first i at whose end a living lane had failed: then nothing of
tick i is kept yet, and word 2 of `lanes` holds -1 for the lanes that failed.  The caller records why, keeps the states
of the others and goes on with i + 1.  `lanes` is (3, W) integers: -1 where alive, key of the noise, failed.  `tables`
points to the tables of the inputs in the order of the signals; `log` to the row of tick k0 of the first lane; strides
are in doubles.
"""

from __future__ import annotations

from . import llvm, noise, parts
from .lanes import Calls, Lanes, host_features
from .layout import Layout
from .schedule import Schedule, Signal, Task


def text(schedule: Schedule, layout: Layout, lanes: Lanes) -> tuple[str, dict[str, str]]:
    """The module, and the symbols it needs: name in the module -> name in the C library."""
    calls = Calls(lanes)
    names: dict[str, str] = {}  # digest of a tape -> function; equal tapes are compiled once
    functions = []
    for tape in schedule.tapes.values():
        if tape.digest not in names:
            names[tape.digest] = f"task{len(names)}"
            functions.append(llvm.function(tape, names[tape.digest], lanes, calls))
    if schedule.of_kind("noise"):
        functions.append(noise.function(lanes, calls))
    functions += [parts.checks(lanes), parts.keep(lanes), parts.spread(lanes), parts.transposition(lanes, "scatter")]
    functions.append(
        _Run(schedule, layout, lanes, {t: names[tape.digest] for t, tape in schedule.tapes.items()}).text()
    )
    head = llvm.declarations(lanes) + parts.intrinsics(lanes) + calls.text()
    return head + "".join(functions) + attributes(lanes), calls.symbols


def attributes(lanes: Lanes) -> str:
    """What every function is compiled for: vectors of W doubles stay in one register where the processor has such."""
    bits = max(128, 64 * lanes.width)
    width = (
        f' "min-legal-vector-width"="{bits}" "prefer-vector-width"="{bits}"' if "+avx512f" in host_features() else ""
    )
    return f'attributes #0 = {{ nounwind "no-trapping-math"="true"{width} }}\n'


class _Run:
    def __init__(self, schedule: Schedule, layout: Layout, lanes: Lanes, functions: dict[str, str]):
        self.schedule, self.layout, self.lanes, self.functions = schedule, layout, lanes, functions
        self.lines: list[str] = []
        self.keys: list[str] = []  # global constants: the keys of the noise

    def text(self) -> str:
        self._entry()
        for position, signal in enumerate(self.schedule.of_kind("input")):
            self._input(position, signal)
        for signal in self.schedule.of_kind("noise"):
            self._noise(signal)
        for position, task in enumerate(self.schedule.tasks):
            self._periodic(position, task)
        self._log()
        self._substeps()
        self._checks()
        parameters = (
            "ptr %ws",
            "ptr %kept",
            "ptr %lanes",
            "ptr %tables",
            "ptr %log",
            "i64 %lane.stride",
            "i64 %row.stride",
            "i64 %k0",
            "i64 %first",
            "i64 %n",
        )
        return f"{''.join(self.keys)}define i64 @run({', '.join(parameters)}) nounwind #0 {{\n{''.join(self.lines)}}}\n"

    def put(self, line: str):
        self.lines.append(f"  {line}\n")

    def label(self, name: str):
        self.lines.append(f"{name}:\n")

    def _entry(self):
        lanes, put = self.lanes, self.put
        m, align = lanes.integer, lanes.align
        for i, signal in enumerate(self.schedule.signals):
            put(f"%s.{i} = getelementptr {lanes.number}, ptr %ws, i64 {self.layout.offsets[signal.name]}")
        put(f"%alive.bits = load {m}, ptr %lanes, align {align}")
        put(f"%alive = icmp ne {m} %alive.bits, {'0' if lanes.width == 1 else 'zeroinitializer'}")
        put(f"%keys.at = getelementptr {m}, ptr %lanes, i64 1")
        put(f"%keys = load {m}, ptr %keys.at, align {align}")
        put(f"%failed.at = getelementptr {m}, ptr %lanes, i64 2")
        put("%begin = icmp slt i64 %first, %n")
        put("br i1 %begin, label %tick, label %finished")
        self.label("tick")
        put("%i = phi i64 [%first, %0], [%i.next, %go.on]")
        put("%k = add i64 %k0, %i")

    def _id(self, name: str) -> int:
        return next(i for i, s in enumerate(self.schedule.signals) if s.name == name)

    def _pointer(self, name: str) -> str:
        return f"ptr %s.{self._id(name)}"

    def _input(self, position: int, signal: Signal):
        put = self.put
        put(f"%table.at{position} = getelementptr ptr, ptr %tables, i64 {position}")
        put(f"%table{position} = load ptr, ptr %table.at{position}, align 8")
        put(f"%entry{position} = mul i64 %i, {signal.size}")
        put(f"%row{position} = getelementptr double, ptr %table{position}, i64 %entry{position}")
        put(f"call void @spread({self._pointer(signal.name)}, ptr %row{position}, i64 {signal.size})")

    def _noise(self, signal: Signal):
        if not signal.size:
            return
        keys = noise.pair_keys(signal.name, signal.size)
        words = ", ".join(f"i64 {key - (1 << 64) if key >> 63 else key}" for key in keys)
        name = f"@pairs.{self._id(signal.name)}"
        self.keys.append(f"{name} = internal constant [{len(keys)} x i64] [{words}], align 8\n")
        self.put(
            f"call void @normals({self._pointer(signal.name)}, ptr {name}, i64 {signal.size}, "
            f"{self.lanes.integer} %keys, i64 %k)"
        )

    def _call(self, task: Task):
        pointers = ", ".join(self._pointer(name) for name in task.reads + task.writes)
        self.put(f"call void @{self.functions[task.name]}({pointers})")

    def _periodic(self, position: int, task: Task):
        if task.every == 1:
            self._call(task)
            return
        self.put(f"%phase{position} = urem i64 %k, {task.every}")
        self.put(f"%due{position} = icmp eq i64 %phase{position}, 0")
        self.put(f"br i1 %due{position}, label %fire{position}, label %past{position}")
        self.label(f"fire{position}")
        self._call(task)
        self.put(f"br label %past{position}")
        self.label(f"past{position}")

    def _log(self):
        m, width = self.lanes.condition, self.layout.width
        self.put("%down = mul i64 %i, %row.stride")
        self.put("%row = getelementptr double, ptr %log, i64 %down")
        self.put(f"call void @scatter(ptr %row, ptr %ws, i64 %lane.stride, i64 {width})")
        self.put(f"%row.good = call {m} @finite(ptr %ws, i64 {width})")

    def _substeps(self):
        if not self.schedule.substep:
            return
        self.put("br label %substep")
        before = next(line[:-2] for line in reversed(self.lines) if not line.startswith(" "))
        self.label("substep")
        self.put(f"%j = phi i64 [0, %{before}], [%j.next, %substep]")
        for task in self.schedule.substep:
            self._call(task)
        self.put("%j.next = add i64 %j, 1")
        self.put(f"%again = icmp ult i64 %j.next, {self.schedule.substeps}")
        self.put("br i1 %again, label %substep, label %check")
        self.label("check")

    def _checks(self):
        lanes, put, schedule = self.lanes, self.put, self.schedule
        m, states = lanes.condition, self.layout.states
        count = states.stop - states.start
        put(f"%states = getelementptr {lanes.number}, ptr %ws, i64 {states.start}")
        put(f"%states.good = call {m} @finite(ptr %states, i64 {count})")
        put(f"%numbers.good = and {m} %row.good, %states.good")
        good = "%numbers.good"
        if schedule.limits:
            self._call(schedule.limits)
            limit = schedule.by_name[schedule.limit_signal]
            put(f"%limits.good = call {m} @nonnegative({self._pointer(limit.name)}, i64 {limit.size})")
            put(f"%good = and {m} %numbers.good, %limits.good")
            good = "%good"
        put(f"%bad = xor {m} {good}, {lanes.constant('true', 'i1')}")
        put(f"%failed = and {m} %bad, %alive")
        self.lines.append(lanes.any("%failed", "%stop"))
        put("br i1 %stop, label %failure, label %go.on")
        self.label("failure")
        put(f"%failed.bits = sext {m} %failed to {lanes.integer}")
        put(f"store {lanes.integer} %failed.bits, ptr %failed.at, align {lanes.align}")
        put("ret i64 %i")
        self.label("go.on")
        put(f"call void @keep(ptr %states, ptr %kept, i64 {count}, {m} %alive)")
        put("%i.next = add i64 %i, 1")
        put("%more = icmp slt i64 %i.next, %n")
        put("br i1 %more, label %tick, label %finished")
        self.label("finished")
        put("ret i64 %n")
