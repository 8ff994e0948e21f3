"""Functions of CasADi as a C file and its header: the plainest use of the printer, for other exports."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import casadi as ca
import numpy as np

from ...kernel.tape import Tape, trace
from . import printer
from .fold import baked
from .names import identifier

HEAD = """/* {what}
   Made by gough {version}; do not edit.  Units SI: m, rad, s, kg, N.  C99, no allocation, no
   state of its own; every array is the caller's.  Compile without -ffast-math and with -ffp-contract=off. */
"""
CONTRACT = """#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF /* gcc has -ffp-contract=off for it */
#endif
"""


def print_functions(
    name: str, functions: Sequence[ca.Function], constants: Mapping[str, np.ndarray] | None = None
) -> tuple[str, str]:
    """C and header text of functions over SX, each called <name>_<its name>, its parameters as CasADi names them.

    `constants` {input name: its entries} are put in as numbers in every function that has an input of this name.

    Raises
    ------
    InputError
        a function that is no arithmetic, or too large for a real-time frame.
    ExperimentError
        a name that is no C identifier.
    """
    identifier(name)
    c, h = [f'#include "{name}.h"\n\n#include <math.h>\n\n{CONTRACT}'], []
    for one in functions:
        tape = constant_tape(one, constants or {})
        inputs, outputs = one.name_in(), one.name_out()
        c.append(printer.function(tape, f"{name}_{one.name()}", inputs, outputs, static=False))
        h.append(prototype(tape, f"{name}_{one.name()}", inputs, outputs))
    return head(name) + "\n".join(c), head(name) + guarded(name, "".join(h))


def constant_tape(function: ca.Function, constants: Mapping[str, np.ndarray]) -> Tape:
    """The tape of a function with the inputs named in `constants` put in."""
    values = {i: constants[n] for i, n in enumerate(function.name_in()) if n in constants}
    return baked(trace(function), values)


def prototype(tape: Tape, name: str, inputs: Sequence[str], outputs: Sequence[str]) -> str:
    """The declaration of a printed function."""
    return f"void {name}({', '.join(printer.parameters(tape, inputs, outputs)) or 'void'});\n"


def head(what: str) -> str:
    """The comment at the top of every file."""
    from ... import __version__

    return HEAD.format(what=what, version=__version__)


def guarded(name: str, text: str) -> str:
    """The body of a header that may be included twice, and by C++."""
    guard = f"{name.upper()}_H"
    return (
        f'#ifndef {guard}\n#define {guard}\n\n#ifdef __cplusplus\nextern "C" {{\n#endif\n\n{text}\n'
        f"#ifdef __cplusplus\n}}\n#endif\n\n#endif\n"
    )
