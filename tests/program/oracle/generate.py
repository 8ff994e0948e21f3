"""Random NC programs of everything a milling program uses.  A seed gives the same program for ever."""

from __future__ import annotations

import re

import numpy as np

from .write_language import Language
from .write_machine import Machine
from .write_motion import Motion
from .writing import TOOLS

__all__ = ["TOOLS", "Writer", "with_inch_parameters"]


class Writer(Motion, Machine, Language):
    """One program: `text`, of so many pieces."""

    def __init__(self, seed: int, pieces: int = 22):
        super().__init__(seed)
        for _ in range(pieces):
            getattr(self, str(self.rng.choice(_PIECES, p=_SHARES)))()
        self._end()
        self.text = "\n".join(self.lines) + "\n"

    def _begin(self):
        self.percent = self.chance(0.2)
        if self.percent:
            self.lines.append("%")
        if self.chance(0.5):
            self.write("(a program)")
        self.lines.append(self.pick(["G21 G17 G90 G94 G91.1 G40 G49 G80", "G17 G21 G90", "g21 (mm) g90 f600"]))
        self.write(f"F{self.feed()}")

    def _end(self):
        if self.percent and self.chance(0.5):
            self.lines.append("%")
        else:
            self.write(self.pick(["M2", "M30"]))
            if self.chance(0.3):  # what else stands behind the end we refuse (docs/nc-differences.md)
                self.lines += ["(behind the end)", "", "o<behind> sub", "G0 X999", "o<behind> endsub"]


def with_inch_parameters(text: str) -> str:
    """The program for a machine whose numbered parameters hold inches: rs274 by itself is one, whatever it is told."""

    def setting(found):
        number_, value = int(found[1]), found[2].replace(" ", "")
        scale = 25.4 if (number_ - 5221) % 20 < 3 else 1.0
        return f"#{number_} = {float(value) / scale:.15f}"

    text = re.sub(r"#(5[23]\d\d) ?= ?([-+.\d ]+)", setting, text)
    return re.sub(r"= ?#5221", "= [#5221 * 25.4]", text)


_PIECES = {
    "straight": 20, "turn": 3, "unknown": 4, "set_feed": 1, "arc": 14, "inverse_time": 2, "units": 2, "distance": 4,
    "centers": 2, "select_plane": 4, "path_control": 3, "dwell": 1, "spindle": 2, "harmless": 5, "remember_modes": 1,
    "g92": 2, "select_system": 2, "set_system": 2, "set_system_by_parameter": 1, "home": 2, "machine_coordinates": 2,
    "tool": 4, "parameters": 4, "read_position": 2, "if_else": 2, "loop": 2, "subroutine": 2, "call_again": 1,
}  # fmt: skip
_SHARES = np.array(list(_PIECES.values())) / sum(_PIECES.values())
_PIECES = list(_PIECES)
