"""Claims: a published number, ours, and the verdict that follows from a band.

    met                    low <= measured <= high
    different by design    outside, and every piece of evidence that it must be so is inside its own band
    not met                outside otherwise; a number that is not finite, or that was not found, too

A verdict is computed, never written down.  A claim that is calibrated (something was chosen so that the number comes
out) says so: it is a check of our program, and says nothing of the paper.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from .. import units

MET, NOT_MET, BY_DESIGN = "met", "not met", "different by design"
Band = tuple[float | None, float | None]  # SI; None: no end on this side


@dataclass(frozen=True)
class Evidence:
    """A number of an experiment that shows why a published one cannot come out."""

    text: str
    measured: float
    unit: str
    band: Band
    shown: str | None = None

    @property
    def holds(self) -> bool:
        """Whether the number is in its band."""
        return inside(self.measured, self.band)

    def __str__(self) -> str:
        found, band = told(self.measured, self.unit, self.shown), told_band(self.band, self.unit, self.shown)
        return f"{self.text}: {found} ({band})"


@dataclass(frozen=True)
class Claim:
    """One row of the table: SI values, `shown` is the unit for people."""

    claim: str
    measured: float | None
    unit: str
    band: Band
    published: float | None = None
    shown: str | None = None
    note: str = ""
    calibrated: str = ""  # what was chosen so that this number comes out
    reason: str = ""  # one sentence: why the published number cannot come out
    evidence: Sequence[Evidence] = ()  # the experiment that proves `reason`

    def __post_init__(self):
        low, high = self.band
        if low is None and high is None or low is not None and high is not None and not low <= high:
            raise ValueError(f"{self.claim}: {self.band} is no band")
        if bool(self.reason) != bool(self.evidence):
            raise ValueError(f"{self.claim}: a reason needs evidence, and evidence a reason")

    @property
    def verdict(self) -> str:
        """What follows from measured, band and evidence."""
        if inside(self.measured, self.band):
            return MET
        if self.evidence and known(self.measured) and all(piece.holds for piece in self.evidence):
            return BY_DESIGN
        return NOT_MET

    @property
    def remark(self) -> str:
        """The note of the row: calibration, the reason of a difference with its evidence, and what else there is."""
        told = [f"calibrated: {self.calibrated}"] if self.calibrated else []
        if self.verdict != MET and self.reason:
            failing = [piece for piece in self.evidence if not piece.holds]
            shown = failing if self.verdict == NOT_MET else self.evidence
            head = "the evidence does not hold" if failing else self.reason
            told.append(f"{head} ({'; '.join(map(str, shown))})")
        return "; ".join([*told, *([self.note] if self.note else [])])

    def row(self, paper: str) -> dict[str, Any]:
        """The row of `gough reproduce --json`."""
        return {
            "paper": paper,
            "claim": self.claim,
            "published": self.published,
            "measured": self.measured if known(self.measured) else None,
            "unit": self.unit,
            "band": list(self.band),
            "verdict": self.verdict,
            "note": self.remark,
        }

    def text(self, what: str) -> str:
        """`published`, `measured` or `band` for people."""
        value = getattr(self, what)
        return told_band(value, self.unit, self.shown) if what == "band" else told(value, self.unit, self.shown)


def known(value: float | None) -> bool:
    """Whether there is a finite number."""
    return value is not None and math.isfinite(value)


def inside(value: float | None, band: Band) -> bool:
    """Whether a number is in a band; its ends belong to it."""
    low, high = band
    return known(value) and (low is None or value >= low) and (high is None or value <= high)


def told(value: float | None, unit: str, shown: str | None = None) -> str:
    """A number with its unit, three digits; "-" where there is none."""
    if value is None:
        return "-"
    if not math.isfinite(value):
        return str(value)
    shown = shown or unit
    if shown in ("", "1"):
        return f"{value:.3g}"
    return f"{_digits(value / units.factor(shown))} {shown}"


def told_band(band: Band, unit: str, shown: str | None = None) -> str:
    """A band for people: "8 to 12 um", "at most 20 um", "12"."""
    low, high = band
    if low is None:
        return f"at most {told(high, unit, shown)}"
    if high is None:
        return f"at least {told(low, unit, shown)}"
    if low == high:
        return told(low, unit, shown)
    first = told(low, unit, shown).partition(" ")[0]
    return f"{first} to {told(high, unit, shown)}"


def _digits(value: float) -> str:
    """Three digits without powers of ten where people would not write them: 4470 and not 4.47e+03."""
    return f"{value:.0f}" if 1000 <= abs(value) < 1e6 else f"{value:.3g}"
