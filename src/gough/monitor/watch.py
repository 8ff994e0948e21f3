"""Watch: what a monitor has found in a log.  It prints itself, and goes into JSON, a Log and a figure."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..log import Log
from ..log.build import LogBuilder
from ..units import show
from .events import Events

_NAMES = ("fx", "fy", "fz", "mx", "my", "mz")
_SHOWN = 20  # events and findings of the table


class Sums:
    """Peaks and means over every sample."""

    def __init__(self):
        self.count = self.held = 0
        self.squares, self.low, self.high = np.zeros(6), np.full(6, np.inf), np.full(6, -np.inf)
        self.peak, self.peak_time, self.peak_force = 0.0, None, [0.0] * 3
        self.first, self.last, self.hidden = None, 0.0, np.zeros(6)

    def take(self, t, w, size, held, hidden) -> None:
        """Samples of the estimate w (N, 6); those that are held count as held only."""
        self.first = float(t[0]) if self.first is None else self.first
        self.last = float(t[-1])
        live = held == 0
        self.held += int((~live).sum())
        if not live.any():
            return
        t, w, size = t[live], w[live], size[live]
        self.count += len(t)
        self.squares += (w * w).sum(0)
        self.low, self.high = np.minimum(self.low, w.min(0)), np.maximum(self.high, w.max(0))
        self.hidden = np.maximum(self.hidden, hidden[live].max(0))
        top = int(np.argmax(size))
        if size[top] > self.peak:
            self.peak, self.peak_time, self.peak_force = float(size[top]), float(t[top]), w[top, :3].tolist()


class Watch:
    """The force on the tool over a log: numbers of every sample, events, and rows for plot and file."""

    def __init__(self, observer, record, events: Events, sums: Sums, rows: dict, every: int, noise):
        self.observer, self.machine = observer, observer.machine
        self.findings, self.samples = record.findings, record.samples
        self.missing, self.clipped = record.missing, record.clipped
        self.events, self.sums, self.rows, self.every, self.noise = events.found, sums, rows, every, noise
        self.counts = events.counts
        self.thresholds = {"alarm": events.alarm, "collision": events.collision, "breakage": events.breakage}

    def of(self, kind: str) -> list:
        """The events of a kind: "alarm", "collision", "breakage"."""
        return [event for event in self.events if event.kind == kind]

    def to_json(self) -> dict[str, Any]:
        """All numbers, SI."""
        s = self.sums
        rms = np.sqrt(s.squares / max(1, s.count))
        components = {
            name: {"min": float(s.low[i]), "max": float(s.high[i]), "rms": float(rms[i]), "hidden": float(s.hidden[i]),
                   "noise": float(self.noise[i])}
            for i, name in enumerate(_NAMES)
        } if s.count else {}  # fmt: skip
        return {
            "machine": self.machine.name,
            "samples": self.samples,
            "start": s.first,
            "end": s.last,
            "period": self.observer.period,
            "missing": self.missing,
            "clipped": self.clipped,
            "held": s.held,
            "bandwidth": self.observer.bandwidth,
            "form": self.observer.form,
            "peak": {"force": s.peak, "time": s.peak_time, "vector": s.peak_force},
            "components": components,
            "thresholds": self.thresholds,
            "counts": dict(self.counts),
            "events": [event.to_json() for event in self.events],
            "findings": self.findings.to_json(),
            "finding_counts": dict(self.findings.counts),
        }

    def to_log(self) -> Log:
        """The rows that are kept as a Log: t, wrench_hat, hidden, held, q_m, u."""
        rows = self.rows
        builder = LogBuilder(rows["t"], self.machine.task, self.machine.joints_count)
        for name, key in (("q_m", "q_m"), ("u", "u"), ("wrench_hat", "wrench_hat")):
            builder.add(name, rows[key])
        for name in ("hidden", "held"):
            dimension, unit, meaning = self.observer.found[name]
            builder.add(f"observer.{name}", rows[name], (dimension,) if dimension else (), unit, meaning)
        info = {
            "machine_name": self.machine.name, "joint_names": list(self.machine.joint_names),
            "machine": self.machine.to_file(), "hashes": {"machine": self.machine.digest()}, "monitor": self.to_json(),
            "kept": f"of every {self.every} samples the one with the largest force",
        }  # fmt: skip
        return builder.build(info)

    def __repr__(self) -> str:
        s, span = self.sums, self.sums.last - (self.sums.first or 0.0)
        T = self.observer.period
        lines = [
            f"<Watch> {self.machine.name}: {self.samples} samples, {span:.6g} s at {1 / T:g} Hz",
            f"  {self.observer.form} form, {self.observer.bandwidth:g} Hz; held {s.held} samples, "
            f"missing {self.missing}, cut off {self.clipped}",
        ]
        if s.peak_time is not None:
            lines.append(f"  peak force  {show(s.peak, 'N')} at t = {s.peak_time:.6g} s")
            lines.append("        least       greatest    rms         friction may hide   encoder noise")
            rms = np.sqrt(s.squares / max(1, s.count))
            for i, name in enumerate(_NAMES):
                unit = "N" if i < 3 else "N m"
                cells = (s.low[i], s.high[i], rms[i], s.hidden[i], self.noise[i])
                texts = [f"{value:.4g} {unit}" for value in cells]
                lines.append(f"  {name}    {texts[0]:11} {texts[1]:11} {texts[2]:11} {texts[3]:19} {texts[4]}")
        for kind, level in self.thresholds.items():
            if level is not None:
                count = self.counts[kind]
                lines.append(f"  {kind + 's':11} {count}, at {show(level, 'N')}")
        lines += [f"    {line}" for line in self._events()]
        told = [str(one) for one in self.findings.kept[:_SHOWN]]
        more = len(self.findings.kept) - len(told)
        lines += ["  the log:"] + [f"    {line}" for line in told] if told else []
        return "\n".join(lines + ([f"    and {more} more"] if more > 0 else []))

    def _events(self) -> list[str]:
        out = []
        for event in self.events[:_SHOWN]:
            span = f"t = {event.start:.6g} s"
            if event.end > event.start:
                span += f" to {event.end:.6g} s"
            text = f"{event.kind:9}  {span}  {show(event.peak, 'N')}"
            out.append(text + (f", {show(event.before, 'N')} before" if event.before is not None else ""))
        more = sum(self.counts.values()) - len(out)
        return out + ([f"and {more} more"] if more > 0 else [])
