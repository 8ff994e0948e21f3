"""Pieces of random programs: parameters, conditions, loops and subroutines."""

from __future__ import annotations

from .expressions import chain, number, tree
from .writing import Pen

_READABLE = (
    "#5420", "#5421", "#5422", "#5423", "#<_x>", "#<_y>", "#<_a>", "#5220", "#5221", "#<_metric>", "#<_feed>",
    "#<_absolute>", "#<_plane>", "#<_motion_mode>", "#<_line>", "#<_coord_system>",
)  # fmt: skip


class Language(Pen):
    """Each method writes one piece."""

    def parameters(self):
        name = self.pick(["#1", "#2", "#30", "#31", "#500", "#<mine>", "#<_ours>", "#<Two Words>", "#[3 + 4]"])
        kind = self.rng.integers(4)
        if kind == 0:
            text = tree(self.rng)[0]
        elif kind == 1:
            text = chain(self.rng, self.names)
        else:
            text = number(self.rng, float(self.rng.uniform(-9, 9)), 3)
        self.write(f"{name} = {text}")
        if name not in self.names:
            self.names.append(name)
        if self.chance(0.3):  # the old value on the same line
            self.write(f"#5=4 #6=[#5 + 1] {self.motion_word('G1')}X[#5 + 3] Y##7")
            self.lines[-2:-1] = [self.lines[-2], "#7=6"]
            self.names += [n for n in ("#5", "#6") if n not in self.names]
            self.forget("XY")

    def read_position(self):
        n = self.pick(_READABLE)
        self.write(f"#40 = {n}")
        self.write(f"{self.motion_word('G1')}Z[[#40] MOD 30]")
        self.forget("Z")

    def label(self):
        self.labels += 1
        return self.pick([f"o{self.labels}", f"O{self.labels}", f"o<name{self.labels}>", f"o < name {self.labels} >"])

    def step(self):
        """A small relative move, for bodies of loops."""
        self.motion = "G1"
        return f"G91 G1 {self.pick('XYZ')}{number(self.rng, float(self.rng.uniform(-3, 3)), 3)}"

    def after_flow(self):
        self.lines.append("G90")
        self.absolute = True
        self.motion = None
        self.forget()

    def condition(self):
        left = self.pick(self.names)
        op = self.pick(["LT", "GT", "LE", "GE", "EQ", "NE"])
        more = self.pick(["", "", " AND 1", " OR 0", " XOR 1"])
        return f"[{left} {op} {number(self.rng, float(self.rng.uniform(-5, 5)), 1)}{more}]"

    def if_else(self):
        o = self.label()
        self.lines += [f"{o} if {self.condition()}", self.step()]
        if self.chance(0.5):
            self.lines += [f"{o} elseif {self.condition()}", self.step()]
        if self.chance(0.7):
            self.lines += [f"{o} else", self.step()]
        self.lines += [f"{o} endif"]
        self.after_flow()

    def loop(self):
        o, count = self.label(), int(self.rng.integers(1, 5))
        out = []
        # LinuxCNC miscounts a `do` behind a while that was broken off, and a `repeat` behind a do that was continued
        # (docs/nc-differences.md); it knows no break in a repeat
        kind = self.pick([kind for kind in ("while", "do", "repeat") if kind not in self.miscounted])
        if kind != "repeat" and self.chance(0.4):
            inner, word = self.label(), self.pick(["break", "continue"])
            out = [f"{inner} if [#41 GT {count - 1}]", f"  {o} {word}", f"{inner} endif"]
            self.miscounted |= {("while", "break"): {"do"}, ("do", "continue"): {"repeat"}}.get((kind, word), set())
        step = self.step()
        if kind == "while":
            lines = ["#41=0", f"{o} while [#41 LT {count}]", "#41=[#41 + 1]", *out, step, f"{o} endwhile"]
        elif kind == "do":
            lines = ["#41=0", f"{o} do", "#41=[#41 + 1]", *out, step, f"{o} while [#41 LT {count}]"]
        else:
            lines = ["#41=0", f"{o} repeat [{count}]", "#41=[#41 + 1]", *out, step, f"{o} endrepeat"]
        self.lines += lines
        self.after_flow()

    def subroutine(self):
        self.labels += 1
        o = self.pick([f"o{self.labels}", f"o<part{self.labels}>"])
        body = ["G91 G1 X[#1] Y[#2 + #3]", "#<local> = [#1 * 2]", "#31 = #<local>", "G1 Z[#<local> MOD 3]"]
        if self.chance(0.3):
            body.append(f"{o} return [#1 + 1]")
        end = self.pick(["endsub", "endsub [#31 + 2]"])
        self.lines += [f"{o} sub", *body, f"{o} {end}"]
        self.names += [] if "#31" in self.names else ["#31"]
        for _ in range(self.rng.integers(1, 3)):
            self.lines.append(f"{o} call [{self.length(-5, 5)}] [{self.length(-5, 5)}] [{self.length(-5, 5)}]")
            if "[" in end:
                self.lines += ["G1 X[#<_value>]", "G1 Y[#<_value_returned>]"]
        self.subs.append(o)
        self.after_flow()

    def call_again(self):
        if self.subs:
            self.lines.append(f"{self.pick(self.subs)} call [1.5] [#1]")
            self.after_flow()
