"""What is recorded of a running LinuxCNC, as columns of HAL's samplers: full doubles, one row each servo period.

A sampler has at most 21 columns, so there are three; all run behind everything else in the servo thread, and row k of
one belongs to row k of the others.  Names here are those of the Recording.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

MOST = 21
DEPTH = 60_000  # rows that wait in memory: from LinuxCNC's start to the first look, and when the reader is late


class Column(NamedTuple):
    name: str  # of the recording, with the entry in brackets
    pin: str
    type: str  # f float, s signed, u unsigned, b bit
    signal: str | None = None  # that has the pin already


def channels_of(machine, name: str) -> list[list[Column]]:
    """Columns of each sampler for a machine of `export.linuxcnc` with that name."""
    n, letters = machine.joints_count, "xyzabc"[: len(machine.task)]
    comp = name.replace("_", "-")
    first = [Column(f"axis[{i}]", f"axis.{letter}.pos-cmd", "f") for i, letter in enumerate(letters)]
    first += [Column(f"joint[{i}]", f"joint.{i}.pos-cmd", "f", f"joint{i}-cmd") for i in range(n)]
    first += [
        Column("inhibit", "motion.feed-inhibit", "b", "gough-inhibit"),
        Column("line", "motion.program-line", "s"),
        Column("speed", "motion.current-vel", "f"),
        Column("homed", "motion.is-all-homed", "b", "homed"),
        Column("status", f"{name}.kins.status", "s"),
        Column("failures", f"{name}.kins.failures", "u"),
        Column("motion_type", "motion.motion-type", "s"),
    ]
    second = [Column(f"joint_rate[{i}]", f"joint.{i}.vel-cmd", "f", f"joint{i}-vel") for i in range(n)]
    second += [Column(f"joint_acceleration[{i}]", f"joint.{i}.acc-cmd", "f", f"joint{i}-acc") for i in range(n)]
    second += [Column(f"pose[{i}]", f"{name}.kins.{letter}", "f") for i, letter in enumerate(letters)]
    second += [
        Column("allowed", f"{comp}-following.allowed-0", "f"),
        Column("tripped_joint", f"{comp}-following.joint", "s"),
    ]
    third = [Column(f"read[{i}]", f"joint.{i}.pos-fb", "f", f"joint{i}-fb") for i in range(n)]
    third += [Column(f"force[{i}]", f"{comp}-feedforward.force-{i}", "f", f"joint{i}-force") for i in range(n)]
    third += [Column(f"wrench[{i}]", f"{comp}-observer.wrench-{i}", "f") for i in range(6)]
    third += [Column("held", f"{comp}-observer.held", "b"), Column("tripped", f"{comp}-following.tripped", "b")]
    return [first, second, third]


def types_of(channel: list[Column]) -> str:
    return "".join(column.type for column in channel)


def hal_of(channels: list[list[Column]]) -> str:
    """The HAL file that adds the samplers to a configuration."""
    lines = [
        f"loadrt sampler depth={','.join(str(DEPTH) for _ in channels)} cfg={','.join(map(types_of, channels))}",
        "net gough-inhibit => motion.feed-inhibit",
    ]
    for k, channel in enumerate(channels):
        for i, column in enumerate(channel):
            if column.signal:
                lines.append(f"net {column.signal} => sampler.{k}.pin.{i}")
            else:
                lines.append(f"net gough-{k}-{i} {column.pin} => sampler.{k}.pin.{i}")
        lines.append(f"addf sampler.{k} servo-thread")
    return "\n".join(lines) + "\n"


def rows_of(channels: list[list[Column]], raw: list[np.ndarray]) -> dict[str, np.ndarray]:
    """What the samplers wrote, raw (rows, 1 + columns) each, by name: (rows,) or (rows, entries)."""
    start = max(int(rows[0, 0]) for rows in raw)
    stop = min(int(rows[-1, 0]) for rows in raw) + 1
    found: dict[str, list[np.ndarray]] = {}
    for channel, rows in zip(channels, raw, strict=True):
        part = rows[start - int(rows[0, 0]) : stop - int(rows[0, 0])]
        for i, column in enumerate(channel):
            found.setdefault(column.name.partition("[")[0], []).append(part[:, 1 + i])
    entries = {column.name.partition("[")[0] for channel in channels for column in channel if "[" in column.name}
    return {name: np.stack(columns, 1) if name in entries else columns[0] for name, columns in found.items()}
