"""Random expressions of the NC language with their value, as text that every reader must understand alike."""

from __future__ import annotations

import math

# names as LinuxCNC writes them; values in degrees
_FUNCTIONS = {
    "ABS": abs,
    "ACOS": lambda v: math.degrees(math.acos(v)),
    "ASIN": lambda v: math.degrees(math.asin(v)),
    "COS": lambda v: math.cos(math.radians(v)),
    "EXP": math.exp,
    "FIX": math.floor,
    "FUP": math.ceil,
    "ROUND": lambda v: math.floor(abs(v) + 0.5) * math.copysign(1, v),
    "LN": math.log,
    "SIN": lambda v: math.sin(math.radians(v)),
    "SQRT": math.sqrt,
    "TAN": lambda v: math.tan(math.radians(v)),
}
# of the argument: between these the function is smooth and small enough
_SAFE = {
    "ACOS": (-0.95, 0.95), "ASIN": (-0.95, 0.95), "EXP": (-3, 3), "LN": (0.1, 90), "SQRT": (0.1, 90), "TAN": (-80, 80),
}  # fmt: skip
OPERATORS = ("+", "-", "*", "/", "**", "MOD", "EQ", "NE", "GT", "GE", "LT", "LE", "AND", "OR", "XOR")
FUNCTIONS = (*_FUNCTIONS, "ATAN", "EXISTS")


def number(rng, value: float, digits: int = 4) -> str:
    """`value`, rounded, in one of the ways of writing a number."""
    text = f"{value:.{digits}f}"
    style = rng.integers(6)
    if style == 0 and "." in text:
        text = text.rstrip("0")  # "3."
    elif style == 1:
        text = text.replace("0.", ".", 1) if text.lstrip("-").startswith("0.") else text
    elif style == 2 and value >= 0:
        text = "+" + text
    elif style == 3:
        text = ("-0" + text[1:]) if text.startswith("-") else "0" + text
    return text


def chain(rng, names=()) -> str:
    """A flat chain of operators without brackets: whoever reads it needs the same precedence.  Its value is not told;
    as "[...] MOD 40" it is in [0, 40)."""
    parts = [operand(rng, names)]
    for _ in range(rng.integers(2, 6)):
        op = str(rng.choice(OPERATORS))
        if op == "**":  # of a positive number, so that it has a value; a power of a power runs away
            parts[-1] = number(rng, rng.uniform(0.5, 9.5), 2)
        parts += [op, number(rng, rng.uniform(0.5, 1.5), 2) if op in ("**", "/", "MOD") else operand(rng, names)]
    return f"[[{' '.join(parts)}] MOD 40]"


def operand(rng, names) -> str:
    """A number, a parameter, or a function of one."""
    kind = rng.integers(4)
    if kind == 0 and names:
        return str(rng.choice(list(names)))
    if kind == 1:
        return tree(rng, 0)[0][1:-1]
    return number(rng, rng.uniform(0.5, 9.5), int(rng.integers(0, 4)))


def tree(rng, depth: int = 2) -> tuple[str, float]:
    """A bracketed expression and its value, all smooth there: rounding cannot make two readers differ by a step."""
    while True:
        text, value = _tree(rng, depth)
        if math.isfinite(value) and abs(value) < 1e4:
            return text, value


def _tree(rng, depth):
    kind = rng.integers(4) if depth > 0 else rng.integers(2)
    if kind == 0:
        value = round(float(rng.uniform(-20, 20)), 3)
        return f"[{number(rng, value, 3)}]", value
    if kind == 1:
        return _function(rng, depth)
    (a, va), (b, vb) = _tree(rng, depth - 1), _tree(rng, depth - 1)
    op = str(rng.choice(["+", "-", "*", "/", "**"]))
    if op == "/" and abs(vb) < 0.1 or op == "**" and not (va > 0.1 and abs(vb) < 3):
        op = "+"
    value = {"+": va + vb, "-": va - vb, "*": va * vb, "/": va / vb if vb else 0.0, "**": 0.0}[op]
    if op == "**":
        value = va**vb
    return f"[{a} {op} {b}]", value


def _function(rng, depth):
    if rng.integers(6) == 0:
        y, x = round(float(rng.uniform(-9, 9)), 2) + 0.005, round(float(rng.uniform(0.1, 9)), 2)
        return f"[ATAN[{y:.3f}]/[{x:.2f}]]", math.degrees(math.atan2(y, x))
    if rng.integers(12) == 0:
        return "[EXISTS[#<_never_set>]]", 0.0
    name = str(rng.choice(list(_FUNCTIONS)))
    low, high = _SAFE.get(name, (-20, 20))
    argument = round(float(rng.uniform(low, high)), 2) + 0.003  # off the steps of FIX FUP ROUND
    text = f"[{argument:.3f}]"
    if depth > 0 and name in ("SIN", "COS", "ABS"):
        text, argument = _tree(rng, depth - 1)
    return f"[{name}{text}]", float(_FUNCTIONS[name](argument))
