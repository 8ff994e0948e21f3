"""A casadi.Function over SX as a list of numbered values: what the machine code, the C export and the replay all print.

Two passes.  CasADi shares nothing by itself, so equal operations get one number.  Then the divisions by each value are
counted: a divisor used twice gets one reciprocal, x / d becomes x * (1 / d).  (CasADi itself turns x * (1 / y) into
x / y.)  That changes the last bit, so the floor of a quotient may differ where the quotient is a whole number to its
last bit, and x / d for a d below 5.6e-309, whose reciprocal is infinite; nothing else is rewritten.
"""

from __future__ import annotations

import hashlib
import struct
from collections import Counter
from dataclasses import dataclass
from functools import cached_property

import casadi as ca
import numpy as np

from ..errors import InputError
from . import ops

_DOUBLE, _BITS = struct.Struct("<d"), struct.Struct("<Q")


@dataclass(frozen=True, eq=False)
class Tape:
    """Values 0, 1, 2 ... : `nodes[n] = (op, a, b)`, a and b numbers of earlier values.

    ("input", i, k) is entry k of input i, ("const", bits, 0) the double with these bits; unary operations have b = 0.
    `results[j][k]` is the number of entry k of output j.  Matrices are flattened by columns, structural zeros are
    zeros.
    """

    name: str
    inputs: tuple[int, ...]  # sizes
    outputs: tuple[int, ...]
    nodes: tuple[tuple[str, int, int], ...]
    results: tuple[tuple[int, ...], ...]
    exact: bool = False  # lanes compute what one lane does, to the last bit: erfinv needs it

    @property
    def operations(self) -> int:
        """How many operations one call takes."""
        return sum(op not in ("input", "const") for op, _, _ in self.nodes)

    @cached_property
    def digest(self) -> str:
        """SHA-256 of what is computed, whatever the function is called."""
        text = repr((self.inputs, self.outputs, self.nodes, self.results, self.exact))
        return hashlib.sha256(text.encode()).hexdigest()

    def replay(self, *values) -> list[np.ndarray]:
        """The outputs, each (size,), for inputs (size,), as one lane computes them to the last bit.  Slow."""
        arrays = [np.asarray(v, np.float64).reshape(-1, order="F") for v in values]
        if [a.size for a in arrays] != list(self.inputs):
            raise InputError(f"{self.name} takes sizes {self.inputs}", value=str(tuple(a.size for a in arrays)))
        done: list[np.float64] = []
        with np.errstate(all="ignore"):
            for op, a, b in self.nodes:
                if op == "input":
                    done.append(arrays[a][b])
                elif op == "const":
                    done.append(np.float64(constant(a)))
                else:
                    arguments = (done[a], done[b]) if op in _TWO else (done[a],)
                    done.append(ops.scalar(op)(*arguments))
        return [np.array([done[n] for n in numbers], np.float64) for numbers in self.results]


_TWO = set(ops.BINARY.values())


def is_binary(op: str) -> bool:
    return op in _TWO


def constant(bits: int) -> float:
    """The double that a const node holds."""
    return _DOUBLE.unpack(_BITS.pack(bits))[0]


class _Numbers:
    """Values by number; the same operation on the same values is the same value."""

    def __init__(self):
        self.nodes: list[tuple[str, int, int]] = []
        self._known: dict[tuple[str, int, int], int] = {}

    def add(self, op: str, a: int, b: int = 0) -> int:
        if a > b and op in ops.COMMUTATIVE:
            a, b = b, a
        node = (op, a, b)
        number = self._known.get(node)
        if number is None:
            number = self._known[node] = len(self.nodes)
            self.nodes.append(node)
        return number

    def const(self, value: float) -> int:
        return self.add("const", _BITS.unpack(_DOUBLE.pack(value))[0])


def trace(function: ca.Function) -> Tape:
    """The tape of a function over SX.  InputError for free symbols and for what is no arithmetic (calls, printing)."""
    name = function.name()
    if not function.is_a("SXFunction"):
        raise InputError(
            f"{name} is no function over SX", value=function.class_name(), cure="write it with SX, or expand() it"
        )
    if function.has_free():
        raise InputError(
            f"{name} depends on symbols that are no inputs", value=", ".join(map(str, function.get_free()))
        )
    inputs = [function.sparsity_in(i) for i in range(function.n_in())]
    outputs = [function.sparsity_out(j) for j in range(function.n_out())]
    exact = any(function.instruction_id(k) == ca.OP_ERFINV for k in range(function.n_instructions()))
    numbers, results = _number(function, [_dense(s) for s in inputs], [_dense(s) for s in outputs], outputs)
    nodes, results = _share_reciprocals(*live(numbers.nodes, results))
    sizes_in, sizes_out = (tuple(s.numel() for s in sparsities) for sparsities in (inputs, outputs))
    return Tape(name, sizes_in, sizes_out, tuple(nodes), tuple(tuple(r) for r in results), exact)


def _dense(sparsity) -> list[int]:
    """Where each nonzero lies in the vector of all entries, columns first."""
    rows, columns = sparsity.get_triplet()
    return [row + column * sparsity.size1() for row, column in zip(rows, columns, strict=True)]


def _number(function, places_in, places_out, outputs):
    numbers, work = _Numbers(), {}
    zero = None
    results = []
    for sparsity in outputs:
        if sparsity.nnz() < sparsity.numel() and zero is None:
            zero = numbers.const(0.0)
        results.append([zero] * sparsity.numel())
    unary, binary = ops.UNARY, ops.BINARY
    code, source, target = function.instruction_id, function.instruction_input, function.instruction_output
    for k in range(function.n_instructions()):
        opcode = code(k)
        if opcode in binary:
            a, b = source(k)
            work[target(k)[0]] = numbers.add(binary[opcode], work[a], work[b])
        elif opcode in unary:
            work[target(k)[0]] = numbers.add(unary[opcode], work[source(k)[0]])
        elif opcode == ca.OP_INPUT:
            i, entry = source(k)
            work[target(k)[0]] = numbers.add("input", i, places_in[i][entry])
        elif opcode == ca.OP_OUTPUT:
            j, entry = target(k)
            results[j][places_out[j][entry]] = work[source(k)[0]]
        elif opcode == ca.OP_CONST:
            work[target(k)[0]] = numbers.const(function.instruction_constant(k))
        elif opcode in ops.ALIAS:
            work[target(k)[0]] = work[source(k)[0]]
        elif opcode == ca.OP_ERFINV:
            work[target(k)[0]] = _erfinv(numbers, work[source(k)[0]])
        else:
            raise _unknown(function, opcode)
    return numbers, results


def _unknown(function, opcode: int) -> InputError:
    return InputError(
        f"{function.name()} has an operation that no kernel computes",
        value=ops.opcode_name(opcode),
        cure="write it without never_inline and printme",
    )


def live(nodes, results):
    """Without the values that no output needs."""
    needed = [False] * len(nodes)
    for numbers in results:
        for n in numbers:
            needed[n] = True
    for n in range(len(nodes) - 1, -1, -1):
        op, a, b = nodes[n]
        if needed[n] and op not in ("input", "const"):
            needed[a] = True
            if op in _TWO:
                needed[b] = True
    return _rebuilt([node if keep else None for node, keep in zip(nodes, needed, strict=True)], results)


def _share_reciprocals(nodes, results):
    divisors = Counter(b if op == "div" else a for op, a, b in nodes if op in ("div", "inv"))
    return _rebuilt(nodes, results, {d for d, count in divisors.items() if count > 1})


def _rebuilt(nodes, results, shared=frozenset()):
    """Numbered anew, without the nodes that are None; a division by a value of `shared` becomes a product."""
    fresh, moved = _Numbers(), {}
    for n, node in enumerate(nodes):
        if node is None:
            continue
        op, a, b = node
        if op in ("input", "const"):
            moved[n] = fresh.add(op, a, b)
        elif op == "div" and b in shared:
            moved[n] = fresh.add("mul", moved[a], fresh.add("inv", moved[b]))
        else:
            moved[n] = fresh.add(op, moved[a], moved[b] if op in _TWO else 0)
    return fresh.nodes, [[moved[n] for n in numbers] for numbers in results]


def _erfinv(numbers: _Numbers, x: int) -> int:
    """CasADi's erfinv: a rational start in three ranges, then two Newton steps; +-inf at +-1, NaN beyond.

    The steps divide the last bits of erf by a slope that vanishes toward 1, where 4 ulp become 1e-3: lanes neither fuse
    nor take libmvec in a function with erfinv.

    Below -0.7 CasADi leaves the Newton steps out and is right to 3e-8 only; so it is here, that the two agree.
    """
    const, add = numbers.const, numbers.add

    def polynomial(z, coefficients):
        value = const(coefficients[0])
        for c in coefficients[1:]:
            value = add("add", add("mul", value, z), const(c))
        return value

    def choose(condition, value):
        return add("if_else_zero", condition, value)

    size = add("fabs", x)
    square = add("sq", x)
    above = polynomial(square, (-0.140543331, 0.914624893, -1.645349621, 0.886226899))
    below = polynomial(square, (-0.329097515, 0.012229801, 1.442710462, -2.118377725, 1.0))
    middle = add("div", add("mul", x, above), below)
    z = add("sqrt", add("neg", add("log", add("div", add("sub", const(1.0), size), const(2.0)))))
    tail = add(
        "div",
        polynomial(z, (1.641345311, 3.429567803, -1.624906493, -1.970840454)),
        polynomial(z, (1.637067800, 3.543889200, 1.0)),
    )
    low = add("lt", x, const(-0.7))
    near = add("lt", x, const(0.7))
    y = add("add", choose(near, middle), choose(add("not", near), tail))
    slope = const(2.0 / np.sqrt(np.pi))
    for _ in range(2):
        step = add("div", add("sub", add("erf", y), x), add("mul", slope, add("exp", add("neg", add("sq", y)))))
        y = add("sub", y, step)
    inside = add("lt", size, const(1.0))
    at_one = add("eq", size, const(1.0))
    value = add("add", choose(low, tail), choose(add("not", low), y))
    edge = choose(at_one, const(np.inf))
    outside = choose(add("not", add("or", inside, at_one)), const(np.nan))
    return add("copysign", add("add", add("add", choose(inside, value), edge), outside), x)
