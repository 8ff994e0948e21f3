"""Our reading of an NC program as a list of moves, and how two such lists differ."""

from __future__ import annotations

import itertools

import numpy as np

from gough.program.blocks import Arc, Rest

from .canon import INCH, Move

MM, DEG = 1e3, np.degrees(1.0)


def of_blocks(blocks) -> list[Move]:
    """Our blocks as LinuxCNC's canon would tell them.

    A turn of the tool at rest is a rapid or a feed; a rest without time and turn is a stop.
    """
    return [_move(block) for block in blocks]


def _move(block) -> Move:
    segment, abc0, abc1 = block.segment, DEG * np.array(block.abc0), DEG * np.array(block.abc1)
    kind, more, per_minute = "rapid" if block.rapid else "feed", {}, 60 * MM
    if isinstance(segment, Rest):
        start = end = MM * np.array(segment.at)
        per_minute = 60 * DEG
        if block.dwell:
            kind = "dwell"
        elif np.array_equal(abc0, abc1):
            kind = "stop"
    elif isinstance(segment, Arc):
        kind = "arc"
        start, center, normal = MM * np.array(segment.start), MM * np.array(segment.center), np.array(segment.normal)
        normal = normal * np.sign(segment.sweep)
        sweep, rise = abs(segment.sweep), MM * segment.rise * np.sign(segment.sweep)
        center = center + normal * (normal @ (start - center))
        radial = start - center
        end = center + np.cos(sweep) * radial + np.sin(sweep) * np.cross(normal, radial) + rise * normal
        more = {"center": center, "normal": normal, "sweep": np.degrees(sweep)}
    else:
        start, end = MM * np.array(segment.start), MM * np.array(segment.end)
    return Move(
        kind, block.line, np.concatenate([start, abc0]), np.concatenate([end, abc1]), feed=per_minute * block.feed,
        dwell=block.dwell, tool=MM * np.array(block.tool), tolerance=MM * block.tolerance if block.tolerance > 0 else
        block.tolerance, spindle=block.spindle, **more,
    )  # fmt: skip


def tidied(moves) -> list[Move]:
    """One stop of several in a row, none at the end, and no arc of another sense where only the sign is open."""
    out = [next(group) for _, group in itertools.groupby(moves, key=lambda m: (m.kind == "stop") or id(m))]
    while out and out[-1].kind == "stop":
        out.pop()
    return out


def hidden(move) -> bool:
    """A straight move too short to be seen in rs274's print."""
    step = np.abs(move.end - move.start)
    return step[:3].max() <= 8 * 0.5e-4 * INCH and step[3:].max() == 0


def differences(ours, theirs, *, length: float, degrees: float, full: bool) -> list[str]:
    """What differs, in words; empty if nothing does.  `length` mm and `degrees` are what is allowed.

    `full`: of the module gcode, with line numbers and without stops, tolerance and spindle; else of rs274's print.
    """
    if full:
        ours, theirs = ([m for m in moves if m.kind != "stop"] for moves in (ours, theirs))
    else:  # rs274's rounding hides them
        ours = [m for m in ours if m.kind not in ("rapid", "feed") or not hidden(m)]
    ours, theirs = tidied(ours), tidied(theirs)
    out = []
    for k, (a, b) in enumerate(itertools.zip_longest(ours, theirs)):
        if a is None or b is None or a.kind != b.kind:
            out.append(f"move {k}: {_tell(a)}, LinuxCNC has {_tell(b)}")
            break
        wrong = _differing(a, b, length, degrees, full)
        if wrong:
            line = a.line if a.line is not None else b.line
            out.append(f"move {k} ({a.kind}, line {line}): " + "; ".join(wrong))
        if len(out) > 5:
            break
    return out


def _tell(move):
    if move is None:
        return "no move"
    return f"{move.kind} of line {move.line} to {np.round(move.end, 6).tolist()}"


def _differing(a, b, length, degrees, full):
    out = []

    def check(name, ours, theirs, allowed):
        off = np.abs(np.asarray(ours) - np.asarray(theirs)).max()
        if not off <= allowed:
            out.append(f"{name} {np.round(ours, 7).tolist()}, LinuxCNC {np.round(theirs, 7).tolist()}, off {off:.3g}")

    if a.kind != "stop":
        check("end", a.end[:3], b.end[:3], length)
        check("angles", a.end[3:], b.end[3:], degrees)
        check("start", a.start, b.start, max(length, degrees))
        check("tool", a.tool, b.tool, length)
    if a.kind == "arc":
        # LinuxCNC takes the centre as written, we the nearest one with both ends on the circle
        radius = np.linalg.norm(a.start[:3] - a.center)
        check("normal", a.normal, b.normal, 1e-9)
        # where the ends are known to `length` only, the centre through them is known this much less
        vague = 1.0 if full else 2.0 / max(np.sin(np.radians(min(a.sweep % 360, 360 - a.sweep % 360)) / 2), 0.05)
        check("center", a.center, b.center, length * vague)
        sweep = b.sweep
        if not full:  # rounded ends may meet or not: whole turns are gcode's to tell
            sweep += 360 * np.round((a.sweep - sweep) / 360)
        check("sweep", a.sweep, sweep, max(degrees, np.degrees(2 * vague * length / radius)))
    if a.kind == "dwell":
        check("dwell", a.dwell, b.dwell, 1e-9 if full else 0.5e-4)
    if full and a.line != b.line:
        out.append(f"line {a.line}, LinuxCNC {b.line}")
    # slower than 0.1 of the program's unit per minute a feed of G93 is not, there (docs/nc-differences.md)
    if a.kind in ("feed", "arc") and b.feed > 0.101 * INCH:
        feed = b.feed
        if full and a.feed < 0.5 * feed and np.abs(a.end - a.start)[:3].max() < length:
            feed /= INCH  # of a turn gcode does not tell whether F was written in an inch program
        check("feed", a.feed, feed, 1e-9 * feed if full else 0.6e-4 * INCH + 1e-7 * feed)
    if not full and a.kind != "stop":
        if b.tolerance is not None and np.isinf(b.tolerance) != np.isinf(a.tolerance):
            out.append(f"tolerance {a.tolerance}, LinuxCNC {b.tolerance}")
        elif b.tolerance is not None and np.isfinite(b.tolerance):
            check("tolerance", a.tolerance, b.tolerance, 0.6e-6 * INCH)
        check("spindle", a.spindle, b.spindle, 0.5e-4)
    return out
