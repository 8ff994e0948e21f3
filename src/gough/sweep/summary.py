"""What a sweep came to: each case in a line, the effect of each factor, the worst run and how to look at it."""

from __future__ import annotations

import math
import shlex
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..measure.tree import told
from ..units import show
from .limits import failures, hits, told_of
from .run import Swept
from .table import Lines

SHORT = 10  # digits of an id that people copy
MOST_CASES = 40
_SHOWN = 5  # worst runs


class Case(NamedTuple):
    """One controller at one point of the grid, over all draws."""

    controller: int
    point: int
    runs: int
    failed: int
    median: float | None
    most: float | None  # what 95 % of the runs stay below
    worst: float | None
    worst_id: str | None
    saturated: float | None  # largest share of samples with a drive at its limit; None: no drive has one
    limits: dict[str, int]  # runs that each sort of limit ended


class Effect(NamedTuple):
    """What a factor does to the metric under one controller."""

    factor: int
    controller: int
    times: float  # median at the highest quarter of its values (or the last of a list) over that at the lowest
    rank: float | None  # Spearman's correlation; None for words


def cases_of(swept: Swept, lines: Lines) -> list[Case]:
    """Every case, in the order of the grid."""
    values, out = lines.metric(swept.design.metric), []
    order = _case(swept, lines)
    known = lines.metrics.get("saturated", np.full(len(order), np.nan))  # of failed runs too
    for code in np.unique(order):
        at = np.flatnonzero(order == code)
        found = values[at]
        good = found[np.isfinite(found)]
        failed = int((lines.status[at] != "done").sum())
        numbers: list[Any] = [None] * 4
        shares = known[at][np.isfinite(known[at])]
        share = float(shares.max()) if len(shares) else None
        if len(good):
            worst = int(at[np.nanargmax(found)])
            numbers = [*map(float, np.percentile(good, (50, 95))), float(good.max()), lines.ids[worst]]
        out.append(
            Case(
                int(lines.controller[at[0]]), int(lines.point[at[0]]), len(at), failed, *numbers, share, hits(lines, at)
            )
        )
    return out


def rank(case: Case) -> tuple[float, float]:
    """The best case is the least: few runs that fail, then a small worst value.  One that all but failed is not good
    because of the one run that did not."""
    return case.failed / case.runs, math.inf if case.worst is None else case.worst


def effects_of(swept: Swept, lines: Lines) -> list[Effect]:
    """The main effect of every factor under every controller that has runs to tell it from.

    The runs of a point of the grid are first divided by their median where the factor is drawn: the same machines are
    at every point, and what the grid does is no effect of theirs.
    """
    from scipy.stats import spearmanr

    values, out = lines.metric(swept.design.metric), []
    within = np.full_like(values, np.nan)
    for case in np.unique(order := _case(swept, lines)):
        at = (order == case) & np.isfinite(values)
        if at.any() and np.median(values[at]) > 0:
            within[at] = values[at] / np.median(values[at])
    for k, (axis, factor) in enumerate(zip(lines.axes, swept.design.factors, strict=True)):
        measured = values if factor.distribution is None else within
        for i in range(len(swept.experiment.controllers)):
            at = (lines.controller == i) & np.isfinite(measured)
            x, y = lines.values[k][at], measured[at]
            if len(np.unique(x)) < 2 or len(np.unique(y)) < 2:
                continue
            low, high = np.quantile(x, (0.25, 0.75), method="nearest")
            first, last = np.median(y[x <= low]), np.median(y[x >= high])
            rank = None if axis.words else float(spearmanr(x, y).statistic)
            out.append(Effect(k, i, float(last / first) if first > 0 else math.nan, rank))
    return out


def _case(swept: Swept, lines: Lines) -> np.ndarray:
    return lines.point * len(swept.experiment.controllers) + lines.controller


class Shown(NamedTuple):
    """A run worth looking at, and the command that does it again with a full log."""

    id: str
    what: str
    command: str
    settings: dict[str, Any]


def worst_runs(swept: Swept, lines: Lines, folder: Path) -> list[Shown]:
    """The runs of the largest metric, worst first, and the worst of the best case; then one of every reason to fail."""
    values = lines.metric(swept.design.metric)
    order = [k for k in np.argsort(-np.nan_to_num(values, nan=-np.inf), kind="stable") if np.isfinite(values[k])]
    labels, unit, out, seen = swept.experiment.labels, told(swept.design.metric)[0], [], set()
    least = min((c for c in cases_of(swept, lines) if c.worst is not None), key=rank, default=None)
    last = [] if least is None else [lines.ids.index(least.worst_id)]  # that of the best case, whatever else is worse
    for k in [*order[: _SHOWN - 1], *last]:
        if lines.ids[k] in seen:
            continue
        seen.add(lines.ids[k])
        text = f"{labels[lines.controller[k]]}: {swept.design.metric} {show(float(values[k]), unit)}"
        out.append(_shown(swept, lines.ids[k], text, folder))
    for one in failures(lines)[:_SHOWN]:
        text = f"{labels[lines.controller[one.first]]}: {told_of(one, lines)}"
        out.append(_shown(swept, lines.ids[one.first], text, folder))
    return out


def _shown(swept: Swept, id: str, what: str, folder: Path) -> Shown:
    record = swept.records[id]
    # a run that broke is not kept: the sweep itself does it again
    command = f"gough sweep {shlex.quote(str(folder))}" if record["status"] == "broken" else rerun(folder, id)
    return Shown(id, what, command, record.get("settings", {}))


def rerun(folder: Path, id: str) -> str:
    """The command that does a run again, with a full log and a report."""
    return f"gough sweep {shlex.quote(str(folder))} --rerun {id[:SHORT]}"


# -- as text --------------------------------------------------------------------------------------------------------


def case_rows(swept: Swept, lines: Lines, cases: list[Case]) -> tuple[list[str], list[list[str]]]:
    """Heads and cells of the table of cases; of more than fit the best."""
    unit, labels, grid = told(swept.design.metric)[0], swept.experiment.labels, swept.design.grid()
    lists = [factor for factor in swept.design.factors if factor.distribution is None]
    limited = any(case.saturated for case in cases)
    heads = ["controller", *(factor.key for factor in lists), "runs", "failed", "median", "95 % below", "worst"]
    heads += ["at drive limits"] if limited else []
    shown = sorted(cases, key=rank) if len(cases) > MOST_CASES else cases
    rows = []
    for case in shown[:MOST_CASES]:
        numbers = ["-" if v is None else show(v, unit) for v in (case.median, case.most, case.worst)]
        point = [str(grid[case.point][factor.names[0]]) for factor in lists]
        numbers += [f"<= {100 * (case.saturated or 0.0):.3g} %"] if limited else []
        rows.append([labels[case.controller], *point, str(case.runs), str(case.failed), *numbers])
    return heads, rows


def effect_rows(swept: Swept, lines: Lines, effects: list[Effect]) -> tuple[list[str], list[list[str]]]:
    """Heads and cells of the table of effects, the largest first."""
    labels = swept.experiment.labels
    heads = ["factor", "controller", "from low to high values", "rank correlation"]
    told_ = [one for one in effects if math.isfinite(one.times) and one.times > 0]
    rows = []
    for one in sorted(told_, key=lambda e: -abs(math.log(e.times))):
        rank = "-" if one.rank is None else f"{one.rank:+.2f}"
        rows.append([lines.axes[one.factor].key, labels[one.controller], f"x {one.times:.3g}", rank])
    return heads, rows


def verdict(swept: Swept, lines: Lines, cases: list[Case]) -> str:
    """The conclusion in a sentence or two."""
    unit, labels = told(swept.design.metric)[0], swept.experiment.labels
    failed = int((lines.status != "done").sum())
    count = len(lines.ids)
    good = [case for case in cases if case.worst is not None]
    if not good:
        return f"All {count} runs failed."
    best = min(good, key=rank)
    text = f"{count} runs" + (f", {failed} failed" if failed else ", none failed") + ". "
    point = ", ".join(f"{key} = {value}" for key, value in swept.design.grid()[best.point].items())
    where = f"{labels[best.controller]}{f' with {point}' if point else ''}"
    if len(good) > 1:
        least = f" and {best.failed} failed runs" if best.failed else ""
        return f"{text}The least worst {swept.design.metric} has {where}: {show(best.worst, unit)}{least}."
    return f"{text}{swept.design.metric} of {where}: median {show(best.median, unit)}, worst {show(best.worst, unit)}."
