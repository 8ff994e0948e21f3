"""README and Makefile of an export."""

from __future__ import annotations

from ...machine.base import Machine
from . import solver_text
from .machine_functions import closed_form
from .step_text import Stepped

_MAKE = """# make test: the self-test; CC=clang, CFLAGS=... as you like, but never -ffast-math
CC      ?= gcc
CFLAGS  ?= -O2
STRICT  := -std=c99 -Wall -Wextra -Wpedantic -Wconversion -ffp-contract=off
SOURCES := {sources}

.PHONY: test clean

test: {name}_test
\t./{name}_test

{name}_test: $(SOURCES) {name}_test.c $(SOURCES:.c=.h)
\t@command -v $(firstword $(CC)) >/dev/null || {{ echo "no C compiler $(CC): install gcc, or make CC=..."; exit 1; }}
\t$(CC) $(STRICT) $(CFLAGS) -o $@ $(SOURCES) {name}_test.c -lm

clean:
\trm -f {name}_test
"""


def makefile(name: str, stepped: list[str]) -> str:
    """The Makefile: builds and runs the self-test."""
    return _MAKE.format(name=name, sources=" ".join(f"{n}.c" for n in (name, *stepped)))


def readme(name: str, machine: Machine, stepped: list[Stepped], argument: bool = False) -> str:
    """README.md."""
    lines = [
        f"# {name}: {machine.name} in C99",
        "",
        "Written by `gough export --target c`. Plain C99 and libm: no allocation, no global state, every loop bounded,",
        "every function returns a status, and NaN or infinity goes neither in nor out unsaid. Units are SI (m, rad, s,",
        "kg, N); the headers say unit and frame of every argument.",
        "",
        f"- `{name}.h`: `{name}_` with `inverse`, `forward`, `jacobian`, `limits`, `inverse_dynamics`",
        *(
            f"- `{one.name}.h`: `{one.name}_start`, `{one.name}_step`, every {one.period:g} s: {one.what}"
            for one in stepped
        ),
        f"- `{name}_test.c`: what Python gave, and what C gives; `make test`",
        "",
        _forward(name, machine),
        "",
        "The operations are those of the simulation, in its order, each rounded once. With the same libm, without",
        "-ffast-math and with -ffp-contract=off, `inverse`, `jacobian`, `inverse_dynamics` and every `step` give the",
        "bits of a simulation of one lane (several lanes fuse products and sums, and differ in the last digits);",
        "-std=c99 turns fusing off in gcc, -std=gnu99 does not where the processor can fuse. The forward kinematics",
        "is written anew and agrees to 1e-12.",
        "",
        "Numbers are an argument, `theta`; the tables `*_theta` are those of the sheet, in the order of the headers."
        if argument
        else "Numbers of the machine stand in the code; with --theta argument they would be an argument.",
    ]
    return "\n".join(lines) + "\n"


def _forward(name: str, machine: Machine) -> str:
    if closed_form(machine):
        return f"`{name}_forward` is a closed form."
    return (
        f"`{name}_forward` takes the last good pose and gives the next, or a status and leaves the pose as it was. It\n"
        "is Newton's method with steps held back, and never crosses a singularity; it evaluates its equations at most\n"
        f"{solver_text.MOST} times from the pose and, where that is no start, {solver_text.MOST} times from home.\n"
        "After a status that says the machine is too near to a singular pose, stop: joints alone do not tell on which\n"
        "side of it a machine comes out."
    )
