"""Standard programs: curves run once, and test pieces of machine tools.

A program starts where its path starts, not at the frame's zero: the machine is put there before the time begins.
"""

from .circle import Circle
from .circle_diamond_square import CircleDiamondSquare
from .circular_test import CircularTest
from .cone_frustum import ConeFrustum
from .ellipse import Ellipse
from .fourier import Fourier
from .line import Line
from .polyline import Polyline
from .s_piece import SPiece
from .spline import Spline
from .square_corners import SquareCorners
from .zigzag import Zigzag

__all__ = [
    "Circle",
    "CircleDiamondSquare",
    "CircularTest",
    "ConeFrustum",
    "Ellipse",
    "Fourier",
    "Line",
    "Polyline",
    "SPiece",
    "Spline",
    "SquareCorners",
    "Zigzag",
]
