"""A tape as a C99 function: `void name(const double in0[], ..., double out0[], ...)`.

Operation by operation in the order of the tape, each rounded once, as one lane of the kernel computes it: the same bits
come out where the same libm is linked and nothing is fused (-ffp-contract=off, which -std=c99 implies for gcc).
Values live in as few local doubles as are needed at once, so that the frame stays below 2.5 kB also where nothing is
optimised.  All results are stored last: an output may be the array of an input.  No loop, no branch but a choice
between two numbers, no memory of its own.
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Sequence

from ...errors import InputError
from ...kernel import ops
from ...kernel.tape import Tape, constant, is_binary

WIDTH = 110  # of a line of C; only lists of names are broken
LOCAL = 150  # doubles of a function that has `work` for the rest
MOST_LIVE = 320  # of one that has not: 2.6 kB where a compiler keeps every one in memory

_INFIX = {"add": "+", "sub": "-", "mul": "*", "div": "/"}
_COMPARE = {"lt": "<", "le": "<=", "eq": "==", "ne": "!="}
_PLAIN = {"sqrt", "fabs", "floor", "ceil", "copysign"}


def number(value: float) -> str:
    """A double in C, exact: hexadecimal, or a macro of math.h."""
    if math.isnan(value):
        return "NAN"
    if math.isinf(value):
        return "INFINITY" if value > 0 else "(-INFINITY)"
    if value == int(value) and abs(value) < 1e6:
        text = f"{value:.1f}"
    else:
        head, _, exponent = value.hex().partition("p")
        text = f"{head.rstrip('0').rstrip('.')}p{exponent}"
    return f"({text})" if text.startswith("-") else text


def parameters(tape: Tape, inputs: Sequence[str], outputs: Sequence[str]) -> list[str]:
    """The parameters of the C function; inputs and outputs without entries have none."""
    given = [f"const double {n}[{size}]" for n, size in zip(inputs, tape.inputs, strict=True) if size]
    return given + [f"double {n}[{size}]" for n, size in zip(outputs, tape.outputs, strict=True) if size]


def function(
    tape: Tape, name: str, inputs: Sequence[str], outputs: Sequence[str], static: bool = True, work: bool = False
) -> str:
    """The text of one function; `inputs` and `outputs` name its parameters.

    With `work` it has a last parameter, `double work[]` of `spilled(tape)` entries, for values beyond `LOCAL`.

    Raises
    ------
    InputError
        without `work`: more values at once than the frame of a real-time function has place for.
    """
    local = LOCAL if work else MOST_LIVE
    lines, slots = _body(tape, inputs, outputs, local)
    listed = parameters(tape, inputs, outputs)
    if work:
        listed.append("double work[]")
    elif slots > MOST_LIVE:
        raise InputError(
            f"{name} needs too many values at once for a frame of {8 * MOST_LIVE} B", value=str(slots),
            cure="split the function",
        )  # fmt: skip
    used = {a for op, a, _ in tape.nodes if op == "input"}
    idle = [n for k, n in enumerate(inputs) if tape.inputs[k] and k not in used]
    idle += ["work"] if work and slots <= LOCAL else []
    head = f"{'static ' if static else ''}void {name}("
    names = wrapped(", ".join(f"r{k}" for k in range(min(slots, local))), 11)
    body = [f"    double {names};\n"] if slots else []
    body += [f"    (void){n};\n" for n in idle]
    return f"{head}{wrapped(', '.join(listed) or 'void', len(head))})\n{{\n{''.join(body + lines)}}}\n"


def spilled(tape: Tape) -> int:
    """How many entries `work` must have."""
    return max(0, _body(tape, ["x"] * len(tape.inputs), ["y"] * len(tape.outputs), LOCAL)[1] - LOCAL)


def wrapped(text: str, indent: int) -> str:
    words, lines, at = text.split(", "), [""], indent
    for k, word in enumerate(words):
        piece = word + (", " if k < len(words) - 1 else "")
        if at + len(piece) > WIDTH and lines[-1]:
            lines.append("")
            at = indent
        lines[-1] += piece
        at += len(piece)
    return ("\n" + " " * indent).join(line.rstrip() for line in lines)


def _body(tape: Tape, inputs, outputs, local: int):
    """The statements, and how many local doubles they take."""
    ends = _last_uses(tape)
    # an input that is an output itself is read before anything is stored
    early = {n for numbers in tape.results for n in numbers if tape.nodes[n][0] == "input"}
    place: dict[int, str] = {}
    slot_of: dict[int, int] = {}
    free: list[int] = []  # a heap: the lowest first
    slots = 0
    lines = []
    for n, (op, a, b) in enumerate(tape.nodes):
        if op == "const":
            place[n] = number(constant(a))
            continue
        if op == "input" and n not in early:
            place[n] = f"{inputs[a]}[{b}]"
            continue
        used = () if op == "input" else (a, b) if is_binary(op) else (a,)
        text = _expression(op, *(place[k] for k in used)) if used else f"{inputs[a]}[{b}]"
        for k in dict.fromkeys(used):
            if ends[k] == n and k in slot_of:
                heapq.heappush(free, slot_of[k])
        if not free:
            heapq.heappush(free, slots)
            slots += 1
        slot_of[n] = slot = heapq.heappop(free)
        place[n] = f"r{slot}" if slot < local else f"work[{slot - local}]"
        lines.append(f"    {place[n]} = {text};\n")
    for j, numbers in enumerate(tape.results):
        lines += [f"    {outputs[j]}[{k}] = {place[n]};\n" for k, n in enumerate(numbers)]
    return lines, slots


def _last_uses(tape: Tape) -> dict[int, int]:
    last: dict[int, int] = {}
    for n, (op, a, b) in enumerate(tape.nodes):
        if op not in ("input", "const"):
            last[a] = n
            if is_binary(op):
                last[b] = n
    for numbers in tape.results:
        for n in numbers:
            last[n] = len(tape.nodes)
    return last


def _expression(op: str, x: str, y: str = "") -> str:
    """One operation in C: what `kernel.ops.scalar` says of it."""
    if op in _INFIX:
        return f"{x} {_INFIX[op]} {y}"
    if op in ops.LIBM or op in _PLAIN:
        return f"{op}({x}, {y})" if y else f"{op}({x})"
    if op in _COMPARE:
        return f"{x} {_COMPARE[op]} {y} ? 1.0 : 0.0"
    return _OTHER[op].format(x=x, y=y)


_OTHER = {
    "neg": "-{x}",
    "sq": "{x} * {x}",
    "twice": "{x} + {x}",
    "inv": "1.0 / {x}",
    "not": "{x} == 0.0 ? 1.0 : 0.0",
    "and": "{x} != 0.0 && {y} != 0.0 ? 1.0 : 0.0",
    "or": "{x} != 0.0 || {y} != 0.0 ? 1.0 : 0.0",
    "if_else_zero": "{x} == 0.0 ? 0.0 : {y}",
    "sign": "{x} < 0.0 ? -1.0 : {x} > 0.0 ? 1.0 : {x}",
    "fmin": "{y} < {x} || {x} != {x} ? {y} : {x}",
    "fmax": "{y} > {x} || {x} != {x} ? {y} : {x}",
}
