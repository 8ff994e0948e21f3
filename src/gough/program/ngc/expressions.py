"""Values in NC programs as flat programs for a stack, carried out as often as their line runs; compiler.py makes them.

The stack machine does not recurse: brackets may be nested as deep as a line is long.
"""

from __future__ import annotations

from typing import NamedTuple

from ...errors import ProgramError
from .functions import arctangent
from .parameters import Parameters

# what a step of a program does
CONSTANT, DIRECT, NUMBERED, NAMED, NEGATE, FUNCTION, OPERATION, ARCTANGENT, EXISTS, EXISTS_NAMED = range(10)
PLAIN = 5000  # parameters up to this number are nobody's but the program's


class Program(NamedTuple):
    """A compiled value: steps (what to do, with what) in the order of doing, and how it was written."""

    steps: tuple[tuple[int, object], ...]
    text: str


def evaluate(program: Program, parameters: Parameters) -> float:
    """Carry out a program.

    Raises
    ------
    ProgramError
        without file and line: a division by zero, a parameter that is not there, and the like.
    """
    stack: list[float] = []
    push, pop, numbers = stack.append, stack.pop, parameters.numbers
    try:
        for what, arg in program.steps:
            if what == CONSTANT:
                push(arg)
            elif what == DIRECT:
                push(numbers[arg])
            elif what == OPERATION:
                b = pop()
                value = arg(stack[-1], b)
                if value - value != 0:  # infinite or NaN
                    raise ProgramError("a number that is too large", cure="check the numbers in this expression")
                stack[-1] = value
            elif what == NUMBERED:
                stack[-1] = parameters.get(stack[-1])
            elif what == NAMED:
                push(parameters.get_named(arg))
            elif what == NEGATE:
                stack[-1] = -stack[-1]
            elif what == FUNCTION:
                stack[-1] = arg(stack[-1])
            elif what == ARCTANGENT:
                b = pop()
                stack[-1] = arctangent(stack[-1], b)
            elif what == EXISTS:
                stack[-1] = 1.0 if parameters.exists(stack[-1]) else 0.0
            else:
                push(1.0 if parameters.exists_named(arg) else 0.0)
    except ProgramError as error:
        raise error.at(value=show(program.text)) from None
    return stack[0]


def show(text: str) -> str:
    """A piece of a program in quotes, shortened."""
    text = text.strip()
    return repr(text if len(text) <= 30 else text[:27] + "...")
