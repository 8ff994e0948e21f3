"""A tape as a C99 function: `static void name(const double *i0, ..., double *o0, ...)`, in the kernel's order of operations.

Every value is one const double, every operation what kernel/ops.py says one lane gives; so the answers are those of
the one-lane kernel to the last bit where the compiler keeps products and sums apart (-ffp-contract=off) and the C
library is the same.  All stores come last: a function may be given the same array to read and to write.
"""

from __future__ import annotations

import math

from ...kernel import ops
from ...kernel.tape import Tape, constant, is_binary

_INFIX = {"add": "+", "sub": "-", "mul": "*", "div": "/"}
_COMPARE = {"lt": "<", "le": "<=", "eq": "==", "ne": "!="}
_CALLED = {"sqrt", "fabs", "floor", "ceil", "copysign"}


def number(value: float) -> str:
    """A double as C that reads back to the same bits."""
    if math.isnan(value):
        return "NAN"
    if math.isinf(value):
        return "INFINITY" if value > 0 else "(-INFINITY)"
    text = value.hex()
    return f"({text})" if text.startswith("-") else text


def table(values) -> str:
    """Rows of an initialiser, four numbers a line."""
    texts = [number(float(value)) for value in values]
    return ",\n".join("    " + ", ".join(texts[k : k + 4]) for k in range(0, len(texts), 4))


def function(tape: Tape, name: str) -> str:
    """The text of one function, static, of what `tape` computes."""
    taken = [f"const double *i{k}" for k in range(len(tape.inputs))]
    given = [f"double *o{k}" for k in range(len(tape.outputs))]
    used = {a for op, a, _ in tape.nodes if op == "input"}
    lines = [f"static void {name}({', '.join(taken + given)})\n{{\n"]
    lines += [f"    (void)i{k};\n" for k in range(len(tape.inputs)) if k not in used]

    def value(n: int) -> str:
        op, bits, _ = tape.nodes[n]
        return number(constant(bits)) if op == "const" else f"v{n}"

    for n, (op, a, b) in enumerate(tape.nodes):
        if op == "input":
            lines.append(f"    const double v{n} = i{a}[{b}];\n")
        elif op != "const":
            lines.append(f"    const double v{n} = {_expression(op, value(a), value(b) if is_binary(op) else '')};\n")
    for j, numbers in enumerate(tape.results):
        lines += [f"    o{j}[{k}] = {value(n)};\n" for k, n in enumerate(numbers)]
    return "".join(lines) + "}\n"


def _expression(op: str, x: str, y: str) -> str:
    if op in _INFIX:
        return f"{x} {_INFIX[op]} {y}"
    if op in _COMPARE:
        return f"({x} {_COMPARE[op]} {y}) ? 1.0 : 0.0"
    if op in ops.LIBM or op in _CALLED:
        return f"{op}({x}, {y})" if y else f"{op}({x})"
    return {
        "sq": f"{x} * {x}",
        "twice": f"{x} + {x}",
        "inv": f"1.0 / {x}",
        "neg": f"-{x}",
        "not": f"({x} == 0) ? 1.0 : 0.0",
        "and": f"({x} != 0 && {y} != 0) ? 1.0 : 0.0",
        "or": f"({x} != 0 || {y} != 0) ? 1.0 : 0.0",
        "if_else_zero": f"({x} != 0) ? {y} : 0.0",
        "fmin": f"({y} < {x} || {x} != {x}) ? {y} : {x}",
        "fmax": f"({y} > {x} || {x} != {x}) ? {y} : {x}",
        "sign": f"({x} < 0) ? -1.0 : ({x} > 0) ? 1.0 : {x}",
    }[op]
