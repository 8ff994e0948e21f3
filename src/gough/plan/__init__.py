"""Before anything moves: what a machine can do, where it can go, and what to do where it cannot."""

from .feeds import Fixed, fix_feed
from .placement import Placement, place
from .preflight import Finding, Preflight, preflight

__all__ = ["Finding", "Fixed", "Placement", "Preflight", "fix_feed", "place", "preflight"]
