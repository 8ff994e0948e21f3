"""The claims table on a terminal."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import TYPE_CHECKING

from .claims import BY_DESIGN, MET, NOT_MET, Claim

if TYPE_CHECKING:
    from rich.table import Table

COLOURS = {MET: "green", NOT_MET: "bold red", BY_DESIGN: "yellow"}
HEADS = ("claim", "published", "measured", "band", "verdict")


def claims_table(title: str, claims: Sequence[Claim]) -> Table:
    """The rows of a study; notes stand below the table, by the numbers of their rows (`notes`)."""
    from rich import box
    from rich.markup import escape
    from rich.table import Table

    table = Table(title=escape(title), title_justify="left", box=box.SIMPLE_HEAD, pad_edge=False)
    for head in ("", *HEADS):
        table.add_column(head, justify="right" if head in ("", "published", "measured", "band") else "left")
    for number, claim in enumerate(claims, 1):
        cells = [escape(claim.text(what)) for what in ("published", "measured", "band")]
        verdict = f"[{COLOURS[claim.verdict]}]{claim.verdict}[/]"
        table.add_row(f"{number}", escape(claim.claim), *cells, verdict)
    return table


def plain_table(title: str, heads: Sequence[str], rows: Sequence[Sequence[str]]) -> Table:
    """A table of texts: the first two columns to the left, numbers to the right."""
    from rich import box
    from rich.markup import escape
    from rich.table import Table

    table = Table(title=escape(title), title_justify="left", box=box.SIMPLE_HEAD, pad_edge=False)
    for i, head in enumerate(heads):
        table.add_column(escape(head), justify="left" if i < 2 else "right")
    for row in rows:
        table.add_row(*map(escape, row))
    return table


def notes(claims: Sequence[Claim]) -> list[str]:
    """A line for every row with something to say, by its number; rows with the same note share one."""
    found: dict[str, list[str]] = {}
    for number, claim in enumerate(claims, 1):
        if claim.remark:
            found.setdefault(claim.remark, []).append(str(number))
    return [f"{', '.join(numbers)}: {text}" for text, numbers in found.items()]


def summary(claims: Sequence[Claim]) -> str:
    """How many rows have which verdict: "40 claims: 36 met (4 calibrated), 2 different by design, 2 not met"."""
    count = Counter(claim.verdict for claim in claims)
    calibrated = sum(1 for claim in claims if claim.calibrated and claim.verdict == MET)
    parts = [f"{count[MET]} met" + (f" ({calibrated} of them calibrated)" if calibrated else "")]
    parts += [f"{count[verdict]} {verdict}" for verdict in (BY_DESIGN, NOT_MET) if count[verdict]]
    return f"{len(claims)} claims: {', '.join(parts)}"
