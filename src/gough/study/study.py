"""What a study is made of: experiments that do not know each other, the claims they answer, and figures."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from .claims import Claim

Tick = Callable[[float, float], None]  # progress: simulated s, of how many


@dataclass(frozen=True)
class Experiment:
    """One job: `work(tick)` does it and returns its result; `tick(done, total)`, or None, hears of its progress."""

    label: str
    work: Callable[[Tick | None], Any]


@dataclass(frozen=True)
class Study:
    """A paper's experiments; `claims` and `figures` take their results in the order of `experiments`."""

    paper: str  # "garagic2004"
    title: str  # of the paper
    cited: str  # authors, where, when
    about: str  # what was taken for what the paper does not say: one paragraph, on the page
    experiments: Sequence[Experiment]
    claims: Callable[[Sequence[Any]], list[Claim]]
    figures: Callable[[Sequence[Any], Path], list[Figure]]
    beyond: Sequence[Beyond] = ()


@dataclass(frozen=True)
class Beyond:
    """What the paper does not ask: experiments of their own, one table and one picture.

    `table`, `picture` and `text` take the results in the order of `experiments`; a picture is matplotlib's axes.
    """

    name: str  # of its files
    title: str
    experiments: Sequence[Experiment]
    heads: Sequence[str]
    table: Callable[[Sequence[Any]], list[list[str]]]
    picture: Callable[[Sequence[Any]], Any]
    text: Callable[[Sequence[Any]], str]
    campaign: bool = False  # takes minutes: only when asked for


@dataclass(frozen=True)
class Told:
    """A Beyond with its results."""

    beyond: Beyond
    rows: list[list[str]]
    text: str
    figure: Figure


@dataclass(frozen=True)
class Figure:
    """A picture in the results folder, and what it shows."""

    file: str  # name of the PNG
    caption: str


def parts(tick: Tick | None, durations: Sequence[float]) -> list[Tick | None]:
    """For an experiment of several runs of `durations` s: a tick for each, which together count up to all of them."""
    if tick is None:
        return [None] * len(durations)
    total = sum(durations)

    def of(before: float, duration: float) -> Tick:
        return lambda done, whole: tick(before + duration * done / whole if whole else before, total)

    return [of(sum(durations[:i]), duration) for i, duration in enumerate(durations)]
