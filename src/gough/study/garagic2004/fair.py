"""The comparison that the paper does not make: three laws at one bandwidth, on the same motors, encoders and samples.

Every law's gains are all times one factor until the linearised loop along X at home, on a rigid machine that the law
knows, with adaptation frozen, has BANDWIDTH at -3 dB (simulate/bandwidth.py); about what the paper's CCTPID has.  All
are told the same of the machine: the truth, or its numbers times 0.8.  "CDAC, frozen" is CDAC that learns nothing: so
what feedback and friction in the model do, and what learning does, are told apart.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import NamedTuple

import numpy as np

from ...measure.reversal import STUDIES, reversals
from ...simulate.bandwidth import bandwidth_of, with_bandwidth
from ...simulate.run import simulate
from ..claims import told as shown
from ..study import Experiment, Tick, parts
from . import circle, corner
from .setup import CASES, LAWS, WRONG, Case, believed, law, machine

BANDWIDTH = 33.0  # Hz; CCTPID with poles 100, 100, 200 1/s: 33.4 Hz at 1 kHz, 32.6 Hz at 4 kHz
FROZEN = "CDAC, frozen"
COMPARED = (*LAWS, FROZEN)
LIMITS = (40.0, None)  # N m
TOLD = (1.0, WRONG)  # believed over true
STILL = {"inertia_rate": 0.0, "coulomb_rate": 0.0, "viscous_rate": 0.0}


class Row(NamedTuple):
    """One law in one setting, on both paths."""

    law: str
    case: str
    torque_limit: float | None  # N m
    told: float  # believed over true
    bandwidth: float  # Hz, of the loop with what the law was told
    circle: float  # largest contour error, m
    circle_rms: float  # m
    glitch: float  # largest of a reversal, m
    orientation: float  # on the circle, rad
    corner: float  # largest contour error, m
    torque: float  # largest of a motor at the corner, N m
    failed: str = ""  # why a run ended early; its numbers are those until then


def tuned(name: str, case: Case):
    """A law of COMPARED with BANDWIDTH in the sample time of one of CASES; still open for what it believes."""
    return _tuned(name, CASES.index(case))


@cache
def _tuned(name: str, index: int):
    case = CASES[index]
    free = law("CDAC", case.gains, **STILL) if name == FROZEN else law(name, case.gains)
    return with_bandwidth(machine(case.encoder), free, BANDWIDTH, case.period)


def compared(name: str, case: Case, limit: float | None, told: float, tick: Tick | None = None) -> Row:
    """One row: the circle and the corner under a law of COMPARED with motors of `limit` N m."""
    true, control = machine(case.encoder, limit), tuned(name, case)
    known = true if told == 1 else believed(true, told)
    programs = circle.program(), corner.program(case.period)
    motions = [program.plan(known) for program in programs]
    signals, failed = ["contour_error", "counted", "u"], ""
    logs = []
    for program, each in zip(programs, parts(tick, [m.duration for m in motions]), strict=True):
        log = simulate(known, control, program, plant=true, period=case.period, signals=signals, progress=each)
        logs.append(log)
        failed = failed or log.reason
    turn, turned = logs
    row = motions[0].sample(0, len(turn.t), case.period)
    counted = turn["counted"].astype(bool)
    found = reversals(case.period, row.qd, turn["contour_error"], counted, STUDIES)
    on_circle = turn.metrics["contour_error"]
    return Row(
        name, case.name, limit, told, bandwidth_of(true, control.on(known, case.period), case.period),
        on_circle["max"], on_circle["rms"], max((r.glitch for r in found), default=np.nan),
        turn.metrics["orientation_error"]["max"], turned.metrics["contour_error"]["max"],
        float(np.abs(turned["u"]).max() * true.drive.lead / (2 * np.pi)), failed,
    )  # fmt: skip


def experiments(laws: Sequence[str] = COMPARED) -> list[Experiment]:
    """One experiment a law and a case; each gives a list of rows."""

    def work(name, case):
        settings = [(limit, told) for limit in LIMITS for told in TOLD]

        def all_of(tick):
            ticks = parts(tick, [1.0] * len(settings))
            return [compared(name, case, *setting, each) for setting, each in zip(settings, ticks, strict=True)]

        return Experiment(f"one bandwidth: {name}, {case.name}", all_of)

    return [work(name, case) for case in CASES for name in laws]


HEADS = ("law", "sampling, encoder", "motors", "told", "bandwidth", "circle", "rms", "glitch", "orientation", "corner",
         "torque")  # fmt: skip


def table(rows: Sequence[Row]) -> list[list[str]]:
    """The rows for people, under HEADS: um, arc minutes, Hz, N m."""
    return [
        [
            row.law, row.case, "no limit" if row.torque_limit is None else f"{row.torque_limit:g} N m",
            "the truth" if row.told == 1 else f"{row.told:g} x", f"{row.bandwidth:.1f} Hz",
            *(shown(value, "m", "um") for value in (row.circle, row.circle_rms, row.glitch)),
            f"{np.degrees(row.orientation) * 60:.3f}'", shown(row.corner, "m", "um"), f"{row.torque:.0f} N m",
        ]
        for row in rows
    ]  # fmt: skip


def conclusion(rows: Sequence[Row]) -> str:
    """What learning buys at one bandwidth, in sentences with this table's numbers."""

    def of(name, told, what, fold):
        found = [getattr(row, what) for row in rows if row.law == name and row.told == told]
        return 1e6 * fold(found)

    def free(name):
        return 1e6 * max(row.corner for row in rows if row.law == name and row.torque_limit is None)

    low, high = (f"{of(FROZEN, WRONG, 'circle', fold):.2g}" for fold in (min, max))
    return (
        f"On the circle CCTPID errs by up to {of('CCTPID', 1.0, 'circle', max):.2g} um.  The friction in CDAC's model "
        f"alone, learning nothing, leaves {of(FROZEN, 1.0, 'circle', max):.2g} um where it is true and {low} to {high} "
        f"um where it is told {WRONG:g} of the truth; learning brings these to {of('CDAC', WRONG, 'circle', max):.2g} "
        f"um at most.  FCDAC, which knows no friction at first, errs by up to {of('FCDAC', WRONG, 'circle', max):.2g} "
        f"um, at its start and stop.  At the corner learning buys nothing: CDAC {free('CDAC'):.3g} um, frozen "
        f"{free(FROZEN):.3g} um without a torque limit; with one all laws are alike."
    )


def figure(rows: Sequence[Row], ax=None):
    """Largest contour errors, law by law: round on the circle, square at the corner; open where told wrong."""
    from ...report import style

    ax = ax or style.new_axes((8.0, 4.2))
    settings = list(dict.fromkeys((row.case, row.torque_limit) for row in rows))
    laws = list(dict.fromkeys(row.law for row in rows))
    for row in rows:
        i = laws.index(row.law)
        x = settings.index((row.case, row.torque_limit)) + 0.15 * (i - (len(laws) - 1) / 2)
        x += 0.05 if row.told != 1 else 0.0
        colour = style.COLOURS[i % len(style.COLOURS)]
        for value, marker in ((row.circle, "o"), (row.corner, "s")):
            ax.plot(x, 1e6 * value, marker, color=colour, markerfacecolor=colour if row.told == 1 else "none")
    for i, name in enumerate(laws):
        ax.plot([], [], "o", color=style.COLOURS[i % len(style.COLOURS)], label=name)
    for text, marker in (("circle", "o"), ("corner", "s")):
        ax.plot([], [], marker, color=style.INK, markerfacecolor="none", label=text)
    ax.set_yscale("log")
    ax.yaxis.set_major_formatter("{x:g}")
    names = [
        f"{case.replace(' um', ' µm')}\n{'no limit' if limit is None else f'{limit:g} N m'}" for case, limit in settings
    ]
    ax.set_xticks(range(len(settings)), names)
    title = f"One bandwidth, {BANDWIDTH:g} Hz: largest contour error; open: told {WRONG:g} of the truth"
    style.label(ax, title, "", "contour error [µm]")
    style.legend(ax, loc="center left", bbox_to_anchor=(1.0, 0.5))
    return ax
