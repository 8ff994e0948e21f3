"""Where each signal lies in the workspace: an array (slots, W), entry k of a signal in slot offset + k.

The logged signals come first, so a log row is one range; the states are one range that begins among them.

    | logged, no state | logged states | other states | wires | inputs | noise | parameters |
    0                  states.start    width          states.stop                          slots
"""

from __future__ import annotations

from dataclasses import dataclass

from .schedule import Schedule


@dataclass(frozen=True)
class Layout:
    offsets: dict[str, int]
    width: int  # of a log row
    states: slice
    slots: int
    columns: dict[str, slice]  # of a log row

    @classmethod
    def of(cls, schedule: Schedule) -> Layout:
        logged = [schedule.by_name[name] for name in schedule.log]
        rest = [s for s in schedule.signals if s.name not in schedule.log]
        order = [s for s in logged if s.kind != "state"] + [s for s in logged if s.kind == "state"]
        for kind in ("state", "wire", "input", "noise", "parameter"):
            order += [s for s in rest if s.kind == kind]
        offsets, slot = {}, 0
        for signal in order:
            offsets[signal.name] = slot
            slot += signal.size
        sizes = {s.name: s.size for s in order}
        states = [s.name for s in order if s.kind == "state"]
        first = offsets[states[0]] if states else 0
        stop = offsets[states[-1]] + sizes[states[-1]] if states else 0
        columns = {s.name: slice(offsets[s.name], offsets[s.name] + s.size) for s in logged}
        return cls(offsets, sum(s.size for s in logged), slice(first, stop), slot, columns)

    def at(self, name: str, size: int) -> slice:
        """The slots of a signal."""
        return slice(self.offsets[name], self.offsets[name] + size)
