"""Learning in less than 30 s: an optimal motion, learned from on line while it runs and off line from its log.

The motion is that of `gough.identify.excite`, the law the one that learns for ten minutes elsewhere in this study, from
the same half of the truth.  Off line, `gough.identify` sees nothing but what was measured, and gives each number with
its deviation.  The model of both has Coulomb and viscous friction; the machine's friction has a memory besides.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ...control import linear_model
from ...identify import excite, identify, shown
from ...report import style
from ...simulate.run import simulate
from ..study import Beyond, Experiment, Tick
from .exercise import Exercise
from .learning import FIRST, RATE, WITHIN
from .setup import LEARNED, PERIOD, TURNED, computed_torque, machine

CYCLE, CYCLES = 2.5, 11  # s of the motion's period, and how often: 27.75 s with the rests
TOOL = 1.0  # m/s, the published greatest speed of the tool
ACCELERATION = 9.0  # m/s2 of the carriages in the design: that of the tool is to stay below the published 1 g
QUICK = 2.0  # 1/s, learning factors; twenty times those that take minutes
LAST = 2 * CYCLE  # s at the end, of the mean of the estimates


class Short(NamedTuple):
    """What one short motion gives."""

    duration: float  # s
    fastest: tuple[float, float]  # of the tool, m/s and m/s2
    condition: tuple[float, float]  # of the motion, and of the paper's kind of motion with turns of 8 deg
    names: tuple[str, ...]
    units: tuple[str, ...]
    true: np.ndarray  # (k,)
    rates: tuple[float, ...]  # 1/s, learning factors of `on_line`
    t: np.ndarray  # (n,) s
    on_line: tuple[np.ndarray, ...]  # (n, k) each
    off_line: np.ndarray  # (k,)
    std: np.ndarray  # (k,), of off_line
    residual: float  # N rms, of off_line

    def learned(self, i: int) -> np.ndarray:
        """Mean of the estimates under the learning factor i over the last LAST s.  (k,)."""
        return self.on_line[i][self.t > self.t[-1] - LAST].mean(0)

    def off(self, values) -> np.ndarray:
        """How far values (k,) are from the truth, as shares of it; NaN for parameters that are 0."""
        return np.abs(values / np.where(self.true == 0, np.nan, self.true) - 1)


def short(tick: Tick | None = None, harmonics: int = 5) -> Short:
    """Design the motion, learn on line on it with RATE and QUICK, and identify from the log of the first.

    Raises
    ------
    RunError
        the design did not converge, or a run ended early.
    """
    true = machine()
    slowed = true.replace(**{"limits.acceleration": ACCELERATION})
    program = excite(slowed, period=CYCLE, cycles=CYCLES, harmonics=harmonics, tool_speed=TOOL)
    motion = program.plan(true)
    rows = motion.sample(0, motion.count(1e-3), 1e-3)
    columns = linear_model.indices(true, list(LEARNED))
    E = linear_model.excitation(true, rows.x, rows.xd, rows.xdd)[columns]
    logs = []
    for i, rate in enumerate((RATE, QUICK)):
        law = computed_torque(learn=list(LEARNED), learning=rate, excitation=E, estimates=FIRST, physical=True)
        logs.append(simulate(true, law, program, period=PERIOD, on_fail="raise",
                             signals=["q_m", "u", "controller.parameters"]))  # fmt: skip
        if tick is not None:
            tick(i + 1, 2)
    fit = identify(logs[0], true)
    names, values, units = true.parameters_of(friction=True)
    found = np.array([fit[names[j]] for j in columns])
    learn_from = Exercise(turn=np.radians(8), settle=0.0)
    fastest = tuple(float(np.linalg.norm(rate[:, :3], axis=1).max()) for rate in (rows.xd, rows.xdd))
    return Short(
        motion.duration, fastest, (shown(true, program).condition, shown(true, learn_from).condition),
        tuple(names[j] for j in columns), tuple(units[j] for j in columns), np.asarray(values)[columns],
        (RATE, QUICK), logs[0].t, tuple(log["controller.parameters"][:, columns] for log in logs),
        found[:, 0], found[:, 1], fit.estimate.residual_rms,
    )  # fmt: skip


def _table(results: Sequence[Short]) -> list[list[str]]:
    found = results[0]
    ends = [found.learned(i) for i in range(len(found.rates))]
    out = []
    for j, (name, unit) in enumerate(zip(found.names, found.units, strict=True)):
        row = [f"{name} [{unit}]", f"{found.true[j]:.5g}"]
        for values in (*ends, found.off_line):
            away = "" if found.true[j] == 0 else f" ({100 * (values[j] / found.true[j] - 1):+.2f} %)"
            row.append(f"{values[j]:.5g}{away}")
        out.append([*row, f"{found.std[j]:.2g}"])
    return out


def _text(results: Sequence[Short]) -> str:
    found = results[0]
    slow, quick = (np.nanmax(found.off(found.learned(i))) for i in range(2))
    turns = [found.names.index(name) for name in TURNED]
    late = np.nanmax(found.off(found.learned(1))[turns])
    best = found.off(found.off_line)
    away = np.abs(found.off_line - found.true) / found.std
    outside, far = int((away > 2).sum()), int(away.argmax())
    within = "all" if np.nanmax(best) <= WITHIN else "not all"
    return (
        f"{found.duration:.1f} s of machine time at up to {found.fastest[0]:.2f} m/s; condition number "
        f"{found.condition[0]:.0f}, that of the lines with turns of 8 deg {found.condition[1]:.0f}.  Off line {within} "
        f"parameters are within 5 %, the farthest {100 * np.nanmax(best):.2f} % off.  On line, from half of the truth, "
        f"the farthest is {100 * slow:.0f} % off at the end with learning factors of {RATE:g} 1/s, as in the ten "
        f"minutes, and {100 * quick:.1f} % with {QUICK:g} 1/s (inertias: {100 * late:.1f} %).  Residual "
        f"{found.residual:.2g} N rms.  {outside} of {len(found.names)} numbers are farther than two deviations from "
        f"the truth, the farthest, {found.names[far]}, {away[far]:.1f}."
    )


def _picture(results: Sequence[Short]) -> Any:
    found = results[0]
    ax = style.new_axes((7.2, 4.0))
    for j in np.flatnonzero(found.true):
        colour = style.COLOURS[1 if found.names[j] in TURNED else 0]
        label = {found.names.index("carriage.m"): "masses, friction", found.names.index(TURNED[0]): "inertias"}.get(j)
        ax.plot(found.t[::100], found.on_line[1][::100, j] / found.true[j], linewidth=0.8, color=colour, label=label)
    k = np.flatnonzero(found.true)
    ax.plot(np.full(len(k), found.t[-1]), found.off_line[k] / found.true[k], "k+", label="off line")
    style.label(ax, f"An optimal motion, learning factors of {QUICK:g} 1/s", "time [s]",
                "estimate over truth")  # fmt: skip
    style.legend(ax, loc="lower right")
    return ax


SHORT = Beyond(
    name="short_excitation",
    title="Learned in less than 30 s from an optimal motion: on line at two rates, and off line from the same log",
    experiments=[Experiment("an optimal motion of 28 s", short)],
    heads=("parameter", "planted", f"on line, {RATE:g} 1/s", f"on line, {QUICK:g} 1/s", "off line", "deviation"),
    table=_table,
    picture=_picture,
    text=_text,
)
