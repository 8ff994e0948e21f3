"""Blocks in print: a table with a line a block, in the words and units of NC programs, cut in the middle when long."""

from __future__ import annotations

import numpy as np

from .blocks import ARC, CURVE, ELLIPSE, LINE, REST

MOST = 40  # lines of a table; of a longer one the first and last twenty


def listing(path, most: int = MOST) -> str:
    """The blocks of a path: NC line, word, end, angles if any, centre, feed and what may happen behind the block."""
    m = len(path)
    shown = np.arange(m) if m <= most else np.concatenate([np.arange(most // 2), np.arange(m - most // 2, m)])
    end = 1e3 * path.point(shown, path.length[shown])
    abc = np.degrees(path.angles(shown, path.extent[shown]))
    tilted = bool(path.abc0.any() or path.turn.any())
    rows = [_row(path, i, end[k], abc[k] if tilted else None) for k, i in enumerate(shown)]
    head = ["NC line", "move", "X", "Y", "Z", *("ABC" if tilted else ""), "centre", "F", "corner"]
    width = [max(len(row[k]) for row in [head, *rows]) for k in range(len(head))]
    left = {1, len(head) - 3, len(head) - 1}  # texts; numbers stand on the right
    lines = [_aligned(row, width, left) for row in [head, *rows]]
    if len(shown) < m:
        lines.insert(1 + most // 2, f"... {m - len(shown)} more ...")
    return "\n".join(lines)


def _row(path, i, end, abc):
    numbers = [_number(v, 4) for v in end] + ([] if abc is None else [_number(v, 4) for v in abc])
    centre = ""
    if path.kind[i] in (ARC, ELLIPSE):
        centre = " ".join(_number(1e3 * v, 4) for v in path.batches[path.kind[i]].center[path.index[i]])
    feed = ""
    if not path.rapid[i] and path.extent[i] > 0:
        feed = _number(path.feed[i] * (60 * 180 / np.pi if path.kind[i] == REST else 60e3), 3)
    line = str(path.line[i]) if path.line[i] else ""
    return [line, _word(path, i), *numbers, centre, feed, _corner(path.tolerance[i])]


def _word(path, i):
    kind = path.kind[i]
    if kind == REST:
        if path.turning_at_rest[i]:
            return "turn"
        return f"G4 P{_number(path.dwell[i], 4)}" if path.dwell[i] > 0 else "halt"
    if path.rapid[i]:
        return "G0"
    if kind == ARC:
        arcs = path.batches[ARC]
        up = (arcs.normal[path.index[i]])[2]
        word = "arc" if abs(up) < 1 - 1e-9 else "G3" if up > 0 else "G2"
        return word if arcs.rise[path.index[i]] == 0 else word + " helix"
    return {LINE: "G1", ELLIPSE: "ellipse", CURVE: "curve"}[int(kind)]


def _corner(tolerance):
    if tolerance <= 0:
        return "exact stop" if tolerance < 0 else ""
    return "blend" if np.isinf(tolerance) else f"blend {_number(1e3 * tolerance, 4)}"


def _number(value, digits):
    text = f"{value:.{digits}f}".rstrip("0").rstrip(".")
    return "0" if text in ("-0", "") else text


def _aligned(row, width, left):
    return "  ".join(
        t.ljust(w) if k in left else t.rjust(w) for k, (t, w) in enumerate(zip(row, width, strict=True))
    ).rstrip()
