"""What a Fit says when it is printed: value, deviation, unit, and what the motion could not show."""

from __future__ import annotations

import math
import textwrap
from typing import TYPE_CHECKING

from ..errors import RunError

if TYPE_CHECKING:
    from .fit import Fit

_WIDTH = 100
_MORE = 1.2  # times that of noise, from which it is said: noise alone comes to 1.1
_FAR = 3.0  # deviations from the sheet that are marked


def text(fit: Fit) -> str:
    """The table and what stands below it."""
    found = fit.estimate
    time = found.rows.step * len(found.rows.u)
    length = f", {time:.4g} s" if time else ""
    lines = [
        f"{fit.machine.name}: {found.base.rank} parameters from {len(found.rows.u)} rows of "
        f"{len(found.rows.joints)} joints{length}",
        "",
    ]
    cells = [("parameter", "value", "deviation", "unit", "sheet")]
    for name, value, std, unit, sheet in zip(fit.names, fit.values, fit.std, fit.units, fit.sheet, strict=True):
        mark = " *" if abs(value - sheet) > _FAR * std else ""
        cells.append((name, *_shown(value, std), unit, f"{sheet:.5g}{mark}"))
    widths = [max(len(row[i]) for row in cells) for i in range(5)]
    for row in cells:
        numbers = "  ".join(cell.rjust(w) for cell, w in zip(row[1:3], widths[1:3], strict=True))
        lines.append(f"{row[0].ljust(widths[0])}  {numbers}  {row[3].ljust(widths[3])}  {row[4]}".rstrip())
    lines.insert(3, "-" * max(map(len, lines)))
    lines.append("")
    lines += textwrap.wrap(f"deviation: {_deviation(found)}", _WIDTH, subsequent_indent="  ")
    if any(row[4].endswith("*") for row in cells):
        lines.append(f"* more than {_FAR:g} deviations from the sheet")
    lines.append(
        f"residual {found.residual_rms:.3g} N rms, {found.held_out_rms:.3g} N on motion held out; "
        f"condition number {found.base.condition:.3g}"
    )
    for head, names in (
        ("this motion does not show", fit.unseen),
        ("no motion shows", fit.never),
        ("seen only together with others", fit.together),
    ):
        if names:
            lines += textwrap.wrap(f"{head}: {', '.join(names)}", _WIDTH, subsequent_indent="  ")
    lines += textwrap.wrap(_bodies(fit), _WIDTH, subsequent_indent="  ")
    lines += [f"note: {note}" for note in fit.notes]
    return "\n".join(lines)


def _deviation(found) -> str:
    """What the column of deviations is worth."""
    if found.factor is None:
        for_how_long = f"{found.memory * found.rows.step:.2g} s" if found.rows.step else f"{found.memory:.2g} rows"
        return (
            f"that of noise alone, so a lower bound: what is left hangs together for {for_how_long}, too long on this "
            "motion to tell noise from what the model lacks"
        )
    text = "standard deviation; where the model holds, 95 of 100 estimates are within two of the truth"
    if found.factor > _MORE:
        text += f"; {found.factor:.2g} times that of noise, as what is left comes where the motion does"
    return text


def _bodies(fit: Fit) -> str:
    try:
        wrong = fit.impossible
    except RunError as error:
        return f"bodies: {error}"
    if not wrong:
        return ""
    return (
        f"no body has these numbers: {', '.join(wrong)}; the nearest of bodies that can exist are up to "
        f"{fit.physical.away:.2g} deviations away (fit.physical)"
    )


def _shown(value: float, std: float) -> tuple[str, str]:
    """A value to the place of the second digit of its deviation."""
    if not std > 0 or not math.isfinite(std):
        return f"{value:.10g}", f"{std:.2g}"
    place = 1 - math.floor(math.log10(std))
    if -3 <= place <= 9:
        digits = max(0, place)
        return f"{round(value, place):.{digits}f}", f"{round(std, place):.{digits}f}"
    return f"{value:.10g}", f"{std:.2g}"
