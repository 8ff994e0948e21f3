"""Programs: a geometric path with a feed profile, from an NC program or one of the standard shapes."""

from .base import Program
from .load import load_program, program_from_table
from .nc import NCProgram
from .reference import Motion, Reference
from .standard import (
    Circle,
    CircleDiamondSquare,
    CircularTest,
    ConeFrustum,
    Ellipse,
    Fourier,
    Line,
    Polyline,
    SPiece,
    Spline,
    SquareCorners,
    Zigzag,
)

__all__ = [
    "Circle",
    "CircleDiamondSquare",
    "CircularTest",
    "ConeFrustum",
    "Ellipse",
    "Fourier",
    "Line",
    "Motion",
    "NCProgram",
    "Polyline",
    "Program",
    "Reference",
    "SPiece",
    "Spline",
    "SquareCorners",
    "Zigzag",
    "load_program",
    "program_from_table",
]
