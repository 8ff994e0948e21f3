"""Program coordinates to the frame of the program's zero and back: G54 to G59.3, G92, the tool's offset.

    p_O = o + Rz(theta) (p + d)          o, theta: coordinate system, d: G92 (or G52)                          (1)
    abc_O = abc + o_abc + d_abc          theta turns X and Y only, as in LinuxCNC                              (2)
    p_OT = p_O + R(abc_O) t              T of the data sheet, t: the tool's offset (G43)                       (3)

p_O is the tip of the tool in use.  LinuxCNC adds t along the machine's axes; here it turns with the tool, so that a
change of tool leaves the machine where it is at any tilt: the tip is where (3) says.  G53, G28 and G30 say where T
goes.
The numbers of the coordinate systems are also the parameters 5210 to 5390, in mm and degrees, as LinuxCNC keeps them on
a machine in mm.  A program that writes a parameter moves nothing until the system is selected anew.
"""

from __future__ import annotations

import math

from .modes import DEGREE

_SI = (1e-3, 1e-3, 1e-3, DEGREE, DEGREE, DEGREE)  # per unit of the parameters
_G92, _SYSTEMS, _EACH = 5210, 5201, 20
HOME, SECOND_HOME = 5161, 5181


class Offsets:
    """Coordinate systems, G92 and tool offset of a program; m and rad.  `parameters` keeps what LinuxCNC keeps there.

    `shift` (6,) is the whole offset where `turned` is False: p_O = p + shift.
    """

    def __init__(self, parameters):
        self._parameters = parameters
        system = parameters.get(5220)
        self.system = int(system) if system in range(1, 10) else 1
        self.tool = (0.0, 0.0, 0.0)
        self.shifted = parameters.get(_G92) == 1
        self._shift = self._read(_G92 + 1) if self.shifted else [0.0] * 6
        self.select(self.system)

    def _read(self, first):
        return [self._parameters.get(first + k) * si for k, si in enumerate(_SI)]

    def _write(self, first, values):
        for k, si in enumerate(_SI):
            self._parameters.keep(first + k, values[k] / si)

    def _changed(self):
        self.turned = self._theta != 0
        self._cos, self._sin = math.cos(self._theta), math.sin(self._theta)
        self.shift = tuple(o + d for o, d in zip(self._origin, self._shift, strict=True))

    # -- eq. (1) and (2) ----------------------------------------------------------------------------------------------

    def to_frame(self, p: list[float]) -> list[float]:
        """Program coordinates x y z a b c to the frame of the program's zero.  (6,) each."""
        out = [v + s for v, s in zip(p, self.shift, strict=True)]
        if self.turned:
            out[0], out[1] = self._out(p[0] + self._shift[0], p[1] + self._shift[1])
        return out

    def to_program(self, at: list[float]) -> list[float]:
        """The inverse of `to_frame`."""
        return self._seen(at, self._origin, self._theta)

    def _out(self, x, y):
        c, s, o = self._cos, self._sin, self._origin
        return o[0] + c * x - s * y, o[1] + s * x + c * y

    def _seen(self, at, origin, theta):
        rel = [v - o for v, o in zip(at, origin, strict=True)]
        if theta:
            c, s = math.cos(theta), math.sin(theta)
            rel[0], rel[1] = c * rel[0] + s * rel[1], c * rel[1] - s * rel[0]
        return [v - d for v, d in zip(rel, self._shift, strict=True)]

    def direction(self, v: tuple[float, float, float]) -> tuple[float, float, float]:
        """A direction of program coordinates, in the frame of the program's zero."""
        if not self.turned:
            return v
        return self._cos * v[0] - self._sin * v[1], self._sin * v[0] + self._cos * v[1], v[2]

    # -- coordinate systems -------------------------------------------------------------------------------------------

    def select(self, system: int) -> None:
        """G54 (1) to G59.3 (9): the numbers that the parameters hold now."""
        first = _SYSTEMS + _EACH * system
        self.system = system
        self._origin, self._theta = self._read(first), self._parameters.get(first + 9) * DEGREE
        self._parameters.keep(5220, system)
        self._changed()

    def set_origin(self, system: int, values: dict[int, float], theta: float | None) -> None:
        """G10 L2: axis k of `system` (1 to 9, 0: the selected one) to values[k] m or rad, its turn to `theta` rad."""
        system = system or self.system
        first = _SYSTEMS + _EACH * system
        for k, value in values.items():
            self._parameters.keep(first + k, value / _SI[k])
        if theta is not None:
            self._parameters.keep(first + 9, theta / DEGREE)
        if system == self.system:
            for k, value in values.items():
                self._origin[k] = value
            if theta is not None:
                self._theta = theta
            self._changed()

    def set_here(self, system: int, at: list[float], values: dict[int, float]) -> None:
        """G10 L20: move the origin of `system` so that the point `at` has the coordinates values[k] there."""
        system = system or self.system
        first = _SYSTEMS + _EACH * system
        if system == self.system:
            origin, theta = self._origin, self._theta
        else:
            origin, theta = self._read(first), self._parameters.get(first + 9) * DEGREE
        seen = self._seen(at, origin, theta)
        for k, value in values.items():
            seen[k] = value
        rel = [v + d for v, d in zip(seen, self._shift, strict=True)]
        c, s = math.cos(theta), math.sin(theta)
        if theta:
            rel[0], rel[1] = c * rel[0] - s * rel[1], s * rel[0] + c * rel[1]
            kept = {*values, 0, 1} if {0, 1} & set(values) else set(values)
        else:
            kept = set(values)
        self.set_origin(system, {k: at[k] - rel[k] for k in kept}, None)

    # -- G92 ----------------------------------------------------------------------------------------------------------

    def shift_here(self, at: list[float], values: dict[int, float]) -> None:
        """G92: the point `at` gets the coordinates values[k]."""
        seen = self.to_program(at)
        self._set_shift({k: self._shift[k] + seen[k] - value for k, value in values.items()})

    def shift_by(self, values: dict[int, float]) -> None:
        """G52: the offset itself."""
        self._set_shift(values)

    def _set_shift(self, values):
        for k, value in values.items():
            self._shift[k] = value
        self._write(_G92 + 1, self._shift)
        self._parameters.keep(_G92, 1)
        self.shifted = True
        self._changed()

    def unshift(self, keep: bool) -> None:
        """G92.1, and with `keep` G92.2, which leaves the parameters for G92.3."""
        self._shift = [0.0] * 6
        if not keep:
            self._write(_G92 + 1, self._shift)
        self._parameters.keep(_G92, 0)
        self.shifted = False
        self._changed()

    def reshift(self) -> None:
        """G92.3: what the parameters hold."""
        self._shift = self._read(_G92 + 1)
        self._parameters.keep(_G92, 1)
        self.shifted = True
        self._changed()

    # -- T, eq. (3) ---------------------------------------------------------------------------------------------------

    def tool_point(self, at: list[float]) -> list[float]:
        """Where T is when the tip is `at`: x y z and the same a b c."""
        r = turned_by(at[3:], self.tool)
        return [at[0] + r[0], at[1] + r[1], at[2] + r[2], *at[3:]]

    def tip_of(self, point: list[float]) -> list[float]:
        """Where the tip is when T is at `point`."""
        r = turned_by(point[3:], self.tool)
        return [point[0] - r[0], point[1] - r[1], point[2] - r[2], *point[3:]]

    def set_home(self, first: int, at: list[float]) -> None:
        """G28.1, G30.1: where T is now."""
        self._write(first, self.tool_point(at))

    def home(self, first: int) -> list[float]:
        """Where G28 or G30 puts T."""
        return self._read(first)


def turned_by(abc, v):
    """R(abc) v, R = Rz(c) Ry(b) Rx(a).  (3,)."""
    if v == (0.0, 0.0, 0.0):
        return v
    x, y, z = v
    a, b, c = abc
    y, z = math.cos(a) * y - math.sin(a) * z, math.sin(a) * y + math.cos(a) * z
    x, z = math.cos(b) * x + math.sin(b) * z, math.cos(b) * z - math.sin(b) * x
    return math.cos(c) * x - math.sin(c) * y, math.sin(c) * x + math.cos(c) * y, z
