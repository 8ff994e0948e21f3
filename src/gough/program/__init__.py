"""Programs: a geometric path with a feed profile, from an NC program or one of the standard shapes."""

from .base import Program
from .load import NCProgram, load_program, program_from_table
from .piece import CircleDiamondSquare
from .reference import Motion, Reference
from .standard import Circle, Ellipse, Line, Polyline

__all__ = [
    "Circle",
    "CircleDiamondSquare",
    "Ellipse",
    "Line",
    "Motion",
    "NCProgram",
    "Polyline",
    "Program",
    "Reference",
    "load_program",
    "program_from_table",
]
