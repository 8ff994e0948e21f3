"""The claims table of Garagic and Srinivasan, ACC 2004, in the order of the paper: circle, corner, stability."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..claims import Claim
from . import corner_rows
from .circle import Turn, angles_of_geometry, distances
from .experiments import Results
from .setup import CASES, FAST, SLOW, machine

UM, ARCMIN = 1e-6, np.pi / 180 / 60
RANGE = 0.2  # "in the range of": of the published number, either way
FREE = {"CDAC": 2 * UM, "FCDAC": 3 * UM}  # largest glitch of an error that is called free of glitches
SAME = "band: 20 %; by the measure that finds none under CDAC and FCDAC"
SIZES = "the sheet's friction and the guide's lengths were chosen for glitches of 10 and 3 um"


def claims(results: Sequence[Any]) -> list[Claim]:
    """Every row, from the results of experiments.EXPERIMENTS."""
    found = Results(results)
    return [
        *_reversals(found.turn("CCTPID", FAST)), *_sizes(found.turn("CCTPID", FAST)),
        *_seen(found.turn("CCTPID", SLOW)),
        *[row for law in FREE for case in CASES for row in _adaptive(found.turn(law, case))],
        *_learning(found), *corner_rows.claims(found.corners), *_stability(found),
    ]  # fmt: skip


def _reversals(turn: Turn) -> list[Claim]:
    struts = [glitch.strut for glitch in turn.glitches]
    away = distances([glitch.angle for glitch in turn.glitches], angles_of_geometry(machine()))
    # 1 um/s counts as rest, so a reversal is seen at the first or second sample behind it; the tool turns by v / R
    two_samples = 2 * turn.case.period * 0.05 / 0.2
    return [
        Claim("strut velocity reversals in a revolution", len(struts), "1", (12, 12), published=12),
        Claim("most reversals of one strut", max(map(struts.count, range(6))), "1", (2, 2), published=2),
        Claim(
            "a reversal's angle on the circle, off that of geometry, at most", float(away.max()), "rad",
            (0, two_samples), shown="deg",
            note="geometry: the strut's length is extreme where the circle's radius is along its projection; band: two "
            "samples of travel, because a strut slower than 1 um/s counts as at rest",
        ),
    ]  # fmt: skip


def _sizes(turn: Turn) -> list[Claim]:
    size = np.array([glitch.size for glitch in turn.glitches])
    length = np.array([glitch.length for glitch in turn.glitches])
    delay = np.array([glitch.delay for glitch in turn.glitches])
    middle = (10 * UM + 3 * UM) / 2
    large, long = size > middle, length > turn.mean_length
    mean_large, mean_small = (float(size[rows].mean()) if rows.any() else np.nan for rows in (large, ~large))
    case, why = f"CCTPID, {turn.case.name}", "peaks come later under a softer loop; band: 10 ms about 40 and 66 ms"
    return [
        Claim(f"{case}: glitches above 2 um", int((size > 2 * UM).sum()), "1", (12, 12), published=12),
        Claim(f"{case}: large ones, above the middle of 3 and 10 um", int(large.sum()), "1", (6, 6), published=6),
        Claim(f"{case}: large ones at long struts", int((large & long).sum()), "1", (6, 6)),
        Claim(f"{case}: small ones at short struts", int((~large & ~long).sum()), "1", (6, 6)),
        Claim(
            f"{case}: mean of the large glitches", mean_large, "m", _about(10 * UM), published=10 * UM, shown="um",
            calibrated=SIZES, note=SAME,
        ),
        Claim(
            f"{case}: mean of the small glitches", mean_small, "m", _about(3 * UM), published=3 * UM, shown="um",
            calibrated=SIZES, note=SAME,
        ),
        Claim(f"{case}: first peak behind its reversal", float(delay.min()), "s", (0.030, 0.050), shown="ms", note=why),
        Claim(f"{case}: last peak behind its reversal", float(delay.max()), "s", (0.056, 0.076), shown="ms", note=why),
    ]  # fmt: skip


def _seen(turn: Turn) -> list[Claim]:
    text = "by the measure that finds none under CDAC and FCDAC; band: above what is called free of glitches"
    name = f"CCTPID, {turn.case.name}: largest glitch"
    return [Claim(name, turn.worst, "m", (FREE["FCDAC"], None), shown="um", note=text)]


def _adaptive(turn: Turn) -> list[Claim]:
    case = f"{turn.law}, {turn.case.name}"
    measure = "largest error from 20 ms before to 100 ms after a reversal over that from 250 to 50 ms before"
    return [
        Claim(f"{case}: largest glitch", turn.worst, "m", (None, FREE[turn.law]), shown="um", note=measure),
        Claim(
            f"{case}: contour error with the start", float(turn.contour.max()), "m", (None, 20 * UM),
            published=20 * UM, shown="um", note="from parameters 20 % off; published: \"kept under\"",
        ),
        Claim(
            f"{case}: orientation error", float(turn.orientation.max()), "rad", (None, 0.08 * ARCMIN),
            published=0.08 * ARCMIN, shown="arcmin", note="from parameters 20 % off",
        ),
        Claim(
            f"{case}: estimates beyond their projection set", turn.outside, "1", (None, 0),
            note="in halves of the set's width: 0 is on the edge, below 0 inside",
        ),
    ]  # fmt: skip


def _learning(found: Results) -> list[Claim]:
    quiet, noisy = found.of["circle, CDAC, noise"], found.of["circle, CDAC, noise learned"]
    out = [
        Claim(
            "CDAC, 4 kHz and 1 um, true parameters: drift of an inertial estimate", quiet.drift, "1", (None, 0.2),
            shown="%", note="learned at the reference motion; band: less than the 20 % that there is to learn",
        ),
        Claim(
            "the same, learned at the measured motion", noisy.drift, "1", (0.45, None), shown="%",
            note="the encoder's noise drives it to its bound of 50 %: why the reference motion is the default",
        ),
    ]  # fmt: skip
    for law in FREE:
        kept, turned = found.turn(law, SLOW), found.of[f"circle, {law}, measured sign"]
        out.append(
            Claim(
                f"{law}, {SLOW.name}: contour error with friction's sign from the measured speed",
                float(turned.contour.max()), "m", (float(kept.contour.max()), None), shown="um",
                note="what the option costs; band: at least the error with the sign of the reference",
            )
        )  # fmt: skip
    return out


def _stability(found: Results) -> list[Claim]:
    limit, course = found.of["limit case"], found.of["Lyapunov function"]
    rows = [
        Claim(
            f"{law} without learning and sliding, off computed torque", limit[law], "N", (None, 1e-6),
            note="200 random references at home at rest; forces of up to 1e5 N are rounded to 1e-11 of themselves",
        )
        for law in FREE
    ]  # fmt: skip
    return [
        *rows,
        Claim(
            "Lyapunov function: largest rise in a step of 20 us, of its start", course.rise, "1", (None, 0),
            note=f"continuous limit, no Stribeck, true sign, no jump; after {course.t[-1]:.2g} s it is "
            f"{course.V[-1] / course.V[0]:.2f} of its start",
        ),
    ]  # fmt: skip


def _about(value: float) -> tuple[float, float]:
    return (1 - RANGE) * value, (1 + RANGE) * value
