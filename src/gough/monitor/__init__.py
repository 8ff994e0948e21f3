"""Monitoring: forces on the tool out of recorded logs, and what in them a person should look at."""

from __future__ import annotations

from .run import monitor as monitor
