"""What neglecting the inertia of the legs costs, if they weigh 8 kg each.

The paper lumps the legs into motors and platform.  Three beliefs of a machine whose legs have mass: no legs; half of
each as a point on its carriage and half on the platform; and the numbers of a machine without legs that fit its forces
best, which is what learning can come to.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ...machine.hexaglide import Hexaglide
from ...machine.workspace import random_poses
from ...report import style
from ..study import Beyond, Experiment, Tick, parts
from . import circle
from .rows import UM
from .setup import computed_torque, machine

MASS = 8.0  # kg a leg: a steel tube of 1 m, 60 mm wide with a wall of 6 mm
CIRCLE = 0.3  # m/s; at 0.4 with such legs the motors would need more than their 2500 N
MOTIONS = 2000
SPEED, RATE = np.repeat([0.5, 0.3], 3), np.repeat([5.0, 3.0], 3)  # m/s, rad/s; m/s2, rad/s2: of a component


class Cost(NamedTuple):
    """What a belief costs."""

    belief: str
    force: float  # rms of the forces' error over rms of the forces
    turn: circle.Turn | None  # computed torque with this belief as feed-forward; None: not run


def true_machine() -> Hexaglide:
    """The machine of the paper with legs of MASS."""
    return machine().replace(**{"legs.mass": MASS})


def lumped() -> Hexaglide:
    """The machine without legs, half of each leg on its carriage and half on the platform, at its joint."""
    m = machine()
    m = m.replace(**{"carriage.mass": m.carriage.mass + MASS / 2})
    for point in m.joints.platform:
        m = m.replace(platform=m.platform.joined(MASS / 2, point))
    return m


def motions() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Random poses in the workspace, twists and twist rates.  (MOTIONS, 6) each."""
    rng = np.random.default_rng(0)
    x = random_poses(machine(), MOTIONS, rng)
    V, Vd = rng.normal(size=(2, MOTIONS, 6))
    return x, V * SPEED, Vd * RATE


def costs(tick: Tick | None = None) -> list[Cost]:
    """Neglected, lumped, fitted and known legs."""
    true, rows = true_machine(), motions()
    u = true.inverse_dynamics(*rows)
    beliefs = {"neglected": machine(), "lumped half and half": lumped(), "known": true}
    out = []
    for (name, believed), part in zip(beliefs.items(), parts(tick, [1.0] * len(beliefs)), strict=True):
        turn = circle.turn(computed_torque(observer="exact"), CIRCLE, part, true, believed)
        out.append(Cost(name, _share(believed.inverse_dynamics(*rows) - u, u), turn))
    Y = machine().regressor(*rows)
    Y = Y.reshape(-1, Y.shape[-1])
    scale = np.linalg.norm(Y, axis=0)
    best = np.linalg.lstsq(Y / scale, u.ravel(), rcond=None)[0] / scale
    out.insert(2, Cost("no legs, fitted to the forces", _share(Y @ best - u.ravel(), u), None))
    return out


def _share(off, u) -> float:
    return float(np.sqrt((off**2).mean() / (u**2).mean()))


def _table(results: Sequence[list[Cost]]) -> list[list[str]]:
    return [
        [cost.belief, f"{100 * cost.force:.2g} %",
         *(["-"] * len(circle.KEYS) if cost.turn is None else [f"{cost.turn.table[k] / UM:.2f}" for k in circle.KEYS])]
        for cost in results[0]
    ]  # fmt: skip


def _picture(results: Sequence[list[Cost]]) -> Any:
    ax = style.new_axes((7.2, 4.0))
    for cost in results[0]:
        if cost.turn is not None:
            ax.plot(cost.turn.angle, cost.turn.error / UM, linewidth=1.0, label=cost.belief)
    style.label(ax, f"Legs of {MASS:g} kg, circle at {CIRCLE:g} m/s", "angle on the circle [rad]",
                "error of the radius [µm]")  # fmt: skip
    style.legend(ax, loc="lower left")
    return ax


def _text(results: Sequence[list[Cost]]) -> str:
    none, lumps, fitted, _ = (100 * cost.force for cost in results[0])
    return (
        f"Forces of {MOTIONS} random motions of 0.5 m/s and 5 m/s2 a component, rms: without the legs {none:.2g} % of "
        f"them is missing, lumped legs leave {lumps:.2g} %, and no machine without legs leaves less than "
        f"{fitted:.2g} %.  The observer is sampled exactly here, so that what the legs cost is not behind its error; "
        "at 0.4 m/s such legs take the motors to their limit."
    )


LEGS = Beyond(
    name="legs",
    title=f"Legs of {MASS:g} kg: error of the forces, and of the radius in um, computed torque at {CIRCLE:g} m/s",
    experiments=[Experiment(f"legs of {MASS:g} kg", costs)],
    heads=("legs believed", "force, rms", *circle.KEYS),
    table=_table,
    picture=_picture,
    text=_text,
)
