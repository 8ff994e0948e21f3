"""The arithmetic of NC programs: functions in degrees, comparisons, powers; every result is finite.

Angles whose functions are short decimals give exactly those (SIN[30] = 0.5, COS[90] = 0, ACOS[0.5] = 60): programs put
them through FIX and ROUND and into conditions, where the last bit of a rounded result would count.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from ...errors import ProgramError

EQUAL = 1e-4  # numbers that differ by less are EQ; LinuxCNC's bound, also for what must be a whole number

_SINE = {0.0: 0.0, 30.0: 0.5, 90.0: 1.0, 150.0: 0.5, 180.0: 0.0}
_COSINE = {0.0: 1.0, 60.0: 0.5, 90.0: 0.0, 120.0: -0.5, 180.0: -1.0}
_ARCSINE = {-0.5: -30.0, 0.5: 30.0}
_ARCCOSINE = {-0.5: 120.0, 0.5: 60.0}


def sine(angle: float) -> float:
    folded = math.remainder(angle, 360.0)
    exact = _SINE.get(abs(folded))
    return math.sin(math.radians(folded)) if exact is None else math.copysign(exact, folded)


def cosine(angle: float) -> float:
    folded = abs(math.remainder(angle, 360.0))
    exact = _COSINE.get(folded)
    return math.cos(math.radians(folded)) if exact is None else exact


def tangent(angle: float) -> float:
    folded = math.remainder(angle, 180.0)
    if abs(folded) == 90.0:
        raise ProgramError("TAN has no value at a right angle", cure="check the angle, in degrees")
    return math.copysign(1.0, folded) if abs(folded) == 45.0 else math.tan(math.radians(folded))


def arcsine(value: float) -> float:
    if not -1.0 <= value <= 1.0:
        raise ProgramError("ASIN needs a number from -1 to 1", cure="check what stands in its brackets")
    exact = _ARCSINE.get(value)
    return math.degrees(math.asin(value)) if exact is None else exact


def arccosine(value: float) -> float:
    if not -1.0 <= value <= 1.0:
        raise ProgramError("ACOS needs a number from -1 to 1", cure="check what stands in its brackets")
    exact = _ARCCOSINE.get(value)
    return math.degrees(math.acos(value)) if exact is None else exact


def arctangent(y: float, x: float) -> float:
    """ATAN[y]/[x], deg, in the quadrant of (x, y)."""
    return math.degrees(math.atan2(y, x))


def exponential(value: float) -> float:
    try:
        return math.exp(value)
    except OverflowError:
        raise ProgramError("EXP gives a number that is too large", cure="at most EXP[709]") from None


def logarithm(value: float) -> float:
    if not value > 0:
        raise ProgramError("LN needs a number above 0", cure="check what stands in its brackets")
    return math.log(value)


def root(value: float) -> float:
    if value < 0:
        raise ProgramError("the square root of a negative number", cure="check what stands in its brackets")
    return math.sqrt(value)


def rounded(value: float) -> float:
    """To the nearest whole number, halves away from zero."""
    whole = float(math.trunc(value))
    return whole + math.copysign(1.0, value) if abs(value - whole) >= 0.5 else whole


def down(value: float) -> float:
    return float(math.floor(value))


def up(value: float) -> float:
    return float(math.ceil(value))


def divided(a: float, b: float) -> float:
    if b == 0:
        raise ProgramError("a division by zero", cure="check the divisor")
    return a / b


def modulo(a: float, b: float) -> float:
    """What is left of a, from 0 to below |b|, whatever the signs."""
    if b == 0:
        raise ProgramError("MOD by zero", cure="check the divisor")
    left = math.fmod(a, b)
    return left + abs(b) if left < 0 else left


def power(a: float, b: float) -> float:
    if a < 0 and not b.is_integer():
        raise ProgramError(
            "a negative number to a power that is not whole", cure="check the base, or use a whole power"
        )
    if a == 0 and b < 0:
        raise ProgramError("zero to a negative power", cure="check the base")
    try:
        return math.pow(a, b)
    except OverflowError:
        raise ProgramError("a number that is too large", cure="check the power") from None


UNARY: dict[str, Callable[[float], float]] = {
    "ABS": abs, "ACOS": arccosine, "ASIN": arcsine, "COS": cosine, "EXP": exponential, "FIX": down, "FUP": up,
    "LN": logarithm, "ROUND": rounded, "SIN": sine, "SQRT": root, "TAN": tangent,
}  # fmt: skip

# operation: how tightly it binds, and what it does; operations that bind alike are done from the left, ** as well
BINARY: dict[str, tuple[int, Callable[[float, float], float]]] = {
    "**": (5, power),
    "*": (4, lambda a, b: a * b),
    "/": (4, divided),
    "MOD": (4, modulo),
    "+": (3, lambda a, b: a + b),
    "-": (3, lambda a, b: a - b),
    "EQ": (2, lambda a, b: 1.0 if abs(a - b) < EQUAL else 0.0),
    "NE": (2, lambda a, b: 0.0 if abs(a - b) < EQUAL else 1.0),
    "GT": (2, lambda a, b: 1.0 if a > b else 0.0),
    "GE": (2, lambda a, b: 1.0 if a >= b else 0.0),
    "LT": (2, lambda a, b: 1.0 if a < b else 0.0),
    "LE": (2, lambda a, b: 1.0 if a <= b else 0.0),
    "AND": (1, lambda a, b: 1.0 if a != 0 and b != 0 else 0.0),
    "OR": (1, lambda a, b: 1.0 if a != 0 or b != 0 else 0.0),
    "XOR": (1, lambda a, b: 1.0 if (a != 0) != (b != 0) else 0.0),
}  # fmt: skip


def whole(value: float) -> int | None:
    """The whole number that `value` is meant to be, or None."""
    if not math.isfinite(value):
        return None
    nearest = round(value)
    return nearest if abs(value - nearest) < EQUAL else None
