"""The numbers of a machine or a law in C: put into the code, or an argument `theta` with the sheet's as a table.

With an argument every public function takes `const double theta[]` first (a step behind its state), so that one code
serves every machine of the same structure, and numbers may change while it runs.
"""

from __future__ import annotations

import re

from ...declare import Part
from ...errors import ExperimentError, did_you_mean
from .printer import number

WAYS = ("constant", "argument")


def check_way(way: str) -> bool:
    """Whether theta is an argument.

    Raises
    ------
    ExperimentError
        `way` is none of WAYS.
    """
    if way not in WAYS:
        cure = did_you_mean(str(way), WAYS)
        raise ExperimentError("theta is a constant or an argument", key="theta", value=ascii(way)[:60], cure=cure)
    return way == "argument"


def threaded(text: str, name: str, count: int) -> str:
    """C text of a machine's functions with theta handed on from each to each."""
    ours = "inverse|forward|jacobian|limits|inverse_dynamics|search"
    text = re.sub(rf"\b({name}_\w+_of\()", r"\1theta, ", text)
    text = re.sub(rf"\b({name}_(?:{ours})\()(?=const double)", rf"\1const double theta[{count}], ", text)
    return re.sub(rf"\b({name}_(?:{ours})\()(?!const double|\.)", r"\1theta, ", text)


def declaration(name: str, part: Part) -> str:
    """The table of the default numbers in the header, and which entry is what."""
    upper = name.upper()
    lines = "".join(f"   {k:4d} {entry}\n" for k, entry in enumerate(part.names))
    return (
        f"/* theta: the numbers of {getattr(part, 'name', name)}, SI, in this order:\n{lines}   */\n"
        f"#define {upper}_THETA {len(part.names)}\nextern const double {name}_theta[{len(part.names)}];\n\n"
    )


def table(name: str, part: Part) -> str:
    """The table itself."""
    lines = ",\n".join(f"    {number(v)} /* {entry} */" for v, entry in zip(part.theta, part.names, strict=True))
    return f"const double {name}_theta[{len(part.names)}] = {{\n{lines}}};\n\n"
