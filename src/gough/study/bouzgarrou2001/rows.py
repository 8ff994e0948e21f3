"""The claims table of Bouzgarrou et al., 2001, in the order of its halves."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ..claims import Claim
from .beyond_rows import beyond_claims
from .experiments import Results
from .flexible_rows import flexible_claims
from .rigid_rows import rigid_claims


def claims(results: Sequence[Any]) -> list[Claim]:
    """Every row, from the results of experiments.EXPERIMENTS."""
    found = Results(results)
    return [*rigid_claims(found), *flexible_claims(found), *beyond_claims(found)]
