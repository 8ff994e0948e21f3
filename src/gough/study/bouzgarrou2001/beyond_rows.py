"""Rows beyond the paper: vibration and tool-point error at equal cycle time."""

from __future__ import annotations

from ..claims import Claim
from . import beyond
from .experiments import Results

UM = 1e-6
FEEDS = {
    "jerk limited": "a bounded jerk, one period a ramp", "zv": "shaper zv", "zvd": "shaper zvd", "ei": "shaper ei",
}  # fmt: skip
PLAIN, GRAVITY, MODEL = beyond.LAWS


def beyond_claims(found: Results) -> list[Claim]:
    """Swing behind a line by feed, then what the tip errs by on its way, by law."""
    out, table = [], found.vibration
    cycle = f"{beyond.CYCLE:g} s for the line, at most {beyond.SPEED:g} m/s"
    for key in ("low", "high"):
        steps = table[key, "steps", PLAIN]
        for feed, label in FEEDS.items():
            one = table[key, feed, PLAIN]
            out.append(Claim(
                f"{key} gains, {label}: swing of the tip behind the line, over that of steps of the acceleration",
                one.behind / steps.behind, "1", (None, 0.2),
                note=f"{one.behind / UM:.0f} um against {steps.behind / UM:.0f}, within 20 um after "
                f"{1e3 * one.settled:.0f} ms against {1e3 * steps.settled:.0f}; {cycle}",
            ))  # fmt: skip
        for feed in ("steps", "jerk limited"):
            gravity, model = (table[key, feed, name] for name in (GRAVITY, MODEL))
            out.append(Claim(
                f"{key} gains, {FEEDS.get(feed, 'steps of the acceleration')}: largest error of the tip on the line, "
                "gravity compensation over flexible feedforward", gravity.largest / model.largest, "1", (5, None),
                note=f"{gravity.largest / UM:.0f} um against {model.largest / UM:.0f}; without either "
                f"{table[key, feed, PLAIN].largest / UM:.0f}; behind it {gravity.behind / UM:.0f} and "
                f"{model.behind / UM:.0f}",
            ))  # fmt: skip
    return out
