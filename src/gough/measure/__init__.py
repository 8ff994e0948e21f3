"""What a run is judged by: distance from the path, circles, reversals, effort."""

from .circularity import bidirectional_error, circles, circularity
from .contour import Contour, ContourMeter
from .reversal import CONTRACT, STUDIES, reversals
from .summary import Accumulator, Measured, measure

__all__ = [
    "CONTRACT",
    "STUDIES",
    "Accumulator",
    "Contour",
    "ContourMeter",
    "Measured",
    "bidirectional_error",
    "circles",
    "circularity",
    "measure",
    "reversals",
]
