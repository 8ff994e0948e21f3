"""The NC programs that come with gough, from the kinds.  `python -m tests.program.make_pieces` writes them anew."""

from __future__ import annotations

from math import radians
from pathlib import Path
from typing import NamedTuple

import gough.program
from gough.program import (
    CircleDiamondSquare,
    CircularTest,
    ConeFrustum,
    Program,
    SPiece,
    SquareCorners,
    Zigzag,
)
from gough.program.load import KINDS
from gough.program.write import to_gcode

FOLDER = Path(gough.program.__file__).parent / "pieces"
DECIMALS = 6  # 1 nm; 1e-6 deg turn a tool of 100 mm by 2 nm
HEXAPODS, OKUMA = ("nist-octahedral", "okuma-pm600"), ("okuma-pm600",)
WIDE = ("eth-hexaglide", "ifma-hsm", *HEXAPODS)
ALL = ("ccu-3prs", *WIDE)
XY, YZ, ZX = (0.0, 0.0, 0.0), (radians(90), 0.0, radians(90)), (radians(-90), radians(-90), 0.0)


class Recipe(NamedTuple):
    """A shipped program: what makes it, what its header says, and the library machines it fits."""

    program: Program
    about: str
    machines: tuple[str, ...]


def _circles(radius, plane, name, feed, machines):
    program = CircularTest(radius=radius, feed=feed / 60, plane=plane)
    return Recipe(
        program,
        f"Circular test in the manner of ISO 230-4, in the {name} plane.\n"
        f"A circle of {2e3 * radius:g} mm diameter about zero, at {1e3 * feed:g} mm/min,\n"
        "counter-clockwise, then clockwise, each with half a circle of run-in and half a circle of run-out.",
        machines,
    )


RECIPES = {
    "circles-xy": _circles(0.1, XY, "XY", 3.0, WIDE),
    "circles-yz": _circles(0.08, YZ, "YZ", 3.0, ALL),
    "circles-zx": _circles(0.08, ZX, "ZX", 3.0, ALL),
    "circle-diamond-square": Recipe(
        CircleDiamondSquare(feed=2.4 / 60),
        "Circle, diamond, square: a contouring test piece after ISO 10791-7 and NAS 979.\n"
        "A square of 160 mm, in it a diamond, in that a circle of 100 mm, each 2 mm above the one around it;\n"
        "the circle clockwise, then counter-clockwise.  Zero lies in the middle of the top.",
        WIDE,
    ),
    "square-corners": Recipe(
        SquareCorners(side=(0.02, 0.06, 0.1), feed=2.0 / 60),
        "Squares of 20, 60 and 100 mm about zero with sharp corners, at 2000 mm/min,\n"
        "each counter-clockwise and clockwise, from the middle of a side.  The corners are driven exactly;\n"
        "write G64 P instead of G61 to see them blended.",
        ALL,
    ),
    "zigzag": Recipe(
        Zigzag(feed=2.0 / 60, back=True),
        "Corners of 30, 60, 90, 120 and 150 degrees between lines of 30 mm, at 2000 mm/min, there and back.\n"
        "Zero lies in the middle.",
        ALL,
    ),
    "cone-frustum": Recipe(
        ConeFrustum(feed=1.0 / 60),
        "Cone frustum after the five-axis test piece of NAS 979, its side milled with the flank of the tool.\n"
        "Lower circle 160 mm, half angle 15 degrees, axis tilted by 10 degrees:\n"
        "the tool leans over by 5 to 25 degrees.\n"
        "Zero lies 40 mm above the middle of the lower circle and 50 mm beside it.  Short lines within 0.005 mm.",
        OKUMA,
    ),
    "cone-frustum-18": Recipe(
        ConeFrustum(half_angle=radians(12), tilt=radians(6), feed=1.0 / 60),
        "Cone frustum after the five-axis test piece of NAS 979, its side milled with the flank of the tool,\n"
        "for machines that tilt by less than 25 degrees.\n"
        "Lower circle 160 mm, half angle 12 degrees, axis tilted by 6 degrees:\n"
        "the tool leans over by 6 to 18 degrees.\n"
        "Zero lies 40 mm above the middle of the lower circle and 50 mm beside it.  Short lines within 0.005 mm.",
        HEXAPODS,
    ),
    "s-piece": Recipe(
        SPiece(feed=1.0 / 60),
        "S-shaped wall, milled with the flank of the tool: a five-axis test piece with a surface of gough's own.\n"
        "200 x 120 mm, 30 mm high; the tool leans over by up to 18 degrees, to all sides.\n"
        "Zero lies 40 mm above the middle of the wall's foot.  Short lines within 0.005 mm.",
        HEXAPODS,
    ),
}  # fmt: skip


def listed(names: tuple[str, ...]) -> str:
    """ "a", "a and b", "a, b and c"."""
    return " and ".join(part for part in (", ".join(names[:-1]), names[-1]) if part)


def text(name: str) -> str:
    """The NC program of this name, as it should be."""
    program, about, machines = RECIPES[name]
    kind = next(kind for kind, cls in KINDS.items() if cls is type(program))
    header = [
        name,
        *about.splitlines(),
        f"With zero at the machine's home within the workspace of {listed(machines)}.",
        f"Made by gough from the kind {kind}, all numbers rounded to {DECIMALS} decimals.",
    ]
    return to_gcode(program.path(), "\n".join(header), decimals=DECIMALS, numbered=True)


if __name__ == "__main__":
    for name in RECIPES:
        (FOLDER / f"{name}.ngc").write_text(text(name))
