"""Parameters of NC programs: #1 to #5601, #<local>, #<_global>, and those that only the machine sets.

#1 to #30 and #<local> belong to the subroutine that runs: a call begins with its arguments in #1, #2, ... and zeros,
and its caller's come back when it returns.  All others are the whole program's.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from ...errors import ProgramError
from .functions import whole

LAST = 5601
ARGUMENTS = 30
READ_ONLY = frozenset([*range(5400, 5414), *range(5420, 5429)])  # the tool in force, the position
MOST_LINES = 10_000  # of a parameter file; LinuxCNC's have 150

# names that LinuxCNC gives a meaning: a program may read those that are supported, and set none
SYSTEM_NAMES = frozenset(
    "_" + name
    for group in (
        "vmajor vminor line task value value_returned call_level remap_level motion_mode plane ccomp coord_system",
        "metric imperial absolute incremental inverse_time units_per_minute units_per_rev ijk_absolute_mode",
        "tool_offset retract_r_plane retract_old_z spindle_rpm_mode spindle_css_mode lathe_diameter_mode",
        "lathe_radius_mode spindle_on spindle_cw mist flood speed_override feed_override adaptive_feed feed_hold feed",
        "rpm current_tool current_pocket selected_tool selected_pocket x y z a b c u v w abs_x abs_y abs_z abs_a abs_b",
        "abs_c abs_u abs_v abs_w",
    )
    for name in group.split()
)


class Parameters:
    """The parameters of one run of a program.

    system          named values that the machine sets, e.g. "_x": a function without arguments
    system_numbers  numbered ones, 5000 or more, e.g. 5420
    numbers         (5602,), the values of all others by their number
    """

    def __init__(self):
        self.system: dict[str, Callable[[], float]] = {
            "_value": lambda: self.returned or 0.0,
            "_value_returned": lambda: float(self.returned is not None),
            "_call_level": lambda: float(len(self._callers)),
            "_remap_level": lambda: 0.0,
            "_task": lambda: 0.0,
            "_vmajor": lambda: 2.9,  # the version of LinuxCNC whose language this is
            "_vminor": lambda: 0.0,
        }
        self.system_numbers: dict[int, Callable[[], float]] = {}
        self.returned: float | None = None  # what the last call returned
        self.level: Callable[[int], None] = lambda depth: None  # hears of every call and return, see M73
        self.numbers = [0.0] * (LAST + 1)
        self.numbers[5220] = 1.0  # G54 is in force
        self._global: dict[str, float] = {}
        self._local: dict[str, float] = {}
        self._callers: list[tuple[list[float], dict[str, float]]] = []

    def get(self, number: float) -> float:
        """The value of #number.

        Raises
        ------
        ProgramError
            there is no such parameter.
        """
        n = _index(number)
        if n in self.system_numbers:
            return float(self.system_numbers[n]())
        return self.numbers[n]

    def set(self, number: float, value: float) -> None:
        """What a program does with #number=value.

        Raises
        ------
        ProgramError
            there is no such parameter, or programs may not set it.
        """
        n = _index(number)
        if n in READ_ONLY or n in self.system_numbers:
            raise ProgramError("a parameter that programs only read", value=f"#{n}", cure="use another, e.g. #100")
        self.keep(n, value)

    def keep(self, number: int, value: float) -> None:
        """Set #number, read-only or not: for the machine, not for programs."""
        if not math.isfinite(value):
            raise ProgramError("a parameter is a finite number", value=f"#{number} = {value}")
        self.numbers[number] = float(value)

    def exists(self, number: float) -> bool:
        """Whether there is a parameter #number."""
        n = whole(number)
        if n is None:
            raise _not_whole(number)
        return 1 <= n <= LAST

    def get_named(self, name: str) -> float:
        """The value of #<name>; `name` in lower case.

        Raises
        ------
        ProgramError
            it was never set.
        """
        kept = self._global if name.startswith("_") else self._local
        value = kept.get(name)
        if value is not None:
            return value
        if name in self.system:
            return float(self.system[name]())
        if name in SYSTEM_NAMES:
            cure = "remove it, or write the number"
            raise ProgramError("a parameter of the machine that is not supported", value=f"#<{name}>", cure=cure)
        if name.startswith(("_ini[", "_hal[")):
            cure = "write the number"
            raise ProgramError("values of the INI file and of HAL are not supported", value=f"#<{name}>", cure=cure)
        if not name.startswith("_") and self._callers:
            cure = f"set it in the subroutine, or use #<_{name}>, which holds everywhere"
        else:
            cure = f"write #<{name}>=... before it"
        raise ProgramError("a named parameter that was never set", value=f"#<{name}>", cure=cure)

    def set_named(self, name: str, value: float) -> None:
        """What a program does with #<name>=value; `name` in lower case.

        Raises
        ------
        ProgramError
            programs may not set it.
        """
        if name in SYSTEM_NAMES or name in self.system or name.startswith(("_ini[", "_hal[")):
            cure = f"use another name, e.g. #<my{name}>"
            raise ProgramError("a parameter that programs only read", value=f"#<{name}>", cure=cure)
        if not math.isfinite(value):
            raise ProgramError("a parameter is a finite number", value=f"#<{name}> = {value}")
        (self._global if name.startswith("_") else self._local)[name] = value

    def exists_named(self, name: str) -> bool:
        """Whether #<name> has a value."""
        return name in self._local or name in self._global or name in self.system

    # -- subroutines --------------------------------------------------------------------------------------------

    def enter(self, arguments: Sequence[float]) -> None:
        """A subroutine begins."""
        self._callers.append((self.numbers[1 : ARGUMENTS + 1], self._local))
        self.numbers[1 : ARGUMENTS + 1] = [*arguments, *[0.0] * (ARGUMENTS - len(arguments))]
        self._local = {}
        self.level(len(self._callers))

    def leave(self, returned: float | None) -> None:
        """A subroutine ends; `returned`: its value, if it has one."""
        self.numbers[1 : ARGUMENTS + 1], self._local = self._callers.pop()
        self.returned = returned
        self.level(len(self._callers))

    # -- files --------------------------------------------------------------------------------------------------

    @classmethod
    def of(cls, text: str, file: str | None = None) -> dict[int, float]:
        """The numbers that a parameter file sets, by number; errors as `read`."""
        read, fresh = cls(), cls()
        read.read(text, file)
        pairs = enumerate(zip(read.numbers, fresh.numbers, strict=True))
        return {number: value for number, (value, before) in pairs if value != before}

    def read(self, text: str, file: str | None = None) -> None:
        """Take up the text of a parameter file of LinuxCNC: lines "number value".

        Raises
        ------
        ProgramError
            with the line that is wrong.
        """
        seen: set[int] = set()
        for line, written in enumerate(text.splitlines(), 1):
            if not written.strip():
                continue
            try:
                if line > MOST_LINES:
                    raise ProgramError(f"a parameter file has at most {MOST_LINES} lines")
                number, value = _entry(written)
                if number in seen:
                    raise ProgramError("a parameter twice", value=str(number), cure="remove one")
                seen.add(number)
                if number not in READ_ONLY:  # LinuxCNC writes them too, and they are the machine's at once
                    self.keep(number, value)
            except ProgramError as error:
                raise error.at(file=file, line=line) from None


def _entry(written: str) -> tuple[int, float]:
    parts = written.split()
    try:
        number, value = parts
        n, v = int(number), float(value)
    except ValueError:
        cure = "write e.g. 5221 12.5"
        raise ProgramError(
            "a line of a parameter file is a number and its value", value=repr(written[:30]), cure=cure
        ) from None
    if not 1 <= n <= LAST:
        raise ProgramError(f"parameters go from 1 to {LAST}", value=repr(number[:30]))
    if not math.isfinite(v):
        raise ProgramError("a parameter is a finite number", value=repr(value[:30]))
    return n, v


def _index(number: float) -> int:
    n = whole(number)
    if n is None:
        raise _not_whole(number)
    if not 1 <= n <= LAST:
        raise ProgramError(f"parameters go from #1 to #{LAST}", value=f"#{n:.6g}", cure="use e.g. #100")
    return n


def _not_whole(number: float) -> ProgramError:
    return ProgramError(
        "the number of a parameter is whole", value=f"#[{number:.6g}]", cure="use FIX[...] or ROUND[...]"
    )
