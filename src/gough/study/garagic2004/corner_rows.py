"""The corner's rows: calibrated under CCTPID, different by design under the adaptive laws, and what it would take."""

from __future__ import annotations

import numpy as np

from ..claims import Claim, Evidence
from . import bounds
from .experiments import FINE, RAMP, TORQUES, Corners
from .setup import FAST, SLOW, machine

UM = 1e-6
PUBLISHED = 15 * UM
BAND = (0.8 * PUBLISHED, 1.2 * PUBLISHED)  # "to 15 um": as for the glitches, 20 % either way
NEAR = 0.1  # of a bound that a simulation is held against: friction and the law's own part in it
POLES = "the poles 100, 100, 200 1/s were chosen for 350 um"
REASON = "torque, sample time and preview set the corner's error, which the paper does not state; adaptation does not"


def claims(corners: Corners) -> list[Claim]:
    """The rows of the corner."""
    return [
        *_calibrated(corners), *_published(corners), *_without(corners), *_with(corners), *_rates(corners),
    ]  # fmt: skip


def _calibrated(corners: Corners) -> list[Claim]:
    fast = [passed.error for passed in corners.waits["CCTPID", FAST.name]]
    slow = [passed.error for passed in corners.waits["CCTPID", SLOW.name]]
    phase = "by when the next sample comes behind the corner"
    return [
        Claim(
            f"corner, CCTPID, {FAST.name}: contour error, middle of the phases", (min(fast) + max(fast)) / 2, "m",
            (0.95 * 350 * UM, 1.05 * 350 * UM), published=350 * UM, shown="um", calibrated=POLES,
            note=f"{min(fast) / UM:.0f} to {max(fast) / UM:.0f} um {phase}, 5 % either way as the band",
        ),
        Claim(
            f"corner, CCTPID, {SLOW.name}: smallest of the phases", min(slow), "m", (None, 350 * UM), shown="um",
            note=f"at 1 kHz the published number is one of a range, {phase}",
        ),
        Claim(
            f"corner, CCTPID, {SLOW.name}: largest of the phases", max(slow), "m", (350 * UM, None), shown="um",
            note=f"at 1 kHz the published number is one of a range, {phase}",
        ),
    ]  # fmt: skip


def _published(corners: Corners) -> list[Claim]:
    out = []
    for law in ("CDAC", "FCDAC"):
        found = corners.waits[law, FAST.name]
        out.append(
            Claim(
                f"corner, {law}, {FAST.name}: contour error", min(p.error for p in found), "m", BAND,
                published=PUBLISHED, shown="um", reason=REASON, evidence=_evidence(corners, law),
                note=f"motors without a limit, which takes {min(p.torque for p in found):.0f} N m; the smallest of the "
                f"phases, up to {max(p.error for p in found) / UM:.0f} um",
            )
        )  # fmt: skip
    return out


def _evidence(corners: Corners, law: str) -> list[Evidence]:
    """What shows that 15 um are a matter of torque, preview and sample time."""
    top, true, quick = TORQUES[-1], machine(), corners.quick[law]
    without = bounds.torque_for(true, bounds.greatest, bounds.unseen(1.0) / PUBLISHED)
    previewed = bounds.torque_for(true, bounds.straight, bounds.previewed(1.0) / PUBLISHED)
    return [
        Evidence("motor torque below which no law without preview or lag gets there", without, "N m", (1000.0, None)),
        Evidence("the same for the shortest previewed turn of the velocity", previewed, "N m", (1000.0, None)),
        Evidence(f"{law} at 10 kHz and K_D / M = 5000 1/s", quick.error, "m", BAND, "um"),
        Evidence("which takes", quick.torque, "N m", (1000.0, None)),
        Evidence("CDAC with the velocity turned within 0.6 ms, previewed", corners.free.error, "m", BAND, "um"),
        Evidence(f"previewed at {top / 2:.0f} N m", corners.previewed[top / 2][0].error, "m", (BAND[1], None), "um"),
    ]


def _without(corners: Corners) -> list[Claim]:
    out = []
    for torque, passed in corners.sharp.items():
        least = bounds.unseen(bounds.greatest(machine(), torque))
        out.append(
            Claim(
                f"corner, CDAC, {FAST.name}, no preview, at most {torque:.0f} N m", passed.error, "m", (least, None),
                shown="um", note="band: without preview or lag no law is below v^2 / 2 a with the a of these motors",
            )
        )  # fmt: skip
    return out


def _with(corners: Corners) -> list[Claim]:
    out = []
    for torque, (passed, bound) in corners.previewed.items():
        out.append(
            Claim(
                f"corner, CDAC, 10 kHz, previewed, at most {torque:.0f} N m", passed.error, "m",
                ((1 - NEAR) * bound, (1 + NEAR) * bound), shown="um",
                note="CDAC told the truth, learning off; band: 10 % about 0.0884 dv^2 / a, the shortest turn of the "
                "velocity that these motors allow in whole samples",
            )
        )  # fmt: skip
    coefficient = bounds.previewed(1.0) / bounds.jump() ** 2
    ramp, free = bounds.jump() / (RAMP * FINE), corners.free
    return [
        *out,
        Claim(
            "corner: the bound's factor, e a / dv^2", coefficient, "1", (0.0884 * 0.999, 0.0884 * 1.001),
            note="corner.md of the theory pages, (2), for the angle of this corner",
        ),
        Claim(
            "corner: contour error of a turn of the velocity within 0.6 ms", bounds.previewed(ramp), "m",
            (0.97 * PUBLISHED, 1.03 * PUBLISHED), shown="um", note=f"{ramp:.0f} m/s2, {ramp / 9.81:.0f} g",
        ),
        Claim(
            "corner, CDAC, 10 kHz, previewed within 0.6 ms, motors without a limit", free.error, "m", BAND,
            published=PUBLISHED, shown="um",
            note="told the truth, learning off: 15 um come out with preview and torque",
        ),
        Claim(
            "corner: motor torque that takes", free.torque, "N m", (1080.0, 1320.0), note="band: 10 % about 1.2 kN m",
        ),
    ]  # fmt: skip


def _rates(corners: Corners) -> list[Claim]:
    out = []
    for law in ("CDAC", "FCDAC"):
        quick = corners.quick[law]
        out += [
            Claim(
                f"corner, {law}, 10 kHz, K_D / M = 5000 1/s: contour error", quick.error, "m", BAND,
                published=PUBLISHED, shown="um", note="no preview, motors without a limit, the corner on a sample",
            ),
            Claim(
                f"corner, {law}, 10 kHz: motor torque it takes", quick.torque, "N m", (0.9 * 4400, 1.1 * 4400),
                note="band: 10 % about 4.4 kN m",
            ),
        ]  # fmt: skip
        for case in (SLOW, FAST):
            errors = [passed.error for passed in corners.waits[law, case.name]]
            out.append(
                Claim(
                    f"corner, {law}, {case.name}, motors without a limit: contour error over the phases, mean",
                    float(np.mean(errors)), "m", (quick.error, None), shown="um",
                    note="band: a slower sample time is not better than 10 kHz",
                )
            )  # fmt: skip
    return out
