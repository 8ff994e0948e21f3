"""Quantities at the edge: "20 mm", "3 m/min", "40 N m" <-> SI.

A closed grammar of our own, because files come from strangers (general units libraries evaluate expressions):

    quantity = number unit?          number = 12  -0.5  1e-3           at most 64 ASCII characters
    unit     = atom power? ((" " | "*" | "/") atom power?)*            each "/" divides the one atom behind it
    power    = "^"? ("-")? digit                                       m2, m^2, s-1

The dimension is the vector of exponents of (m, kg, s, A, rad).  The radian is a dimension here, so that an angle is
never taken for a number; in a compound unit (N m/rad, N m s) it does not count.  "x" is a factor and "%" a hundredth.
"""

from __future__ import annotations

import math
import re

from .errors import UnitError, did_you_mean

_TURN = 2 * math.pi

# name: (factor to SI, m, kg, s, A, rad)
_ATOMS: dict[str, tuple[float, int, int, int, int, int]] = {
    "m": (1.0, 1, 0, 0, 0, 0),
    "mm": (1e-3, 1, 0, 0, 0, 0),
    "cm": (1e-2, 1, 0, 0, 0, 0),
    "um": (1e-6, 1, 0, 0, 0, 0),
    "nm": (1e-9, 1, 0, 0, 0, 0),
    "in": (0.0254, 1, 0, 0, 0, 0),
    "kg": (1.0, 0, 1, 0, 0, 0),
    "g": (1e-3, 0, 1, 0, 0, 0),
    "s": (1.0, 0, 0, 1, 0, 0),
    "ms": (1e-3, 0, 0, 1, 0, 0),
    "us": (1e-6, 0, 0, 1, 0, 0),
    "min": (60.0, 0, 0, 1, 0, 0),
    "h": (3600.0, 0, 0, 1, 0, 0),
    "A": (1.0, 0, 0, 0, 1, 0),
    "mA": (1e-3, 0, 0, 0, 1, 0),
    "rad": (1.0, 0, 0, 0, 0, 1),
    "mrad": (1e-3, 0, 0, 0, 0, 1),
    "urad": (1e-6, 0, 0, 0, 0, 1),
    "deg": (_TURN / 360, 0, 0, 0, 0, 1),
    "arcmin": (_TURN / 360 / 60, 0, 0, 0, 0, 1),
    "arcsec": (_TURN / 360 / 3600, 0, 0, 0, 0, 1),
    "rev": (_TURN, 0, 0, 0, 0, 1),
    "rpm": (_TURN / 60, 0, 0, -1, 0, 1),
    "Hz": (1.0, 0, 0, -1, 0, 0),
    "kHz": (1e3, 0, 0, -1, 0, 0),
    "N": (1.0, 1, 1, -2, 0, 0),
    "kN": (1e3, 1, 1, -2, 0, 0),
    "mN": (1e-3, 1, 1, -2, 0, 0),
    "J": (1.0, 2, 1, -2, 0, 0),
    "W": (1.0, 2, 1, -3, 0, 0),
    "kW": (1e3, 2, 1, -3, 0, 0),
    "Pa": (1.0, -1, 1, -2, 0, 0),
    "MPa": (1e6, -1, 1, -2, 0, 0),
    "GPa": (1e9, -1, 1, -2, 0, 0),
    "x": (1.0, 0, 0, 0, 0, 0),
    "%": (1e-2, 0, 0, 0, 0, 0),
    "1": (1.0, 0, 0, 0, 0, 0),
}

# what people write for these, and what to write instead
_MEANT = {
    "t": "kg, 1 t is 1000 kg", "lb": "kg, 1 lb is 0.45359237 kg", "lbf": "N, 1 lbf is 4.4482216 N",
    "ft": "m, 1 ft is 0.3048 m", "bar": "MPa, 1 bar is 0.1 MPa", "daN": "N, 1 daN is 10 N", "sec": "s", "micron": "um",
    "mc": "um", "mu": "um", "grad": "deg, 1 grad is 0.9 deg", "l": "m3",
}  # fmt: skip
_GLUED = re.compile(r"(kN|mN|N|kg|g)(mm|cm|m)(s?)")  # Nm, kgcm2
_PLAIN = str.maketrans({"\u00b5": "u", "\u03bc": "u", "\u00b0": " deg", "\u00b2": "2", "\u00b3": "3", "\u00b7": " ",
                        "\u22c5": " ", "\u2212": "-", "\u00a0": " ", "\u202f": " "})  # fmt: skip

_NUMBER = re.compile(r"[+-]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]{1,3})?")
_ATOM = re.compile(r"([A-Za-z%]+|1)(?:\^?(-?[0-9]))?")
_LONGEST = 64

Dimension = tuple[int, int, int, int, int]


def unit(text: str) -> tuple[float, Dimension]:
    """Factor to SI and dimension of a unit such as "kg m2" or "mm/min".

    Raises
    ------
    UnitError
        if the text is not of the grammar above or names an unknown unit.
    """
    factor, exponents = 1.0, [0, 0, 0, 0, 0]
    for i, group in enumerate(text.strip().split("/")):
        atoms = [atom for atom in re.split(r"[ *]+", group.strip()) if atom]
        if not atoms and text.strip():
            raise UnitError(f"{_quote(text)} is not a unit", cure='write for example "N s/m"')
        for j, atom in enumerate(atoms):
            match = _ATOM.fullmatch(atom)
            if not match:
                raise UnitError(f"{_quote(text)} is not a unit", cure='write for example "kg m2" or "mm/min"')
            name, power = match[1], int(match[2] or 1)
            if name not in _ATOMS:
                raise UnitError(f"no unit {_quote(name)}", cure=_meant(name, match[2] or ""))
            sign = -1 if i and j == 0 else 1
            scale, *dims = _ATOMS[name]
            factor *= scale ** (sign * power)
            exponents = [e + sign * power * d for e, d in zip(exponents, dims, strict=True)]
    return factor, tuple(exponents)


def parse(text: str) -> tuple[float, Dimension]:
    """SI value and dimension of a quantity such as "20 mm".

    Raises
    ------
    UnitError
        if the text is not a number with a unit, or the number is not finite.
    """
    if len(text) <= _LONGEST and not text.isascii() and (plain := text.translate(_PLAIN)).isascii():
        raise UnitError("a quantity is written in ASCII", cure=f'write "{" ".join(plain.split())}"')
    if len(text) > _LONGEST or not text.isascii():
        raise UnitError(f"a quantity has at most {_LONGEST} ASCII characters", value=_quote(text))
    match = _NUMBER.match(text.strip())
    if not match:
        raise UnitError(f"{_quote(text)} is not a quantity", cure='write a number and its unit, e.g. "20 mm"')
    behind = text.strip()[match.end() :]
    if re.match(r",[0-9]", behind):
        raise UnitError(f"{_quote(text)} has a comma in its number", cure="write a decimal point")
    factor, dimension = unit(behind)
    value = float(match[0]) * factor
    if not math.isfinite(value):
        raise UnitError("a quantity must be finite", value=_quote(text))
    return value, dimension


def same_dimension(a: Dimension, b: Dimension) -> bool:
    """Whether two dimensions agree; the radian counts only in pure angles and their rates."""
    if a[:4] != b[:4]:
        return False
    pure_angle = (a[4] or b[4]) and not any(a[:2]) and a[3] == 0
    return a[4] == b[4] if pure_angle else True


def to_si(text: str, expected: str) -> float:
    """SI value of the quantity `text`, which must have the dimension of the unit `expected`.

    >>> to_si("3 m/min", "m/s")
    0.05
    """
    value, dimension = parse(text)
    _, wanted = unit(expected)
    if not same_dimension(dimension, wanted):
        if dimension == (0, 0, 0, 0, 0) and _NUMBER.fullmatch(text.strip()):
            raise UnitError(
                f"{_quote(text)} has no unit", cure=f'write e.g. "{text.strip()} {likely(value, expected)}"'
            )
        number = _NUMBER.match(text.strip())[0]
        rate = (0, 0, -1, 0)
        if dimension[:4] == wanted[:4] == rate:  # Hz where rad/s is wanted, or the other way round
            cure = "1 Hz is 2 pi rad/s: divide by it" if dimension[4] else "1 Hz is 2 pi rad/s: multiply by it"
        elif expected in ("", "1"):
            cure = f"write the number alone, e.g. {number}"
        else:
            cure = f'write e.g. "{number} {"deg" if expected == "rad" else expected}"'
        rule = f"{_quote(text)} is not a quantity in {expected}" if expected else f"{_quote(text)} is not a number"
        raise UnitError(rule, cure=cure)
    return value


def likely(value: float, expected: str) -> str:
    """The unit that somebody most likely meant who wrote the number `value` alone, where `expected` is asked for.

    Lengths of a machine are rarely above 2 m, and its angles never above half a turn.
    """
    if expected == "m":
        return "m" if abs(value) < 2 else "mm"
    return "deg" if expected == "rad" and abs(value) > math.pi else expected


def _meant(name: str, power: str) -> str:
    """The cure for a unit there is not."""
    if name in _MEANT:
        return f"write {_MEANT[name]}"
    glued = _GLUED.fullmatch(name)
    if glued:
        return f"write {' '.join(part for part in glued.groups() if part)}{power}, with a space"
    return did_you_mean(name, _ATOMS)


def factor(expected: str) -> float:
    """SI value of one `expected`: multiply by it coming in, divide by it going out."""
    return unit(expected)[0]


_PEOPLE = {  # SI unit: the units people read, smallest first
    "m": ("nm", "um", "mm", "m"),
    "N": ("mN", "N", "kN"),
    "s": ("us", "ms", "s"),
    "rad": ("urad", "mrad", "deg"),
}


def show(value: float, si_unit: str, digits: int = 4) -> str:
    """A quantity for people: 1.27e-05, "m" -> "12.7 um"."""
    if not math.isfinite(value):
        return f"{value} {si_unit}"
    chosen = si_unit
    if value and si_unit in _PEOPLE:
        fitting = [u for u in _PEOPLE[si_unit] if abs(value) >= 0.9999 * factor(u)]
        chosen = fitting[-1] if fitting else _PEOPLE[si_unit][0]
    return f"{value / factor(chosen):.{digits}g} {chosen}" if chosen not in ("", "1") else f"{value:.{digits}g}"


def _quote(text: str) -> str:
    return repr(text if len(text) <= 40 else text[:37] + "...")
