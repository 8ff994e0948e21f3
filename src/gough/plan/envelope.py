"""How far a machine can go from a pose: along each coordinate both ways, and in every direction at once.

    found = gk.envelope(gk.load_machine("nist-octahedral"), [0.1, 0, 0, 0, 0, 0])
    print(found)

Along a coordinate the others stand still: X is x rising, A the angle a rising, as they are jogged.  Translations
jointly: the largest r such that the tip may go by less than r in any direction, the tool's direction kept.  Turns
jointly: the largest angle such that the tool may turn by less about any axis through its tip, the tip standing still.
Within are the limits of the joints, cones, det J and the condition number of J, and the forces of the drives that hold
the machine at rest; the declared workspace only if asked.  What is given is the FIRST exit: a way back in behind it
does not count.  How it is searched, and what the search may overlook: first_exit.py and ball.py.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..errors import ExperimentError, SingularityError, WorkspaceError
from ..frames import abc_of_rotation_np, rotation_of_abc_np, rotation_of_vector_np
from ..machine.arrays import column
from ..units import show
from .ball import largest_ball
from .bounds import Bounds
from .findings import place_text
from .first_exit import first_exits

STEP = {"m": 0.5e-3, "rad": np.radians(0.05)}  # of samples along a way
_LONGEST = {"m": 20.0, "rad": np.pi}  # ways are not looked at beyond


class Way(NamedTuple):
    """How far one coordinate may go in one sense."""

    axis: str  # X, Y, Z, A, B, C
    sense: int  # +1 or -1
    unit: str
    distance: float  # m or rad; inf: no limit within half a turn
    limit: str  # the first that is met; "" where none is


class Ball(NamedTuple):
    """How far all directions may be gone at once."""

    kind: str  # "translation" or "turn"
    unit: str
    radius: float
    limit: str
    direction: tuple[float, float, float]  # in W, in which it is met; of a turn its axis


class Envelope(NamedTuple):
    """What `envelope` found.  It prints itself."""

    machine: str
    pose: dict[str, float]
    ways: tuple[Way, ...]
    balls: tuple[Ball, ...]
    within: tuple[str, ...]  # sorts of limits that were looked at

    def to_json(self) -> dict[str, Any]:
        """What `gough envelope --json` prints, SI."""
        return {
            "machine": self.machine, "pose": dict(self.pose), "within": list(self.within),
            "ways": [way._asdict() for way in self.ways], "balls": [ball._asdict() for ball in self.balls],
        }  # fmt: skip

    def __repr__(self) -> str:
        lines = [f"{self.machine} at {place_text(self.pose)}, within {', '.join(self.within)}"]
        for way in self.ways:
            told = show(way.distance, way.unit, 6) if np.isfinite(way.distance) else "half a turn and more"
            lines.append(f"  {way.axis}{'+' if way.sense > 0 else '-'}  {told:>14}  {way.limit}".rstrip())
        for ball in self.balls:
            name = "any direction" if ball.kind == "translation" else "turn about any axis"
            lines.append(f"  {name}: {show(ball.radius, ball.unit, 6)}  {ball.limit}")
        return "\n".join(lines)

    __str__ = __repr__


def envelope(machine, pose=None, wrench=None, workspace: bool = False) -> Envelope:
    """How far from a pose (d,), default home, until the first limit.

    `wrench` (6,) [f; m] on the tool at its tip, in W, is held by the drives as well as the weight; with `workspace` the
    declared workspace is a limit, too.  The module says what is searched and what the search may overlook.

    Raises
    ------
    ExperimentError
        a pose or wrench that is not of this machine.
    WorkspaceError, SingularityError
        the pose is outside itself: which limit, and by how much.
    """
    x = np.array(machine.home if pose is None else column(pose, len(machine.task), "pose"), float)
    if x.ndim != 1:
        raise ExperimentError("one pose", key="pose", value=str(x.shape), cure="call it for each")
    w = None if wrench is None else column(wrench, 6, "wrench")
    bounds = Bounds(machine, force=True, workspace=workspace, wrench=w)
    _check_start(bounds, x)

    def shares(rows) -> np.ndarray:
        return bounds.of(rows)[0] / bounds.scale

    ways, near = _ways(machine, bounds, shares, x), {}
    for way in ways:
        near[way.unit] = min(near.get(way.unit, np.inf), way.distance)
    balls = []
    if len(x) >= 3:
        balls.append(_ball("translation", "m", bounds, _moved(x, shares), near["m"]))
    if len(x) == 6:
        balls.append(_ball("turn", "rad", bounds, _leant(x, shares), min(_leaning(x, shares), np.pi)))
    within = ["joint limits", "singularity"] if len(x) > 1 else ["joint limits"]
    within += ["drive forces at rest"] * (bounds.limit is not None) + ["declared workspace"] * bounds.workspace
    task = {name: float(value) for (name, _), value in zip(machine.task, x, strict=True)}
    return Envelope(machine.name, task, tuple(ways), tuple(balls), tuple(within))


def _check_start(bounds: Bounds, x) -> None:
    """Refuse a pose that is outside."""
    margins = bounds.of(x[None])[0][0]
    if (margins >= 0).all():
        return
    rule, value, limit = bounds.told(x, margins)
    kind = SingularityError if rule.startswith("near a singularity") else WorkspaceError
    raise kind(
        rule, where="the pose itself is outside", value=value, limit=limit, cure="give a pose inside: home is one"
    )


def _ways(machine, bounds, shares, x) -> list[Way]:
    out = []
    for unit in dict.fromkeys(unit for _, unit in machine.task):
        columns = [i for i, (_, one) in enumerate(machine.task) if one == unit]
        senses = [(i, sense) for i in columns for sense in (1, -1)]
        ahead = np.zeros((len(senses), len(x)))
        ahead[np.arange(len(senses)), [i for i, _ in senses]] = [sense for _, sense in senses]
        found, behind = first_exits(
            lambda way, s, ahead=ahead: shares(x + s[:, None] * ahead[way]), len(senses), STEP[unit], _LONGEST[unit]
        )
        for k, (i, sense) in enumerate(senses):
            met = _named(bounds, behind[k]) if np.isfinite(found[k]) else ""
            out.append(Way(machine.task[i][0].upper(), sense, unit, float(found[k]), met))
    return out


def _named(bounds: Bounds, margins) -> str:
    """The limit that was met, by the margins just behind."""
    if np.isnan(margins).all():
        return "no joint coordinates have the pose"
    return bounds.names[int(np.nanargmin(margins))]


def _moved(x, shares):
    """Margins at places x + r d, the tool's direction kept."""

    def field(d, r):
        rows = np.tile(x, (len(d), 1))
        rows[:, :3] += r[:, None] * d
        return shares(rows)

    return field


def _leant(x, shares):
    """Margins with the tool turned by r about d, the tip standing."""
    R = rotation_of_abc_np(x[3:])

    def field(d, r):
        rows = np.tile(x, (len(d), 1))
        rows[:, 3:] = abc_of_rotation_np(rotation_of_vector_np(r[:, None] * d) @ R)
        return shares(rows)

    return field


def _leaning(x, shares) -> float:
    """The least exit of turns about the axes of W: no ball of turns is larger."""
    axes, field = np.concatenate([np.eye(3), -np.eye(3)]), _leant(x, shares)
    return float(first_exits(lambda way, s: field(axes[way], s), 6, STEP["rad"], _LONGEST["rad"])[0].min())


def _ball(kind: str, unit: str, bounds: Bounds, field, known: float) -> Ball:
    if known == 0:
        return Ball(kind, unit, 0.0, "the pose is on a limit", (0.0, 0.0, 0.0))
    radius, d, behind = largest_ball(field, known, STEP[unit])
    return Ball(kind, unit, radius, _named(bounds, behind), tuple(map(float, d)))
