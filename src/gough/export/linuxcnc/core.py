"""The C files of a machine: generated maths, and the hand-written files around it with names filled in."""

from __future__ import annotations

import re
from functools import cache
from importlib import resources

import numpy as np

from ... import __version__
from ...errors import ExperimentError
from ...kernel.building import BUILDING
from ..c import names, printer
from ..c.functions import print_functions
from ..c.machine_text import machine_text
from ..c.step_text import observer_stepped, step_text
from . import functions

LONGEST = 20  # letters: HAL's names have 47, and "NAME-feedforward.acceleration-0" is one of them
NEUTRAL = "/* SPDX-License-Identifier: 0BSD */\n"


def identifier(machine, name: str | None) -> str:
    """The C name of an export: as asked for, or the machine's with _ for what C does not know.

    Raises
    ------
    ExperimentError
        it is no C identifier, or too long for HAL.
    """
    found = names.identifier(names.suggested(machine.name) if name is None else name, "--name").lower()
    if len(found) > LONGEST or "__" in found or found.endswith("_"):
        raise ExperimentError(
            "the name does not fit HAL", key="--name", value=found[:60],
            limit=f"{LONGEST} letters, no _ beside _ or at the end", cure="write --name hexapod",
        )  # fmt: skip
    return found


@cache
def template(name: str) -> str:
    """A hand-written file of the folder files/, with its @NAMES@."""
    return (resources.files("gough.export.linuxcnc") / "files" / name).read_text(encoding="utf-8")


def filled(text: str, words: dict[str, object]) -> str:
    """The text with every @WORD@ replaced."""
    return re.sub(r"@([A-Z_]+)@", lambda found: str(words[found[1]]), text)


def words_of(machine, observer, name: str) -> dict[str, object]:
    """What the files of a machine say in place of their @WORDS@."""
    return {
        "NAME": name, "UPPER": name.upper(), "MACHINE": machine.name, "VERSION": __version__,
        "AXES": len(machine.task), "JOINTS": machine.joints_count,
        "PERIOD": printer.number(observer.period), "LETTERS": functions.axes_of(machine),
    }  # fmt: skip


def maths(machine, observer, name: str) -> dict[str, str]:
    """Generated files by name: NAME.c, NAME_wrench.c of export/c, NAME_core.c of functions.py, and headers."""
    c, h = machine_text(name, machine)
    with BUILDING:
        built = [*functions.frames(machine), functions.feedforward(machine)]
        stepped = observer_stepped(f"{name}_wrench", observer, machine.home)
    core_c, core_h = print_functions(f"{name}_core", built, {"theta": np.asarray(machine.theta)})
    wrench_c, wrench_h = step_text(stepped)
    texts = {f"{name}.c": c, f"{name}.h": h, f"{name}_core.c": core_c, f"{name}_core.h": core_h}
    texts |= {f"{name}_wrench.c": wrench_c, f"{name}_wrench.h": wrench_h}
    return {file: NEUTRAL + text for file, text in texts.items()}
