"""What the paper does not ask: all laws at one bandwidth, and a thousand machines unlike the one believed."""

from __future__ import annotations

from itertools import chain

from ..study import Beyond
from . import fair, robustness


def _rows(results) -> list[fair.Row]:
    return list(chain.from_iterable(results))


FAIR = Beyond(
    name="one_bandwidth",
    title=f"All laws at one bandwidth, {fair.BANDWIDTH:g} Hz",
    experiments=fair.experiments(),
    heads=fair.HEADS,
    table=lambda results: fair.table(_rows(results)),
    picture=lambda results: fair.figure(_rows(results)),
    text=lambda results: fair.conclusion(_rows(results)),
)

CAMPAIGN = Beyond(
    name="drawn_machines",
    title=f"{robustness.COUNT} drawn machines",
    experiments=robustness.experiments(),
    heads=robustness.HEADS,
    table=robustness.table,
    picture=robustness.figure,
    text=lambda results: f"Largest contour error of one turn, {results[0].case}; percentiles over the machines.",
    campaign=True,
)

BEYOND = (FAIR, CAMPAIGN)
