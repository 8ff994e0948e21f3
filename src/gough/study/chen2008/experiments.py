"""The experiments of this study as jobs, and what each of them gives to the claims."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ..study import Experiment, Tick, parts
from . import bound, checks, offsets
from .printed import PrintedSign, PrintedSliding, to_the_letter
from .setup import CASES, CIRCLE, ELLIPSE, INERTIAS, SCREWS, TIME, Course, law, machine, run, scaled

ELLIPSES: dict[str, tuple[str, tuple[str, ...]]] = {  # name: form of the equation, what is uncertain
    "printed": ("dimensionless", INERTIAS + SCREWS),
    "without screws": ("dimensionless", INERTIAS),
    "area": ("area", INERTIAS + SCREWS),
}


def cases(semi, form: str = "", names=INERTIAS + SCREWS, **options: Any) -> Callable[[Tick | None], dict]:
    """The path with every uncertainty of CASES."""

    def work(tick: Tick | None) -> dict[float, Course]:
        ticks = parts(tick, [TIME] * len(CASES))
        control = law(semi, form, **options)
        return {s: run(semi, scaled(machine(), s, names), control, t) for s, t in zip(CASES, ticks, strict=True)}

    return work


LETTERS: dict[str, tuple] = {  # name: law, path, true over believed
    "sign, circle": (PrintedSign, CIRCLE, 1.0),
    "sign, ellipse": (PrintedSign, ELLIPSE, 1.0),
    "sliding, circle": (PrintedSliding, CIRCLE, 1.5),
}


def letters(tick: Tick | None) -> dict[str, Course]:
    """The law with each of its misprints."""
    ticks = parts(tick, [TIME] * len(LETTERS))
    return {
        name: run(semi, scaled(machine(), s), to_the_letter(cls, law(semi)), t)
        for (name, (cls, semi, s)), t in zip(LETTERS.items(), ticks, strict=True)
    }


JOBS: dict[str, Callable[[Tick | None], object]] = {
    "initial offset": offsets.search,
    "circle": cases(CIRCLE),
    "circle, exact coordinates": cases(CIRCLE, coordinates="newton"),
    **{f"ellipse, {name}": cases(ELLIPSE, *options) for name, options in ELLIPSES.items()},
    "lemma": checks.lemma,
    "as printed": letters,
    "ellipse, where it lets go": bound.lost,
}
EXPERIMENTS = [Experiment(label, work) for label, work in JOBS.items()]


class Results:
    """The results of EXPERIMENTS by their names."""

    def __init__(self, results):
        self.of = dict(zip(JOBS, results, strict=True))

    @property
    def circle(self) -> dict[float, Course]:
        """The circle as printed, by uncertainty."""
        return self.of["circle"]

    def ellipse(self, name: str) -> dict[float, Course]:
        """The ellipse of ELLIPSES, by uncertainty."""
        return self.of[f"ellipse, {name}"]
