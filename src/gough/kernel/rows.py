"""One function on many rows: arrays in, arrays out, W rows at a time in machine code.

    f = compile_rows(function)
    a, b = f(x, y)                  # (N, size) or (size,) each, a row for each N; (size,) serves every row

The rows are transposed into lanes and back by the machine code itself.  What does not fill W rows is padded with
copies of the last row, so the bits of a row depend neither on N nor on its place.
"""

from __future__ import annotations

import ctypes
import warnings

import casadi as ca
import numpy as np

from ..errors import InputError
from . import lanes as lane
from .build import library, no_native, width_of
from .kernel import KernelWarning
from .tape import Tape, trace

CHUNK = 20_000_000  # operations between two chances for Ctrl-C: some 10 ms


def compile_rows(
    function: ca.Function, cache: bool = True, lanes: int | str = "auto", native: bool | str = "auto"
) -> Rows:
    """`function`, over SX, for arrays of rows.  A matrix is a row of its entries by columns.

    native="auto" takes CasADi's interpreter where there is no machine code, with one KernelWarning; True raises
    InputError instead; False asks for the interpreter.  InputError also for free symbols and for operations no kernel
    computes.
    """
    tape = trace(function)
    reason = no_native() if native else "it was asked for"
    if reason:
        if native is True:
            raise InputError("no machine code can be made", value=reason, cure='native="auto" takes the interpreter')
        if native:
            warnings.warn(
                f"{reason}: {tape.name} is interpreted, several hundred times slower", KernelWarning, stacklevel=2
            )
        return Rows(tape, _Interpreter(function), 1)
    width = width_of(lanes)
    return Rows(tape, _Native(tape, width, cache), width)


class Rows:
    """A function on rows.  `inputs` and `outputs` are the sizes of its rows."""

    def __init__(self, tape: Tape, engine, lanes: int):
        self.name, self.inputs, self.outputs = tape.name, tape.inputs, tape.outputs
        self.operations, self.lanes = tape.operations, lanes
        self._engine = engine

    def __call__(self, *arrays) -> list[np.ndarray]:
        """One array for each output, (N, size); N is 1 when every argument is one row.  InputError for other shapes."""
        if len(arrays) != len(self.inputs):
            raise InputError(f"{self.name} takes {len(self.inputs)} arrays", value=str(len(arrays)))
        rows, many = [], {}
        for i, (array, size) in enumerate(zip(arrays, self.inputs, strict=True)):
            try:
                x = np.ascontiguousarray(array, np.float64)
            except (TypeError, ValueError):
                value = type(array).__name__
                raise InputError(f"{self.name} takes numbers as argument {i}", value=value) from None
            if x.shape not in ((size,), (len(x) if x.ndim == 2 else -1, size)):
                raise InputError(f"{self.name} takes (N, {size}) or ({size},) as argument {i}", value=str(x.shape))
            if x.ndim == 2:
                many[i] = len(x)
            rows.append(x)
        if len(set(many.values())) > 1:
            text = ", ".join(f"{n} in argument {i}" for i, n in many.items())
            raise InputError(f"the arguments of {self.name} must have equally many rows", value=text)
        count = next(iter(many.values()), 1)
        results = [np.empty((count, size)) for size in self.outputs]
        whole = count - count % self.lanes
        step = max(1, CHUNK // max(1, self.operations) // self.lanes) * self.lanes
        for start in range(0, whole, step):
            stop = min(start + step, whole)
            self._engine.run(
                [x[start:stop] if x.ndim == 2 else x for x in rows], [y[start:stop] for y in results], stop - start
            )
        if whole < count:
            padded = np.minimum(np.arange(whole, whole + self.lanes), count - 1)
            tail = [np.empty((self.lanes, size)) for size in self.outputs]
            self._engine.run([x[padded] if x.ndim == 2 else x for x in rows], tail, self.lanes)
            for result, last in zip(results, tail, strict=True):
                result[whole:] = last[: count - whole]
        return results


class _Native:
    """void rows(inputs, strides, outputs, scratch, blocks): W rows a block."""

    def __init__(self, tape: Tape, width: int, cache: bool):
        self._width = width
        code, self.cached = library("rows", (tape.digest,), width, lambda lanes: _text(tape, lanes), cache)
        self._library = code  # keeps the code in memory
        pointer = ctypes.c_void_p
        self._run = ctypes.CFUNCTYPE(None, pointer, pointer, pointer, pointer, ctypes.c_int64)(code.address)
        self._scratch = sum(_room(size, width) for size in tape.inputs + tape.outputs) * width

    def run(self, inputs, outputs, count: int):
        pointer = ctypes.c_void_p
        sources = (pointer * max(1, len(inputs)))(*(x.ctypes.data for x in inputs))
        strides = (ctypes.c_int64 * max(1, len(inputs)))(*(x.shape[1] if x.ndim == 2 else 0 for x in inputs))
        targets = (pointer * max(1, len(outputs)))(*(y.ctypes.data for y in outputs))
        scratch = np.empty(self._scratch + 8)  # of this call alone: threads may share a Rows
        aligned = scratch.ctypes.data + -scratch.ctypes.data % 64
        self._run(
            ctypes.addressof(sources),
            ctypes.addressof(strides),
            ctypes.addressof(targets),
            aligned,
            count // self._width,
        )


class _Interpreter:
    def __init__(self, function: ca.Function):
        from .engines import dense

        self._function = dense(function)

    def run(self, inputs, outputs, count: int):
        shapes = [self._function.size_in(i) for i in range(self._function.n_in())]
        for n in range(count):
            arguments = [
                np.reshape(x[n] if x.ndim == 2 else x, shape, order="F")
                for x, shape in zip(inputs, shapes, strict=True)
            ]
            for y, result in zip(outputs, self._function.call([ca.DM(a) for a in arguments]), strict=True):
                y[n] = np.array(result).reshape(-1, order="F")


def _room(size: int, width: int) -> int:
    """Slots for `size` entries: transposition works on blocks of W."""
    return -(-size // width) * width


def _text(tape: Tape, lanes: lane.Lanes) -> tuple[str, dict[str, str]]:
    from . import llvm, module, parts

    calls = lane.Calls(lanes)
    body = [
        llvm.function(tape, "row", lanes, calls),
        parts.transposition(lanes, "gather"),
        parts.transposition(lanes, "scatter"),
    ]
    v, lines, slot = lanes.number, [], 0
    setup, before, after, pointers = [], [], [], []
    for i, size in enumerate(tape.inputs):
        setup.append(f"""  %s{i} = getelementptr {v}, ptr %scratch, i64 {slot}
  %a{i} = getelementptr ptr, ptr %inputs, i64 {i}
  %x{i} = load ptr, ptr %a{i}
  %b{i} = getelementptr i64, ptr %strides, i64 {i}
  %d{i} = load i64, ptr %b{i}
  %w{i} = mul i64 %d{i}, {lanes.width}
""")
        before.append(f"""  %far{i} = mul i64 %n, %w{i}
  %r{i} = getelementptr double, ptr %x{i}, i64 %far{i}
  call void @gather(ptr %s{i}, ptr %r{i}, i64 %d{i}, i64 {size})
""")
        pointers.append(f"ptr %s{i}")
        slot += _room(size, lanes.width)
    for j, size in enumerate(tape.outputs):
        setup.append(f"""  %t{j} = getelementptr {v}, ptr %scratch, i64 {slot}
  %c{j} = getelementptr ptr, ptr %outputs, i64 {j}
  %y{j} = load ptr, ptr %c{j}
""")
        after.append(f"""  %off{j} = mul i64 %n, {size * lanes.width}
  %q{j} = getelementptr double, ptr %y{j}, i64 %off{j}
  call void @scatter(ptr %q{j}, ptr %t{j}, i64 {size}, i64 {size})
""")
        pointers.append(f"ptr %t{j}")
        slot += _room(size, lanes.width)
    lines.append(
        "define void @rows(ptr %inputs, ptr %strides, ptr %outputs, ptr noalias %scratch, i64 %blocks) nounwind #0 {\n"
    )
    lines += [*setup, "  %some = icmp sgt i64 %blocks, 0\n  br i1 %some, label %block, label %end\n"]
    lines += [
        "block:\n  %n = phi i64 [0, %0], [%next, %block]\n",
        *before,
        f"  call void @row({', '.join(pointers)})\n",
        *after,
    ]
    lines.append("""  %next = add i64 %n, 1
  %more = icmp ult i64 %next, %blocks
  br i1 %more, label %block, label %end
end:
  ret void
}
""")
    head = llvm.declarations(lanes) + parts.intrinsics(lanes) + calls.text()
    return head + "".join(body) + "".join(lines) + module.attributes(lanes), calls.symbols
