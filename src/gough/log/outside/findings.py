"""What a record was found to have beside good rows: told by kind, with place, time and number."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

MOST = 200  # findings kept one by one; the rest is counted


@dataclass
class Finding:
    """One stretch of samples with something to tell."""

    kind: str  # missing, duplicate, jitter, cell, clipped, force, frozen, jump, counter, sign, order, machine, end
    rule: str
    line: int | None = None  # of the file; row for files without lines
    start: float | None = None  # s
    end: float | None = None  # s
    count: int = 1  # samples

    def __str__(self) -> str:
        place = "" if self.line is None else f" at line {self.line}"
        if self.start is None:
            return f"{self.rule}{place}"
        span = f", t = {self.start:.6g} s"
        if self.end is not None and self.end > self.start:
            span += f" to {self.end:.6g} s"
        return f"{self.rule}{place}{span}" + (f", {self.count} samples" if self.count > 1 else "")


class Findings:
    """All that was found: the first ones in full, all of them by number."""

    def __init__(self):
        self.kept: list[Finding] = []
        self.counts: dict[str, int] = {}  # samples a kind
        self._last: dict[str, Finding] = {}

    def add(self, finding: Finding, joined: float | None = None) -> None:
        """Keep a finding; one of the last one's rule that begins within `joined` s of its end is its continuation."""
        self.counts[finding.kind] = self.counts.get(finding.kind, 0) + finding.count
        last = self._last.get(finding.kind)
        if joined is not None and _follows(finding, last, joined):
            last.end, last.count = finding.end, last.count + finding.count
            return
        self._last[finding.kind] = finding
        if len(self.kept) < MOST:
            self.kept.append(finding)

    def to_json(self) -> list[dict[str, Any]]:
        """The findings that were kept, each an object."""
        return [{k: v for k, v in asdict(f).items() if v is not None} for f in self.kept]


def _follows(finding: Finding, last: Finding | None, joined: float) -> bool:
    if last is None or last.rule != finding.rule or last.end is None or finding.start is None:
        return False
    return finding.start - last.end <= joined
