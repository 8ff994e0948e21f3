"""Milling: what the teeth of an end mill do to the tool, and what the tool leaves on the wall."""

from __future__ import annotations

from .coefficients import Coefficients
from .cutting import Cutting
from .deflection import Beam, Leaning
from .tool import EndMill
from .wall import Wall

__all__ = ["Beam", "Coefficients", "Cutting", "EndMill", "Leaning", "Wall"]
