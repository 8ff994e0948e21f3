"""The pen of the random programs: numbers, words and lines in all their writings, and how far it knows where it is.

A coordinate it does not know (after an offset, a subroutine, an expression) is None, and an arc that needs it writes it
first.
"""

from __future__ import annotations

import numpy as np

from .expressions import number, tree

AXES = "XYZABC"
# number, x, y, z in mm, of the tool table every program may use
TOOLS = ((1, 0.0, 0.0, 10.0), (2, 1.0, 2.0, 20.5), (7, 0.0, 0.0, -30.0), (12, 0.0, -3.0, 55.125))


class Pen:
    """What has been written of a program, `lines`, and the state that the next line is written in."""

    def __init__(self, seed: int):
        self.rng = np.random.default_rng([seed, 274])
        self.at: dict[str, float | None] = dict.fromkeys(AXES, 0.0)
        self.absolute = self.relative_centers = True
        self.unit, self.plane, self.motion = 1.0, "XY", None
        self.lines: list[str] = []
        self.labels, self.spare = 100, 50
        self.subs: list[str] = []
        self.names = ["#1", "#31", "#500"]
        self.tool_used = False
        self.rotated = False
        self.miscounted: set[str] = set()
        self._begin()

    def chance(self, p):
        return bool(self.rng.random() < p)

    def pick(self, options):
        options = list(options)
        return options[self.rng.integers(len(options))]

    def write(self, line):
        """A line in some other writing that means the same."""
        if "(" not in line and ";" not in line and "<" not in line:
            if self.chance(0.15):
                line = line.lower()
            if self.chance(0.05):
                line = line.replace(" ", "")
            if self.chance(0.05):
                line = line.replace(".", " . ")
        if self.chance(0.1) and line[:1] not in "oO(%/":
            line = f"N{self.rng.integers(1, 99999)} {line}"
        if self.chance(0.05) and "(" not in line and ";" not in line:
            line += self.pick([" (a note)", " ; a note", "\t", "  ", " (x1 y2 #3=4)", " ;(open"])
        self.lines.append(line)

    def length(self, low=-60.0, high=60.0):
        """In the program's unit, four decimals."""
        return round(float(self.rng.uniform(low, high)) / self.unit, 4)

    def value(self, value, exactly=False):
        """A number as written: sometimes a parameter or an expression of this value."""
        if exactly:
            return f"{value:.12f}"
        kind = self.rng.integers(14)
        if kind == 0:
            text, own = tree(self.rng)
            return f"[{value - own:.12f} + {text}]"
        if kind == 1:
            self.spare = 50 + (self.spare - 49) % 40  # not one that this line uses already
            self.write(f"#{self.spare} = {value:.12f}")
            return f"#{self.spare}"
        if kind == 2:
            return f"[{value * 2:.12f} / 2]"
        return number(self.rng, value)

    def word(self, letter, target):
        """The word that takes this axis to `target`, known from now on."""
        if not self.absolute:
            target = round(float(self.rng.uniform(-20, 20)) / (self.unit if letter in "XYZ" else 1.0), 4)
            known = self.at[letter]
            self.at[letter] = None if known is None else known + target
        else:
            self.at[letter] = target
        return f"{letter}{self.value(target)}"

    def motion_word(self, code):
        """The motion's word, or nothing where it is in force already."""
        if self.motion == code and self.chance(0.4):
            return ""
        self.motion = code
        return self.pick([f"{code} ", f"{code[0]}0{code[1:]} "])

    def forget(self, letters=AXES):
        for letter in letters:
            self.at[letter] = None

    def target(self, letter):
        return self.length() if letter in "XYZ" else round(float(self.rng.uniform(-25, 25)), 4)

    def feed(self):
        # one decimal: with more M72 brings back another feed (docs/nc-differences.md)
        return number(self.rng, float(self.rng.uniform(50, 3000)) / self.unit, 1)

    def some_axes(self, least=1, upright=False):
        letters = [a for a in AXES if self.chance(0.4 if a in "XYZ" else 0.15)]
        if upright and self.tool_used:
            letters = [a for a in letters if a in "XYZ"]
        return letters if len(letters) >= least else ["X", "Z"]

    def upright(self, always=False):
        """With a tool offset in force, LinuxCNC and we differ where the tool is tilted (docs/nc-differences.md)."""
        if self.tool_used or always:
            self.motion = "G0"
            self.absolute = True
            words = " ".join(f"{a}{self.length()}" for a in "XYZ")
            self.lines.append(f"G90 G53 G0 {words} A0 B0 C0")
            self.forget()
