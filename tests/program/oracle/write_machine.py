"""Pieces of random programs: modes, offsets, tools, and what else is asked of a machine."""

from __future__ import annotations

from .expressions import number
from .writing import TOOLS, Pen

_PLANES = {"G17": "XY", "G18": "ZX", "G19": "YZ"}
_SYSTEMS = ("G54", "G55", "G56", "G57", "G58", "G59", "G59.1", "G59.2", "G59.3")


class Machine(Pen):
    """Each method writes one piece."""

    def units(self):
        if self.tool_used:  # LinuxCNC reads the old number in the new unit (docs/nc-differences.md)
            self.upright()
            self.lines.append("G49")
        inch = self.chance(0.5)
        unit = 25.4 if inch else 1.0
        for a in "XYZ":
            if self.at[a] is not None:
                self.at[a] *= self.unit / unit
        self.unit = unit
        self.write("G20" if inch else "G21")
        self.write(f"F{self.feed()}")

    def distance(self):
        self.absolute = self.chance(0.5)
        self.write("G90" if self.absolute else "G91")

    def centers(self):
        self.relative_centers = self.chance(0.6)
        self.write("G91.1" if self.relative_centers else "G90.1")

    def select_plane(self):
        code = self.pick(_PLANES)
        self.plane = _PLANES[code]
        self.write(code)

    def path_control(self):
        p, q = (number(self.rng, float(self.rng.uniform(0.01, 0.5)) / self.unit) for _ in range(2))
        self.write(self.pick(["G61", "G61.1", "G64", f"G64 P{p}", f"G64 P{p} Q{q}"]))

    def dwell(self):
        self.write(f"G4 P{number(self.rng, float(self.rng.uniform(0, 2)), 2)}")

    def spindle(self):
        s = number(self.rng, float(self.rng.uniform(0, 9000)), 0)
        self.write(self.pick([f"M3 S{s}", f"S{s}", "M5", f"S{s} M4", f"G97 S{s}"]))

    def harmless(self):
        self.write(self.pick([
            "M7", "M8", "M9", "M48", "M49", "M50 P1", "M51 P0", "M52 P1", "M53 P1", "G40", "G80", "G98", "G99",
            "M0", "M1", "M60",
            "(MSG, look)", "(a comment)", "; a comment", "", "(DEBUG, #1 is)", "(PRINT, hello)", "/G4 P0.25",
        ]))  # fmt: skip
        if "80" in self.lines[-1]:
            self.motion = None

    def remember_modes(self):
        if self.chance(0.5):
            self.write("M70")
            self.lines += [self.pick(["G91", "G90"]), self.pick(["G20", "G21"]), self.pick(["G18", "G17"])]
            self.write("M72")
            return
        self.labels += 1
        name = f"mode{self.labels}"
        self.lines += [f"o<{name}> sub", "M73", self.pick(["G91", "G90"]), self.pick(["G20", "G21"]), "F123",
                       f"o<{name}> endsub", f"o<{name}> call"]  # fmt: skip

    # -- offsets and tools --------------------------------------------------------------------------------------------

    def offset_words(self):
        return " ".join(f"{a}{self.value(self.target(a))}" for a in self.some_axes())

    def g92(self):
        self.write(self.pick([f"G92 {self.offset_words()}"] * 3 + ["G92.1", "G92.2", "G92.3"]))
        self.forget()

    def select_system(self):
        self.unshift()
        self.write(self.pick(_SYSTEMS))
        self.forget()

    def unshift(self):
        """Where the axes turn while G92 is in force, LinuxCNC loses its place (docs/nc-differences.md)."""
        if self.rotated:
            self.write("G92.1")

    def set_system(self):
        p = self.rng.integers(0, 10)
        kind = self.rng.integers(3)
        if kind == 2:
            self.rotated = True
            self.unshift()
        if kind == 0:
            self.write(f"G10 L20 P{p} {self.offset_words()}")
        elif kind == 1:
            self.write(f"G10 L2 P{p} {self.offset_words()}")
        else:
            self.write(f"G10 L2 P{p} {self.offset_words()} R{number(self.rng, float(self.rng.uniform(-90, 90)), 2)}")
        self.forget()

    def set_system_by_parameter(self):
        n = 5221 + 20 * int(self.rng.integers(1, 9)) + int(self.rng.integers(0, 6))
        self.write(f"#{n} = {number(self.rng, float(self.rng.uniform(-20, 20)), 3)}")
        self.unshift()
        self.write(self.pick(_SYSTEMS))
        self.forget()

    def home(self):
        code = self.pick(["G28", "G30"])
        if self.chance(0.4):
            self.upright(always=True)
            self.write(f"{code}.1")
            return
        self.upright()
        words = " ".join(self.word(a, self.target(a)) for a in self.some_axes(upright=True)) if self.chance(0.6) else ""
        self.write(f"{code} {words}")
        self.forget()

    def machine_coordinates(self):
        """G53 counts from the machine's zero, which needs G90 to be written."""
        self.upright()
        self.write("G90")
        self.absolute = True
        letters = self.some_axes(upright=True)
        self.motion = self.pick(["G0", "G1"])
        self.write(f"G53 {self.motion} {' '.join(f'{a}{self.value(self.target(a))}' for a in letters)}")
        self.forget()  # where the axes are turned, one machine axis moves two of the program

    def tool(self):
        self.tool_used = True
        self.upright()
        number_ = self.pick(TOOLS)[0]
        lengths = " ".join(f"{a}{self.length(-30, 30)}" for a in self.pick(["Z", "XZ", "XYZ", "Y"]))
        self.write(self.pick([
            f"T{number_} M6", f"M6 T{number_}", f"T{number_}", f"M61 Q{number_}\nT{number_} M6", f"G43 H{number_}",
            f"G43.1 {lengths}", "G49", "M6", "G43", f"T{number_} M6\nG43", f"G43.2 H{number_}",
        ]))  # fmt: skip
        self.forget("XYZ")
