"""Pieces of random programs: lines, turns and arcs."""

from __future__ import annotations

import math

from .expressions import chain, number
from .writing import AXES, Pen

_OFFSETS_OF = {"XY": "IJ", "YZ": "JK", "ZX": "KI"}


class Motion(Pen):
    """Each method writes one piece."""

    def straight(self):
        letters = [a for a in AXES if self.chance(0.45 if a in "XYZ" else 0.12)] or ["X"]
        self.rng.shuffle(letters)
        words = [self.word(a, self.target(a)) for a in letters]
        head = self.motion_word(self.pick(["G0", "G1", "G1"]))
        tail = f" F{self.feed()}" if self.chance(0.15) else ""
        self.write(f"{head}{' '.join(words)}{tail}")

    def turn(self):
        letters = [a for a in "ABC" if self.chance(0.6)] or ["C"]
        words = [self.word(a, self.target(a)) for a in letters]
        self.write(f"{self.motion_word(self.pick(['G0', 'G1']))}{' '.join(words)}")

    def unknown(self):
        """A move by an expression whose value nobody tells."""
        letter = self.pick("XYZ")
        self.write(f"{self.motion_word('G1')}{letter}{chain(self.rng, self.names)}")
        self.forget(letter)

    def set_feed(self):
        self.write(f"F{self.feed()}")

    def arc(self):
        axis_1, axis_2 = self.plane
        if self.absolute or not self.relative_centers:
            missing = [a for a in self.plane if self.at[a] is None]
            if missing:
                was, self.absolute = self.absolute, True
                self.motion = "G0"
                self.write(f"G90 G0 {' '.join(self.word(a, self.target(a)) for a in missing)}")
                self.absolute = was
                if not was:
                    self.write("G91")
        start = {a: self.at[a] if self.at[a] is not None else 0.0 for a in self.plane}
        radius, begin = float(self.rng.uniform(2, 40)) / self.unit, float(self.rng.uniform(0, 2 * math.pi))
        sweep, kind = float(self.rng.uniform(0.3, 5.9)), self.pick(["center", "center", "radius", "full"])
        if kind == "radius" and not (0.3 < sweep < 2.5 or 3.8 < sweep < 5.9):
            sweep = 1.9  # near half a circle the centre is badly determined by R
        code = self.pick(["G2", "G3"])
        sense = 1 if code == "G3" else -1
        c = [start[axis_1] - radius * math.cos(begin), start[axis_2] - radius * math.sin(begin)]
        if kind == "full":
            sweep = 2 * math.pi
        end = {
            axis_1: c[0] + radius * math.cos(begin + sense * sweep),
            axis_2: c[1] + radius * math.sin(begin + sense * sweep),
        }
        if kind == "full":
            end = dict(start)
        words = []
        if kind != "full" or self.chance(0.5):
            for a in self.plane:
                words.append(f"{a}{self.value(end[a] if self.absolute else end[a] - start[a], exactly=True)}")
        known = {a: self.at[a] is not None for a in self.plane}
        for a in self.plane:
            self.at[a] = end[a] if known[a] else None
        if kind == "radius":
            words.append(f"R{self.value(radius if sweep < math.pi else -radius, exactly=True)}")
        else:
            for a, letter, center in zip(self.plane, _OFFSETS_OF[self.plane], c, strict=True):
                offset = center - start[a] if self.relative_centers else center
                words.append(f"{letter}{self.value(offset, exactly=True)}")
        for a in AXES:
            if a not in self.plane and self.chance(0.4 if a in "XYZ" else 0.1):
                words.append(self.word(a, self.target(a)))
        if self.chance(0.25):
            words.append(f"P{self.rng.integers(1, 5)}")
        if self.chance(0.2):
            self.rng.shuffle(words)
        self.write(f"{self.motion_word(code)}{' '.join(words)}")

    def inverse_time(self):
        self.write(self.pick(["G93", "G93 (inverse time)"]))
        for _ in range(self.rng.integers(1, 4)):
            letters = self.pick(["X", "XY", "XYZ", "A", "XC", "BC"])
            words = [self.word(a, self.target(a)) for a in letters]
            self.motion = "G1"
            self.write(f"G1 {' '.join(words)} F{number(self.rng, float(self.rng.uniform(1, 60)), 2)}")
        self.write(f"G94 F{self.feed()}")
