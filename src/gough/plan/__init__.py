"""Before metal is cut: what a program asks of a machine, feeds that it can follow, and where to clamp the work."""

from .feeds import Fixed, fix_feed
from .placement import Placement, place
from .preflight import Finding, Preflight, preflight

__all__ = ["Finding", "Fixed", "Placement", "Preflight", "fix_feed", "place", "preflight"]
