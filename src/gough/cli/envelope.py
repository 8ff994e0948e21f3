"""gough envelope: how far a machine can go from a pose, as a table, JSON or a figure."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ..errors import ExperimentError, InputError
from ..files import write_atomic
from ..machine.sheet import load_machine
from ..units import to_si
from .end import Outcome
from .map import assigned

_FIGURES = (".png", ".svg", ".pdf")
_WRENCH = ("N", "N", "N", "N m", "N m", "N m")


def envelope_of(
    name: str, at: Sequence[str], wrench: str | None, workspace: bool, out: Path | None, force: bool, outcome: Outcome
) -> None:
    """The envelope of a machine at a pose; with `out` its figure in a file."""
    from ..plan.envelope import envelope

    machine = load_machine(name)
    if out is not None and out.suffix.lower() not in _FIGURES:
        raise ExperimentError("is no figure", key="--out", value=str(out), cure=f"end it in {', '.join(_FIGURES)}")
    if out is not None and out.exists() and not force:
        raise ExperimentError("there is a file already", file=str(out), cure="choose another name, or add --force")
    units = dict(machine.task)
    x = np.array(machine.home, float)
    for text in at:
        for one in text.split(","):
            key, value = assigned("--at", one, units)
            x[list(units).index(key)] = value
    found = envelope(machine, x, None if wrench is None else _wrench(wrench), workspace)
    outcome.data.update(found.to_json())
    if out is not None:
        from ..report.envelope import envelope_figure

        figure = envelope_figure(found)
        write_atomic(out, lambda path: figure.savefig(path, dpi=150, format=out.suffix[1:].lower()))
        outcome.data["file"] = str(out)
    if not outcome.as_json:
        outcome.say(found)
        if out is not None:
            outcome.say(f"figure: {out}")


def _wrench(text: str) -> list[float]:
    """0 N,0 N,-500 N and perhaps three moments, SI."""
    parts = [part.strip() for part in text.split(",")]
    if len(parts) not in (3, 6):
        raise ExperimentError(
            "three forces, or three forces and three moments", key="--wrench", value=repr(text)[:60],
            cure='write "0 N,0 N,-500 N"',
        )  # fmt: skip
    try:
        found = [to_si(part, unit) for part, unit in zip(parts, _WRENCH, strict=False)]
    except InputError as error:
        raise error.at(key="--wrench") from None
    return found + [0.0] * (6 - len(found))
