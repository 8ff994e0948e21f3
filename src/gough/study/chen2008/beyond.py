"""What the paper does not ask: friction and encoder, computed torque of the same poles, and the choice of equation."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from ...control.computed_torque import ComputedTorque
from ...mechanics.friction import LuGre
from ...report import style
from ..study import Beyond, Experiment, Tick, parts
from .setup import CIRCLE, ELLIPSE, LAYER, TIME, law, machine, run, scaled

UM = 1e-6
# preloaded guides and nut, 0.2 N m of a motor of 20; bristle damping ratio 0.7 with 90 kg
FRICTION = LuGre(coulomb=60.0, viscous=100.0, stiffness=1e8, damping=2 * 0.7 * np.sqrt(1e8 * 90))
METRE = {"strength": 260.0, "boundary": 1.0, "tangential": "distance"}  # those of the circle, in metres
# in its boundary layer s' = -K / delta s: poles at 260, 20 and 20 1/s, and so has this
SAME, STIFF = "computed torque, 20 20 260 1/s", "computed torque, 16 Hz"
OURS, OLDER = "equivalent errors", "equivalent errors, speeds of two samples"
QUICK = "equivalent errors, 16 Hz"
_W = 2 * np.pi * 16.0  # computed torque of 16 Hz has poles at (1, 1, 2) times this
OTHERS = {
    QUICK: law(CIRCLE, damping=2 * _W, stiffness=_W**2, strength=2 * _W * LAYER),
    OLDER: law(CIRCLE, speed="two_samples"),
    SAME: ComputedTorque(poles=[20.0, 20.0, 260.0]),
    STIFF: ComputedTorque(bandwidth=16.0),
}
ENCODERS = {"exact": None, "0.1 um": 1e-7, "1 um": 1e-6}


class Row(NamedTuple):
    """One run."""

    law: str
    plant: str
    path: str
    average: float  # m
    steady: float  # m


def _survives(tick: Tick | None) -> list[Row]:
    """How much of 0.1 um is left by encoder and friction, and what computed torque of the same poles does."""
    jobs = [(encoder, rubs, name) for rubs in (False, True) for encoder in ENCODERS for name in (OURS, *OTHERS)]
    out = []
    for (encoder, rubs, name), one in zip(jobs, parts(tick, [TIME] * len(jobs)), strict=True):
        m = machine()
        true = m.replace(drive=m.drive.replace(encoder=ENCODERS[encoder]), friction=FRICTION if rubs else None)
        found = run(CIRCLE, true, law(CIRCLE) if name == OURS else OTHERS[name], one)
        plant = f"encoder {encoder}" + (", friction" if rubs else "")
        out.append(Row(name, plant, "circle", found.average, found.steady))
    return out


def _wrong(tick: Tick | None) -> list[Row]:
    """The same with wrong masses."""
    jobs, out = [(s, name) for s in (1.25, 1.5) for name in (OURS, *OTHERS)], []
    for (s, name), one in zip(jobs, parts(tick, [TIME] * len(jobs)), strict=True):
        found = run(CIRCLE, scaled(machine(), s), law(CIRCLE) if name == OURS else OTHERS[name], one)
        out.append(Row(name, f"{100 * (s - 1):g} % uncertain", "circle", found.average, found.steady))
    return out


FORMS: dict[str, tuple[str, dict]] = {
    "dimensionless, K = 26": ("dimensionless", {}),
    "m2, K = 26 m2/s2": ("area", {}),
    "metres, K = 260 m/s2": ("distance", METRE),
    "the path's own frame, K = 260 m/s2": ("local", METRE),
}


def _forms(tick: Tick | None) -> list[Row]:
    """Every form on both paths with 50 % on everything."""
    jobs = [(name, path) for name in FORMS for path in ("circle", "ellipse")]
    out = []
    for (name, path), one in zip(jobs, parts(tick, [TIME] * len(jobs)), strict=True):
        form, options = FORMS[name]
        semi = CIRCLE if path == "circle" else ELLIPSE
        control = law(semi, "distance" if form == "local" else form, **options)
        control = control.replace(path=None) if form == "local" else control
        found = run(semi, scaled(machine(), 1.5), control, one)
        out.append(Row(name, "50 % uncertain", path, found.average, found.steady))
    return out


def effective(form: str, semi) -> tuple[float, float]:
    """K over the gradient of the equation on the path, least and greatest: what a law has to hold with, m/s2."""
    phi = np.linspace(0, np.pi / 2, 200)
    a, b = semi
    slope = 2 * np.hypot(np.cos(phi) / a, np.sin(phi) / b)  # of the dimensionless one
    gradient = slope * (a * b if form == "area" else 1.0)
    K = law(semi).strength / gradient
    return float(K.min()), float(K.max())


HEADS = ("law", "plant", "path", "average", "steady")


def _table(rows: Sequence[Row]) -> list[list[str]]:
    return [[r.law, r.plant, r.path, f"{r.average / UM:.3g} um", f"{r.steady / UM:.3g} um"] for r in rows]


def _bars(rows: Sequence[Row], label: Callable[[Row], str], title: str):
    ax = style.new_axes((7.4, 0.32 * len(rows) + 1.4))
    colours = {name: style.COLOURS[i] for i, name in enumerate(dict.fromkeys(row.law for row in rows))}
    ax.barh([label(row) for row in rows], [row.steady / UM for row in rows], color=[colours[row.law] for row in rows])
    ax.set_xscale("log")
    ax.invert_yaxis()
    style.label(ax, title, "steady contour error [µm]", "")
    return ax


def _dots(rows: Sequence[Row], title: str):
    """A line for each plant, a dot in it for each law."""
    plants = list(dict.fromkeys(row.plant for row in rows))
    ax = style.new_axes((7.4, 0.4 * len(plants) + 2.0))
    for name, marker in zip(dict.fromkeys(row.law for row in rows), "o^sDv", strict=True):
        own = [row for row in rows if row.law == name]
        ax.plot([row.steady / UM for row in own], [row.plant for row in own], marker, markersize=6, label=name)
    ax.set_xscale("log")
    ax.set_ylim(len(plants) - 0.5, -0.5)
    style.label(ax, title, "steady contour error [µm]", "")
    style.legend(ax, loc="upper center", bbox_to_anchor=(0.4, -0.2), ncols=2)
    return ax


def _survival_text(rows: Sequence[Row]) -> str:
    of = {(row.law, row.plant): row.steady / UM for row in rows}
    bare, rubbed = "encoder exact", "encoder exact, friction"

    def told(plant, names=(SAME, STIFF)):
        return " and ".join(f"{of[name, plant]:.2g}" for name in names)

    return (
        f"Of the {of[OURS, bare]:.2g} um an encoder of 0.1 um leaves {of[OURS, 'encoder 0.1 um']:.2g}, one of 1 um "
        f"{of[OURS, 'encoder 1 um']:.2g} um; with 60 N of friction in every slider it is {of[OURS, rubbed]:.2g} um, "
        f"whatever the encoder.  Computed torque in the coordinates of the sliders, with the law's own poles and at 16 "
        f"Hz, stands at {told(bare)} um without friction and at {told(rubbed)} um with it.  Its speeds are half a "
        f"sample old.  Equivalent errors with such speeds have {of[OLDER, bare]:.2g} um: across the path what these "
        f"are off by stays the same all round, and the integral takes it; in the sliders it turns with the circle.  "
        f"Friction and wrong masses are held by stiffness more than by the choice of the error: with poles of 16 Hz "
        f"equivalent errors have {of[QUICK, rubbed]:.2g} um with friction.  At 25 and 50 % they have "
        f"{of[OURS, '25 % uncertain']:.2g} and {of[OURS, '50 % uncertain']:.2g} um as printed, "
        f"{of[QUICK, '25 % uncertain']:.2g} and {of[QUICK, '50 % uncertain']:.2g} um with poles of 16 Hz; computed "
        f"torque {told('25 % uncertain')} um at 25 %, {told('50 % uncertain')} um at 50 %."
    )


def _forms_text(rows: Sequence[Row]) -> str:
    told = []
    for form, name in (("dimensionless", "dimensionless"), ("area", "in m2")):
        parts_ = [f"{low:.2g}" if high / low < 1.01 else f"{low:.2g} to {high:.2g}"
                  for low, high in (effective(form, semi) for semi in (CIRCLE, ELLIPSE))]  # fmt: skip
        told.append(f"{name} {parts_[0]} m/s2 on the circle and {parts_[1]} on the ellipse")
    metre = [row.steady / UM for row in rows if row.law.startswith("metres")]
    return (
        f"K = 26 over the gradient of the equation is what holds the tool: {'; '.join(told)}.  In metres K is what it "
        f"says on every path: {metre[0]:.2g} um on the circle and {metre[1]:.2g} um on the ellipse with one tuning.  "
        "On the ellipse the forms without a root are better where they hold: in an even parameter their disturbance "
        "is nearly constant, and the integral takes it; in metres it is v^2 times the curvature, which changes."
    )


SURVIVES = Beyond(
    name="encoder_and_friction", title="What encoder and friction leave of 0.1 um, and what computed torque does",
    experiments=(Experiment("beyond: encoder and friction", _survives), Experiment("beyond: wrong masses", _wrong)),
    heads=HEADS, table=lambda results: _table(_joined(results)),
    picture=lambda results: _dots(_joined(results), "Circle: steady contour error"),
    text=lambda results: _survival_text(_joined(results)),
)  # fmt: skip
EQUATIONS = Beyond(
    name="choice_of_equation", title="What the choice of the path's equation does to the gains",
    experiments=(Experiment("beyond: forms of the equation", _forms),),
    heads=HEADS, table=lambda results: _table(_joined(results)),
    picture=lambda results: _bars(_joined(results), lambda r: f"{r.law}, {r.path}", "50 % on everything"),
    text=lambda results: _forms_text(_joined(results)),
)  # fmt: skip
BEYOND = (SURVIVES, EQUATIONS)


def _joined(results) -> list[Row]:
    return [row for rows in results for row in rows]
