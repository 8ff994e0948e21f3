"""The C files of a machine: generated maths and numbers, and the hand-written files around them, names filled in."""

from __future__ import annotations

import re
from functools import cache
from importlib import resources

from ... import __version__
from ...errors import ExperimentError
from ...kernel.building import BUILDING
from ...kernel.pack import flatten
from ...kernel.tape import trace
from ...machine import forward
from ...machine.arrays import row_function
from ...observe.tasks import function_of
from . import functions, printer

LONGEST = 20  # letters: HAL's names have 47, and "NAME-feedforward.acceleration-0" is one of them
# what the C names would hide
_TAKEN = frozenset(
    "auto break case char const continue default do double else enum extern float for goto if inline int long register "
    "restrict return short signed sizeof static struct switch typedef union unsigned void volatile while main".split()
)


def identifier(machine, name: str | None) -> str:
    """The C name of an export: as asked for, or the machine's with _ for - and dots.

    Raises
    ------
    ExperimentError
        it is no C identifier, or too long for HAL.
    """
    found = re.sub(r"[-.]", "_", machine.name) if name is None else name
    if not re.fullmatch(r"[A-Za-z][A-Za-z0-9_]*", found, re.ASCII) or found in _TAKEN:
        raise ExperimentError(
            "the name of an export must be a C identifier", key="--name", value=ascii(found)[:60],
            cure="write --name hexapod: letters, digits and _, a letter first",
        )  # fmt: skip
    if len(found) > LONGEST:
        raise ExperimentError(
            "the name is too long for HAL", key="--name", value=found[:60], limit=f"{LONGEST} letters",
            cure="write --name hexapod",
        )  # fmt: skip
    return found.lower()


@cache
def template(name: str) -> str:
    """A hand-written file of the folder files/, with its @NAMES@."""
    return (resources.files("gough.export.linuxcnc") / "files" / name).read_text(encoding="utf-8")


def filled(text: str, words: dict[str, object]) -> str:
    """The text with every @WORD@ replaced."""
    return re.sub(r"@([A-Z_]+)@", lambda found: str(words[found[1]]), text)


def words_of(machine, observer, name: str) -> dict[str, object]:
    """What the files of a machine say in place of their @WORDS@."""
    state = flatten(observer.init(machine.home))
    return {
        "NAME": name, "MACHINE": machine.name, "VERSION": __version__, "AXES": functions.axes_of(machine).lower(),
        "D": len(machine.task), "N": machine.joints_count, "NZ": machine.coordinate_count, "NS": len(state),
        "NT": len(machine.theta), "NM": len(machine.limit_names), "PERIOD": printer.number(observer.period),
        "ITERATIONS": forward.ITERATIONS, "RESIDUAL": printer.number(forward.RESIDUAL),
    }  # fmt: skip


def maths(machine, observer, words: dict[str, object]) -> dict[str, str]:
    """Texts of the core's files by name: header, functions, numbers."""
    import casadi as ca

    with BUILDING:
        found = function_of(observer)
        built = [
            ("inverse", functions.inverse(machine)),
            ("newton", row_function("newton", machine)),
            ("landing", functions.landing(machine)),
            ("feedforward", functions.feedforward(machine)),
            ("observe", found),
        ]
        texts = [printer.function(trace(built_function), name) for name, built_function in built]
        reach = float(ca.evalf(ca.SX(machine.stride_of(machine))))
    more = {
        "FUNCTIONS": "\n".join(texts),
        "SMALL": printer.number(1e-13 * max(1.0, reach)),
        "NF": found.numel_out(0),
        "THETA": printer.table(machine.theta),
        "ZERO": printer.table(functions.zero_of(machine)),
        "ZHOME": printer.table(machine.coordinates(machine.home)),
        "THETAOBS": printer.table(observer.theta),
        "STATEHOME": printer.table(flatten(observer.init(machine.home))),
    }
    words.update(more)
    name = words["NAME"]
    return {
        f"{name}_core.h": filled(template("core.h"), words),
        f"{name}_core.c": filled(template("core.c"), words),
        f"{name}_numbers.c": filled(template("numbers.c"), words),
    }
