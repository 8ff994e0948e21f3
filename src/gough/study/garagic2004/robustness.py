"""A thousand machines that are not what the laws believe, on the paper's circle.

Every machine is the sheet's with, drawn uniformly and independently,

    mass        0.8 ... 1.2      of the platform with its inertia, of the struts' moving and of their fixed parts
    friction    0.5 ... 1.5      of each strut
    payload     0 ... 40 kg      a point mass at the tool tip
    drift       -1 ... 1 %/s     of all friction: a quarter more or less at the end of the turn

The laws believe the sheet and have one bandwidth (fair.py).  Numbers only: the machines run eight at a time in the
lanes of one kernel (simulate/batch.py), and with a seed the thousand machines are always the same.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ...simulate.plant import Plant
from ...simulate.run import simulate
from ..study import Experiment, Tick
from . import circle
from .fair import tuned
from .setup import LAWS, SLOW, Case, machine

COUNT, SEED = 1000, 0
MASS, FRICTION, PAYLOAD, DRIFT = (0.8, 1.2), (0.5, 1.5), (0.0, 40.0), (-0.01, 0.01)
LEVELS = ("coulomb", "static", "viscous", "viscous_offset")  # of the sheet's friction; its other offset is 0
PERCENT = (5, 50, 95, 100)
SHOWN = [
    digit * 10.0**power for power in range(-2, 7) for digit in (1, 1.5, 2, 3, 4, 5, 7)
]  # um, on the picture's axis


class Campaign(NamedTuple):
    """One law on all machines."""

    law: str
    case: str
    contour: np.ndarray  # largest contour error of each run, (count,) m
    rms: np.ndarray  # (count,) m
    orientation: np.ndarray  # largest, (count,) rad
    failed: np.ndarray  # (count,) bool
    simulated: float  # s, of all runs
    spent: float  # CPU s of its thread, set-up and all


def drawn(true, count: int = COUNT, seed: int = SEED) -> list[Plant]:
    """The machines: the first `count` of those of a seed."""
    plants = []
    for rng in np.random.default_rng(seed).spawn(count):
        platform, moving, fixed = rng.uniform(*MASS, 3)
        friction = rng.uniform(*FRICTION, true.joints_count)
        changes = {
            "platform.mass": platform * true.platform.mass,
            "platform.inertia": platform * true.platform.inertia,
            **{f"friction.{name}": friction * getattr(true.friction, name) for name in LEVELS},
        }
        for part, factor in (("moving", moving), ("fixed", fixed)):
            body = getattr(true.strut, part)
            changes[f"strut.{part}.mass"] = factor * body.mass
            changes[f"strut.{part}.transverse"] = factor * body.transverse
        payload = PAYLOAD[1] - rng.uniform(*PAYLOAD)  # uniform() may give its lower end, never its upper
        plants.append(Plant(machine=true.replace(**changes), payload=payload, friction_drift=rng.uniform(*DRIFT)))
    return plants


def campaign(name: str, case: Case = SLOW, count: int = COUNT, seed: int = SEED, tick: Tick | None = None) -> Campaign:
    """One turn of the circle under a law of setup.LAWS on every machine."""
    true, begun = machine(case.encoder), time.thread_time()
    log = simulate(
        true, tuned(name, case), circle.program(), plant=drawn(true, count, seed), seed=seed, period=case.period,
        keep="metrics", progress=tick,
    )  # fmt: skip
    return Campaign(
        name, case.name, log["metrics.contour_error.max"], log["metrics.contour_error.rms"],
        log["metrics.orientation_error.max"], log["failed"].astype(bool), log.info["simulated_time"],
        time.thread_time() - begun,
    )  # fmt: skip


def experiments(case: Case = SLOW, count: int = COUNT) -> list[Experiment]:
    """One experiment a law; each gives a Campaign."""
    return [
        Experiment(f"{count} machines: {name}", lambda tick, name=name: campaign(name, case, count, tick=tick))
        for name in LAWS
    ]


HEADS = ("law", "machines", "failed", *(f"{p} %" if p < 100 else "worst" for p in PERCENT), "orientation, worst")


def table(campaigns: Sequence[Campaign]) -> list[list[str]]:
    """Percentiles of the largest contour error of a turn, law by law, for people, under HEADS."""
    rows = []
    for one in campaigns:
        good = ~one.failed
        some = good.any()
        errors = [f"{1e6 * np.percentile(one.contour[good], p):.3g} um" if some else "-" for p in PERCENT]
        turned = f"{np.degrees(one.orientation[good].max()) * 60:.3f}'" if some else "-"
        rows.append([one.law, f"{len(good)}", f"{one.failed.sum()}", *errors, turned])
    return rows


def figure(campaigns: Sequence[Campaign], ax=None):
    """Histograms of the largest contour error of a turn, on one logarithmic axis; lines at the medians."""
    from ...report import style

    ax = ax or style.new_axes()
    errors = [1e6 * one.contour[~one.failed] for one in campaigns]
    every = np.concatenate(errors)
    low, high = (every.min(), every.max()) if every.size else (1.0, 10.0)  # every run failed: an empty picture
    bins = np.geomspace(low / 1.05, high * 1.05, 60)
    for i, (one, values) in enumerate(zip(campaigns, errors, strict=True)):
        colour = style.COLOURS[i % len(style.COLOURS)]
        ax.hist(values, bins, color=colour, alpha=0.55, label=one.law)
        if values.size:
            ax.axvline(np.median(values), color=colour, linewidth=1.0)
    ax.set_xscale("log")
    ax.set_xticks([], minor=True)
    shown = [value for value in SHOWN if low / 1.05 <= value <= high * 1.05]
    ax.set_xticks(shown, [f"{value:g}" for value in shown])
    count = len(campaigns[0].contour)
    title = f"{count} drawn machines, {campaigns[0].case.replace(' um', ' µm')}; lines: medians"
    style.label(ax, title, "largest contour error of a turn [µm]", "machines")
    style.legend(ax)
    return ax
