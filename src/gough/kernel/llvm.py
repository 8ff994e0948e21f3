"""A tape as an LLVM function: `void name(ptr in0, ptr in1, ..., ptr out0, ...)`, entry k of a signal W numbers wide.

Every value is one register of W lanes.  All stores come last, so a task may read and write the same signal.  No
fast-math flag is ever set: `nnan` would delete the checks for NaN.
"""

from __future__ import annotations

from . import ops
from .lanes import Calls, Lanes
from .tape import Tape, is_binary

_INTRINSIC = {"sqrt": "sqrt", "fabs": "fabs", "floor": "floor", "ceil": "ceil", "copysign": "copysign"}
_FUSIBLE = {"add": "fadd", "sub": "fsub", "mul": "fmul"}
_COMPARE = {"lt": "olt", "le": "ole", "eq": "oeq", "ne": "une"}
_ONE, _MINUS_ONE, _ZERO = "0x3FF0000000000000", "0xBFF0000000000000", "0x0000000000000000"


def declarations(lanes: Lanes) -> str:
    """The intrinsics that functions use."""
    v, suffix = lanes.number, lanes.suffix()
    return "".join(
        f"declare {v} @llvm.{name}.{suffix}({v}{', ' + v if name == 'copysign' else ''})\n"
        for name in _INTRINSIC.values()
    )


def function(tape: Tape, name: str, lanes: Lanes, calls: Calls) -> str:
    """The text of one function."""
    return _Printer(tape, lanes, calls).text(name)


class _Printer:
    def __init__(self, tape: Tape, lanes: Lanes, calls: Calls):
        self.tape, self.lanes, self.calls = tape, lanes, calls
        self.lines: list[str] = []
        self.conditions: dict[int, str] = {}  # value number -> register that holds it as a condition
        self.flags = "" if tape.exact else lanes.flags
        self.zero = lanes.constant(_ZERO)
        self.one = lanes.constant(_ONE)

    def text(self, name: str) -> str:
        tape = self.tape
        pointers = [f"ptr %i{i}" for i in range(len(tape.inputs))] + [f"ptr %o{j}" for j in range(len(tape.outputs))]
        for n, (op, a, b) in enumerate(tape.nodes):
            if op == "input":
                self._load(n, a, b)
            elif op != "const":
                self._operation(n, op, a, b)
        for j, numbers in enumerate(tape.results):
            for k, n in enumerate(numbers):
                self._put(f"%o{j}.{k} = getelementptr inbounds {self.lanes.number}, ptr %o{j}, i64 {k}")
                self._put(f"store {self.lanes.number} {self.value(n)}, ptr %o{j}.{k}, align {self.lanes.align}")
        body = "".join(self.lines)
        return f"define internal void @{name}({', '.join(pointers)}) noinline nounwind #0 {{\n{body}  ret void\n}}\n"

    def value(self, n: int) -> str:
        op, bits, _ = self.tape.nodes[n]
        return self.lanes.constant(f"0x{bits:016X}") if op == "const" else f"%v{n}"

    def condition(self, n: int) -> str:
        """The register that is true where value n is not 0."""
        if n not in self.conditions:
            self.conditions[n] = f"%c{n}"
            self._put(f"%c{n} = fcmp une {self.lanes.number} {self.value(n)}, {self.zero}")
        return self.conditions[n]

    def _put(self, line: str):
        self.lines.append(f"  {line}\n")

    def _load(self, n: int, i: int, k: int):
        v = self.lanes.number
        self._put(f"%p{n} = getelementptr inbounds {v}, ptr %i{i}, i64 {k}")
        self._put(f"%v{n} = load {v}, ptr %p{n}, align {self.lanes.align}")

    def _operation(self, n: int, op: str, a: int, b: int):
        v, x = self.lanes.number, self.value(a)
        y = self.value(b) if is_binary(op) else None
        if op in _FUSIBLE:
            # a b - c d with one product rounded and the other not is no longer 0 where a b = c d: sqrt would give NaN
            both = op == "sub" and all(self.tape.nodes[k][0] in ("mul", "sq") for k in (a, b))
            self._put(f"%v{n} = {_FUSIBLE[op]} {'' if both else self.flags}{v} {x}, {y}")
        elif op == "sq":
            self._put(f"%v{n} = fmul {self.flags}{v} {x}, {x}")
        elif op == "twice":
            self._put(f"%v{n} = fadd {self.flags}{v} {x}, {x}")
        elif op == "div":
            self._put(f"%v{n} = fdiv {v} {x}, {y}")
        elif op == "inv":
            self._put(f"%v{n} = fdiv {v} {self.one}, {x}")
        elif op == "neg":
            self._put(f"%v{n} = fneg {v} {x}")
        elif op in _INTRINSIC:
            arguments = ", ".join(f"{v} {z}" for z in ((x,) if y is None else (x, y)))
            self._put(f"%v{n} = call {v} @llvm.{_INTRINSIC[op]}.{self.lanes.suffix()}({arguments})")
        elif op in ops.LOGICAL:
            self._logical(n, op, a, b, x, y)
        elif op in ops.LIBM:
            arguments = ", ".join(f"{v} {z}" for z in ((x,) if y is None else (x, y)))
            self._put(f"%v{n} = call {v} {self.calls.name(op, self.tape.exact)}({arguments})")
        else:
            self._choice(n, op, a, x, y)

    def _logical(self, n: int, op: str, a: int, b: int, x: str, y: str | None):
        m = self.lanes.condition
        if op in _COMPARE:
            self._put(f"%c{n} = fcmp {_COMPARE[op]} {self.lanes.number} {x}, {y}")
        elif op == "not":
            self._put(f"%c{n} = xor {m} {self.condition(a)}, {self.lanes.constant('true', 'i1')}")
        else:
            first, second = self.condition(a), self.condition(b)
            self._put(f"%c{n} = {op} {m} {first}, {second}")
        self.conditions[n] = f"%c{n}"
        self._select(n, f"%c{n}", self.one, self.zero)

    def _choice(self, n: int, op: str, a: int, x: str, y: str | None):
        v, m = self.lanes.number, self.lanes.condition
        if op == "if_else_zero":
            self._select(n, self.condition(a), y, self.zero)
        elif op in ("fmin", "fmax"):
            self._put(f"%w{n} = fcmp {'olt' if op == 'fmin' else 'ogt'} {v} {y}, {x}")
            self._put(f"%u{n} = fcmp uno {v} {x}, {x}")
            self._put(f"%s{n} = or {m} %w{n}, %u{n}")
            self._select(n, f"%s{n}", y, x)
        elif op == "sign":
            self._put(f"%w{n} = fcmp olt {v} {x}, {self.zero}")
            self._put(f"%u{n} = fcmp ogt {v} {x}, {self.zero}")
            self._put(f"%s{n} = select {m} %u{n}, {v} {self.one}, {v} {x}")
            self._select(n, f"%w{n}", self.lanes.constant(_MINUS_ONE), f"%s{n}")
        else:
            raise NotImplementedError(op)  # ops.py has an operation that this page does not: a mistake of ours

    def _select(self, n: int, condition: str, yes: str, no: str):
        v = self.lanes.number
        self._put(f"%v{n} = select {self.lanes.condition} {condition}, {v} {yes}, {v} {no}")
