"""identify(): a log and a machine in, a Fit out: what was learned, how surely, and what could not be seen."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import ExperimentError, LogError
from ..log import Log
from ..machine.base import Machine
from ..quantities import brief
from . import text
from .design import structural
from .physical import Physical, physical_parameters
from .regress import Estimate, estimate
from .rows import in_order, joined, rows_of_log
from .signals import CUTOFF

_NEAR = 0.01  # deviations; nearer bodies have the numbers that were found


class Fit:
    """What was learned from a log.  It prints itself; `estimate` has the arrays."""

    def __init__(self, machine: Machine, found: Estimate, friction: Sequence[str], notes: Sequence[str] = ()):
        self.machine, self.estimate, self.notes = machine, found, tuple(notes)
        self._friction = tuple(friction)

    @property
    def names(self) -> tuple[str, ...]:
        """The combinations that were found, r of them."""
        return self.estimate.base.names

    @property
    def values(self) -> np.ndarray:
        """Their values.  (r,), SI."""
        return self.estimate.values

    @property
    def std(self) -> np.ndarray:
        """Their standard deviations.  (r,), SI."""
        return self.estimate.std

    @property
    def units(self) -> tuple[str, ...]:
        """Their units."""
        return self.estimate.base.units

    @property
    def sheet(self) -> np.ndarray:
        """What the machine's sheet says of them.  (r,), SI."""
        return self.estimate.base.K @ self.estimate.rows.values

    @property
    def unseen(self) -> tuple[str, ...]:
        """Parameters that were sought and that this motion does not show, though another might."""
        return tuple(name for name in self._of("not") if name not in self.never)

    @functools.cached_property
    def never(self) -> tuple[str, ...]:
        """Parameters that no motion of this machine shows."""
        found = structural(self.machine, self._friction)[0]
        named = dict(zip(self.estimate.rows.names, found.seen, strict=True))
        return tuple(name for name in self._of("not") if named[name] == "not")

    @property
    def together(self) -> tuple[str, ...]:
        """Parameters that this motion shows only in sums with others."""
        return self._of("combined")

    def _of(self, how: str) -> tuple[str, ...]:
        found = self.estimate
        rows = zip(found.rows.names, found.base.seen, found.free, strict=True)
        return tuple(name for name, seen, free in rows if seen == how and free)

    @functools.cached_property
    def impossible(self) -> tuple[str, ...]:
        """Bodies for which the numbers found are those of no body, by more than a hundredth of a deviation.

        Raises
        ------
        RunError
            as `physical`.
        """
        return self.physical.impossible if self.physical.away > _NEAR else ()

    @functools.cached_property
    def physical(self) -> Physical:
        """The parameters (p,) of bodies that can exist: the estimate's, or the nearest to it.

        Raises
        ------
        RunError
            the search for them did not converge.
        """
        return physical_parameters(self.estimate)

    def __getitem__(self, name: str) -> tuple[float, float]:
        """Value and deviation of a combination, by its name or that of the parameter it begins with.

        Raises
        ------
        LogError
            the motion does not show it by itself.
        """
        for key in (self.names, tuple(self.estimate.rows.names[k] for k in self.estimate.base.kept)):
            if name in key:
                i = key.index(name)
                return float(self.values[i]), float(self.std[i])
        raise LogError("the motion does not show it", key=str(name)[:60], cure="print the fit to see what it shows")

    def to_json(self) -> dict[str, Any]:
        """The object that `gough identify --json` prints.  SI."""
        found = self.estimate
        rows = [
            {"name": n, "value": float(v), "std": float(s), "unit": u, "seen": True}
            for n, v, s, u in zip(self.names, self.values, self.std, self.units, strict=True)
        ]
        units = dict(zip(found.rows.names, found.rows.units, strict=True))
        rows += [
            {"name": n, "value": None, "std": None, "unit": units[n], "seen": False}
            for n in (*self.unseen, *self.never)
        ]
        return {
            "parameters": rows,
            "rank": found.base.rank,
            "condition": found.base.condition,
            "residual_rms": found.residual_rms,
            "held_out_rms": found.held_out_rms,
            "std_over_noise": found.factor,
            "unseen": list(self.unseen),
            "never": list(self.never),
            "together": list(self.together),
            "impossible": list(self.impossible),
            "notes": list(self.notes),
        }

    def __repr__(self) -> str:
        return text.text(self)


def identify(
    log: Log | str | Path | Sequence[Log | str | Path],
    machine: Machine,
    free: Sequence[str] | str | None = None,
    *,
    friction: Sequence[str] | str = ("coulomb", "viscous"),
    cutoff: float | None = CUTOFF,
    hold: float | None = None,
) -> Fit:
    """What a log's motion and forces (q_m, u) say of the parameters of `machine`; of several logs all of them together.

    Parameters
    ----------
    free : the parameters sought, by name or by what a name begins with ("platform", "friction.coulomb"); else all.
        The others are the sheet's.
    friction : its kinds that have a number for every joint: coulomb, viscous, offset, base_torque (a torque in each
        base joint of a hexapod); "known" takes the log's own off.
    cutoff : of the low-pass filter, Hz; None: none.
    hold : s for which a row's force is held; else what the log tells.

    Raises
    ------
    LogError
        the log lacks what is needed, does not belong to the machine, or its motion shows nothing of what is sought.
    ExperimentError
        `free` or `friction` names nothing.
    """
    if not isinstance(machine, Machine):
        raise ExperimentError("must be a machine", key="machine", value=brief(machine), cure="gk.load_machine(...)")
    logs = [_log(one) for one in (log if isinstance(log, list | tuple) else [log])]
    if not logs:
        raise ExperimentError("needs a log", key="log")
    kinds = () if friction == "known" else (friction,) if isinstance(friction, str) else in_order(friction)
    told = "known" if friction == "known" else kinds
    parts = [rows_of_log(one, machine, told, cutoff, hold) for one in logs]
    rows = parts[0] if len(parts) == 1 else joined(parts)
    notes = dict.fromkeys(note for one, part in zip(logs, parts, strict=True) for note in _notes(one, machine, part))
    return Fit(machine, estimate(rows, free), kinds, list(notes))


def _log(log) -> Log:
    if isinstance(log, str | Path):
        log = Log.load(log)
    if not isinstance(log, Log):
        raise ExperimentError("must be a Log, or the path of one", key="log", value=brief(log))
    return log


def _notes(log: Log, machine: Machine, rows) -> list[str]:
    """What whoever reads the numbers should know of the log."""
    notes = []
    told = log.info.get("machine")
    name = told.get("name") if isinstance(told, dict) else None
    if name is not None and name != machine.name:
        notes.append(f"the log is of {name}, the machine is {machine.name}")
    if log.failed:
        notes.append(f"the run failed: {log.reason.splitlines()[0]}")
    limited = float(np.mean(log["saturated"] != 0)) if "saturated" in log else 0.0
    if limited:
        notes.append(f"{100 * limited:.2g} % of the forces were at the drive's limit and are left out")
    if not rows.used.any(0).all():
        still = [rows.joints[j] for j in np.flatnonzero(~rows.used.any(0))]
        notes.append(f"no row of {', '.join(still)} takes part: it hardly moves")
    return notes
