"""What a log says when it is printed: what ran, how long, ranges, and the contour error.  A failure comes first."""

from __future__ import annotations

import html as html_module
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import UnitError
from ..units import show, to_si

if TYPE_CHECKING:
    from .log import Log

# the signals of the short view, in reading order
MAIN = ("x", "xd", "q", "q_r", "u", "lag", "orientation_error", "contour_error")


def title(log: Log) -> str:
    """ "nist-octahedral · pid · part.ngc", as much of it as is known."""
    info = log.info
    program = info.get("program")
    program = program.get("name") if isinstance(program, dict) else None
    names = [info.get("machine_name"), info.get("controller_kind"), program]
    return " · ".join(str(name) for name in names if name) or "log"


def text(log: Log) -> str:
    """The view of `print(log)`."""
    lines = [f"<Log> {title(log)}"]
    if log.failed:
        lines.insert(0, f"<Log> FAILED: {log.reason}")
        lines[1] = f"  {title(log)}"
    lines.append(f"  {_extent(log)}")
    lines += [f"  {name:<17} {size:<6} {units:<12} {span}" for name, size, units, span in _ranges(log)]
    lines += [f"  {line}" for line in _contour(log)]
    more = len(log.dataset.data_vars) - len(_ranges(log))
    if log.batch:
        lines.append("  one run: log.run(0); every run in numbers: gk.measure(log)")
    if more > 0:
        lines.append(f"  and {more} more variables: log.dataset")
    return "\n".join(lines)


def html(log: Log) -> str:
    """The view of notebooks.  Every text is escaped."""
    esc = html_module.escape
    parts = []
    if log.failed:
        parts.append(f'<p style="color:#b00020"><strong>FAILED: {esc(log.reason)}</strong></p>')
    parts.append(f"<p><strong>{esc(title(log))}</strong><br>{esc(_extent(log))}</p>")
    rows = ["".join(f'<td style="text-align:left">{esc(cell)}</td>' for cell in row) for row in _ranges(log)]
    cells = "".join(f"<tr>{row}</tr>" for row in rows)
    parts.append(f"<table>{cells}</table>")
    parts += [f"<p>{esc(line)}</p>" for line in _contour(log)]
    return f"<div>{''.join(parts)}</div>"


def _extent(log: Log) -> str:
    n, t = len(log), log.t
    rows = f"{n} rows" if n != 1 else "1 row"
    period = _period(log.info.get("run"))
    samples = None if log.batch else log.metrics.get("samples")
    out = f"{t[-1] - t[0]:.4g} s" if n else "0 s"
    if period:
        out += f" at {1 / period:.6g} Hz"
    if log.batch:
        runs = f"{log.dataset.sizes['run']} runs"
        return f"{runs}, {out}, {rows} kept" if n else f"{runs}, metrics only"
    if samples is not None and samples != n:
        return f"{out}, {samples} samples, {rows} kept"
    return f"{out}, {n} sample" + ("" if n == 1 else "s")


def _ranges(log: Log) -> list[tuple[str, str, str, str]]:
    out = []
    for name in MAIN:
        if name not in log:
            continue
        array = log.dataset[name]
        size = f"({', '.join(str(n) for n in array.shape[1:])})" if array.ndim > 2 else ""
        size = f"({array.shape[1]},)" if array.ndim == 2 else size
        if log.batch and not len(log):
            continue
        out.append((name, size, str(array.attrs.get("units", "1")), span(array.values)))
    return out


def span(values: np.ndarray) -> str:
    """ "-0.02 ... +0.7"; what is not finite is counted, never hidden."""
    finite = np.isfinite(values)
    if not values.size:
        return "no rows"
    if not finite.any():
        return "not finite"
    low, high = values[finite].min(), values[finite].max()
    missing = values.size - int(finite.sum())
    return f"{low:+.4g} ... {high:+.4g}" + (f"   ({missing} values not finite)" if missing else "")


def _contour(log: Log) -> list[str]:
    if log.batch:
        return _contours(log)
    found = contour(log)
    if not found:
        return []
    out = "contour error   "
    out += "   ".join(f"{key} {show(found[key], 'm', 3)}" for key in ("rms", "max") if key in found)
    if "at" in found:
        out += f" at t = {found['at']:.4g} s"
    if found.get("line"):
        out += f" (line {found['line']:.0f})"
    return [out]


def _contours(log: Log) -> list[str]:
    """The contour errors of a batch: their span over the runs, and the worst run."""
    known = log.metrics.get("contour_error") or {}
    spans = []
    for key in ("rms", "max"):
        values = np.asarray(known.get(key, ()), float)
        if np.isfinite(values).any():
            spans.append(f"{key} {show(np.nanmin(values), 'm', 3)} ... {show(np.nanmax(values), 'm', 3)}")
    if not spans:
        return []
    largest = known.get("max", known["rms"])
    worst = int(np.nanargmax(largest))
    name = str(log.runs[worst].get("label", worst)) if worst < len(log.runs) else str(worst)
    return ["contour error   " + "   ".join(spans) + f", largest in run {name}"]


def contour(log: Log) -> dict[str, float]:
    """rms, max, at, line of the contour error: from the metrics, else from the counted rows.  Empty if unknown.

    Of a batch it is empty: each run has its own.
    """
    if log.batch:
        return {}
    known = log.metrics.get("contour_error")
    if isinstance(known, dict):
        if not isinstance(known.get("max"), int | float):
            return {}
        return {key: known[key] for key in ("rms", "max", "at", "line") if isinstance(known.get(key), int | float)}
    if "contour_error" not in log or not len(log):
        return {}
    error, t = log["contour_error"], log.t
    counted = log["counted"].astype(bool) if "counted" in log else np.ones(len(t), bool)
    if not counted.any():
        return {}
    error, t = error[counted], t[counted]
    worst = int(np.argmax(error))  # of a NaN the argmax is the NaN: it shows
    out = {"rms": float(np.sqrt(np.mean(error**2))), "max": float(error[worst]), "at": float(t[worst])}
    if "line" in log:
        out["line"] = int(log["line"][counted][worst])
    return out


def _period(run: Any) -> float | None:
    """Seconds of info["run"]["period"], a number or a quantity such as "0.001 s"; None if there is none."""
    value = run.get("period") if isinstance(run, dict) else None
    if isinstance(value, str):
        try:
            value = to_si(value, "s")
        except UnitError:
            return None
    return value if isinstance(value, int | float) and value > 0 else None
