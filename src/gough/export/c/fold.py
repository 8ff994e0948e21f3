"""Tapes with numbers put in: what hangs on them alone is worked out here, as one lane of the kernel would.

A number in C source that a compiler can see, it may work out itself, with another library than the one that runs:
sin(0.7) by gcc is correctly rounded, by glibc within an ulp.  So nothing of that kind is left to it.
"""

from __future__ import annotations

import dataclasses
import struct
from collections.abc import Mapping

import numpy as np

from ...kernel import ops
from ...kernel.tape import Tape, constant, is_binary, live


def baked(tape: Tape, values: Mapping[int, np.ndarray]) -> Tape:
    """The tape with `values` {input: its entries, columns first} in the places of these inputs.

    The inputs stay, with size 0.  Results are those of `tape` to the last bit.
    """
    values = {i: np.asarray(value, np.float64).reshape(-1, order="F") for i, value in values.items()}
    nodes: list[tuple[str, int, int]] = []
    known: dict[tuple[str, int, int], int] = {}
    moved: list[int] = []

    def put(node) -> int:
        if node not in known:
            known[node] = len(nodes)
            nodes.append(node)
        return known[node]

    with np.errstate(all="ignore"):
        for op, a, b in tape.nodes:
            if op == "input":
                moved.append(put(_const(values[a][b]) if a in values else (op, a, b)))
            elif op == "const":
                moved.append(put((op, a, b)))
            else:
                moved.append(put(_folded(nodes, op, moved[a], moved[b] if is_binary(op) else None)))
    results = [[moved[n] for n in numbers] for numbers in tape.results]
    nodes, results = live(nodes, results)
    sizes = tuple(0 if i in values else size for i, size in enumerate(tape.inputs))
    return dataclasses.replace(tape, inputs=sizes, nodes=tuple(nodes), results=tuple(tuple(r) for r in results))


def _folded(nodes, op, a, b):
    arguments = [a] if b is None else [a, b]
    kinds = [nodes[k][0] for k in arguments]
    if all(kind == "const" for kind in kinds):
        return _const(ops.scalar(op)(*(np.float64(constant(nodes[k][1])) for k in arguments)))
    if op == "if_else_zero" and kinds[0] == "const":
        return nodes[b] if constant(nodes[a][1]) != 0 else _const(0.0)
    return (op, a, b or 0)


def _const(value) -> tuple[str, int, int]:
    return "const", struct.unpack("<Q", struct.pack("<d", float(value)))[0], 0
