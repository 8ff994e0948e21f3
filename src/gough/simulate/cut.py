"""The cut in the tick: the force of an end mill on the plant, at every stage of every sub-step.

In sample k, which begins at t_k = k Ts, the spindle stands at phi_0 + Omega t_k + Omega (t - t_k), so at the times of
the stages of RK4, t, t + h/2 and t + h, its angle is exact, whatever the length of the run.  Held over the sample are
the radial depth at the reference's place, its feed, and the frame C of cutting/force.py on the true tool: z along its
axis, x along the feed as far as that is across the axis.  With F and M_z of cutting/force.py the wrench on the tool is

    w = [f; (height / 2) z x f + M_z z],   f = F_x x + F_y y + F_z z                                                (1)

at the tip, in W: the force acts at half the height of the wall.  Its impulse over a sample is summed by Simpson's rule
over the stages; the impulse of the last sample over Ts is the variable `cutting_force` of the log, the dynamometer.

With `regenerative` the chip is what the true tool left a tooth ago: (a, b) of eq. (3) there is p(t) - p(t - T) in x
and y, T the tooth period, from places kept at every sub-step, linear in between; and the depth is that of the true
tool, more where it is pushed into the wall.  Before a whole T of the run has passed the tool is taken to have stood.
"""

from __future__ import annotations

import dataclasses
import math
from functools import lru_cache

import casadi as ca
import numpy as np

from .. import frames
from ..cutting import force
from ..cutting.cutting import Cutting
from ..declare import Shape
from ..errors import ExperimentError
from ..kernel import Schedule, Signal, Task
from ..kernel.pack import flatten, symbols
from ..program.reference import Reference
from .faults import clocked
from .structure import same_structure

STEPS = 8  # sub-steps a tooth at the least: 16 looks at a pulse of force
MOST_KEPT = 512  # places of the tool that are kept for a regenerative chip
VARIABLES = {
    "plant.radial_depth": ("radial_depth", (), "m", "radial depth of the cut"),
    "plant.spindle_angle": ("spindle_angle", (), "rad", "angle of the spindle, tooth 0 from y of the feed's frame"),
}


def substeps_of(cutting: Cutting | None, period: float, needed: int, given: int | None) -> int:
    """Sub-steps a sample that see every tooth: `needed` or more.

    Raises
    ------
    ExperimentError
        `given` are too few.
    """
    if cutting is None:
        return needed
    least = math.ceil(STEPS * period / cutting.tooth_period - 1e-9)
    if given is not None and given < least:
        raise ExperimentError(
            f"{given} sub-steps a sample miss the teeth of the cut, one every {cutting.tooth_period * 1e3:.4g} ms",
            key="run.substeps", limit=str(least), cure=f"give at least {least}, or leave it out",
        )  # fmt: skip
    return max(needed, least)


def kept(cutting: Cutting, step: float) -> int:
    """How many places of the tool a regenerative chip looks back over; 0 for one that knows the feed only."""
    return math.ceil(cutting.tooth_period / step - 1e-9) + 1 if cutting.regenerative else 0


def parameters(cutting: Cutting | None) -> dict[str, np.ndarray]:
    """The parameters that the cut adds to those of a run."""
    return {} if cutting is None else {"theta_cutting": cutting.theta}


def states(schedule: Schedule, x0: np.ndarray) -> dict[str, np.ndarray]:
    """The states that the cut adds to those of a run that begins with the tool at x0 (3,) m."""
    found = {name: np.zeros(schedule.by_name[name].size) for name in ("turned", "impulse") if name in schedule.by_name}
    if "trail" in schedule.by_name:
        found["trail"] = np.tile(x0, schedule.by_name["trail"].size // 3)
    return found


def with_cutting(schedule: Schedule, machine, row: Reference, cutting: Cutting | None) -> Schedule:
    """The tick of `tick.build` for the true `machine` with the cut.

    It has the parameter "theta_cutting" and logs "cutting_force", "radial_depth" and "spindle_angle".

    Raises
    ------
    ExperimentError
        a regenerative chip that would have to be remembered for too long.
    """
    if cutting is None:
        return schedule
    look_back = kept(cutting, schedule.period / schedule.substeps)
    if look_back > MOST_KEPT:
        raise ExperimentError(
            "a regenerative chip must be remembered from tooth to tooth", key="plant.cutting.regenerative",
            value=f"{look_back} sub-steps", limit=str(MOST_KEPT), cure="a faster spindle, or fewer sub-steps",
        )  # fmt: skip
    template = Reference(*(np.zeros(np.size(part)) for part in row))
    return _with(schedule, Shape(machine), _Row(template), Shape(cutting), look_back)


def check(cutting: Cutting | None, motion) -> None:
    """Refuse a cut that a motion does not make.  ExperimentError."""
    if cutting is not None:
        path = getattr(motion, "course", motion).path
        feeds = path.feed[(~path.rapid) & (path.length > 0)]
        cutting.check_path(float(path.s0[-1]), float(feeds.max(initial=0.0)))


def check_batch(cuttings: list[Cutting | None]) -> None:
    """Refuse cuts of a batch that differ in more than numbers.  ExperimentError."""
    if any(cutting is None for cutting in cuttings) and any(cutting is not None for cutting in cuttings):
        i = next(i for i, cutting in enumerate(cuttings) if (cutting is None) != (cuttings[0] is None))
        raise ExperimentError(
            "of a batch all runs cut, or none", key=f"plant.{i}.cutting", cure="run those that cut together"
        )
    if cuttings[0] is not None:
        same_structure("plant.cutting", cuttings)


class _Row:
    """Sizes of a row of the reference, as a key."""

    def __init__(self, template: Reference):
        self.template, self.sizes = template, tuple(np.size(part) for part in template)

    def __hash__(self):
        return hash(self.sizes)

    def __eq__(self, other):
        return isinstance(other, _Row) and self.sizes == other.sizes


@lru_cache(maxsize=64)
def _with(schedule: Schedule, machine: Shape, row: _Row, shape: Shape, look_back: int) -> Schedule:
    cutting, m = shape.part, machine.part
    theta = len(cutting.theta)
    course = "course" if "course" in schedule.by_name else "reference"
    signals = [
        Signal("theta_cutting", theta, "parameter", cutting.names),
        Signal("turned", 1, "state"),  # angle of the spindle at the beginning of the sub-step
        Signal("impulse", 6, "state"),
        *([Signal("trail", 3 * look_back, "state")] if look_back else []),
        *(Signal(name, size, "wire") for name, size in _ENGAGED),
        *(Signal(name, 6, "wire") for name in ("cutting_force", "wrench_now", *_STAGES)),
    ]
    engage = Task(
        "engage", _engage(cutting, row.template, schedule.period),
        ("theta_cutting", course, "clock", "impulse"),
        (*(name for name, _ in _ENGAGED), "turned", "cutting_force", "impulse"),
    )  # fmt: skip
    given = ("theta_plant", "theta_cutting", *(name for name, _ in _ENGAGED), "turned", "z", "v", "wrench", "impulse")
    step = schedule.period / schedule.substeps
    cut = _cut(m, cutting, step, look_back)
    trail = ("trail",) if look_back else ()
    now = Task("cut now", _now(m, cutting, step, look_back), (*given[:-1], *trail), ("wrench_now",))
    stages = Task("cut", cut, (*given, *trail), (*_STAGES, "turned", "impulse", *trail))
    after = [task.name for task in schedule.tasks].index("drive") + 1
    at_tick = [_reading(task, {"wrench": "wrench_now"}) for task in schedule.tasks[after:]]
    which = {f"rate {i + 1}": stage for i, stage in enumerate((_STAGES[0], _STAGES[1], _STAGES[1], _STAGES[2]))}
    substep = [
        _reading(task, {"wrench": which[task.name]}) if task.name in which else task for task in schedule.substep
    ]
    return dataclasses.replace(
        schedule, signals=(*clocked(schedule), *signals),
        tasks=(*schedule.tasks[:after], engage, *([now] if at_tick else []), *at_tick),
        substep=(stages, *substep), log=(*schedule.log, "cutting_force", "radial_depth", "spindle_angle"),
    )  # fmt: skip


_ENGAGED = (("feed", 1), ("radial_depth", 1), ("spindle_angle", 1), ("along", 3), ("place", 3))
_STAGES = ("wrench_begin", "wrench_middle", "wrench_end")


def _reading(task: Task, swap: dict[str, str]) -> Task:
    return dataclasses.replace(task, reads=tuple(swap.get(name, name) for name in task.reads))


def _engage(cutting, template, period):
    """What is held over a sample, and the mean force of the last one."""
    theta, clock, impulse = ca.SX.sym("theta", len(cutting.theta)), ca.SX.sym("clock"), ca.SX.sym("impulse", 6)
    c, r = cutting.at(theta), symbols(template)
    feed = r.sd * (2 * np.pi / (cutting.tool.teeth * c.spindle_speed))
    depth = ca.if_else(r.sd > 0, cutting.wall.depth_of(c.wall, r.s, ca), 0.0)
    angle = c.start_angle + c.spindle_speed * (clock * period)
    angle = angle - 2 * np.pi * ca.floor(angle / (2 * np.pi))
    place = r.x[:3] if r.x.numel() >= 3 else ca.SX.zeros(3)
    out = [feed, depth, angle, r.tangent, place, angle, impulse / period, ca.SX.zeros(6)]
    return ca.Function("engage", [theta, flatten(r), clock, impulse], [ca.SX(part) for part in out])


class _Cut:
    """The symbols of a sub-step of the cut, and the wrench at a time within it."""

    def __init__(self, m, cutting, step, look_back):
        p, self.theta_p = m.symbols
        self.theta = ca.SX.sym("theta", len(cutting.theta))
        sizes = dict(_ENGAGED)
        self.engaged = [ca.SX.sym(name, sizes[name]) for name, _ in _ENGAGED]
        self.turned, self.z = ca.SX.sym("turned"), ca.SX.sym("z", m.coordinate_count)
        self.v, self.wrench = ca.SX.sym("v", len(m.velocities)), ca.SX.sym("w", 6)
        self.trail = ca.SX.sym("trail", 3 * look_back)
        self.given = [self.theta_p, self.theta, *self.engaged, self.turned, self.z, self.v, self.wrench]
        self.cutting, self.c, self.step, self.look_back = cutting, cutting.at(self.theta), step, look_back
        feed, depth, _, tangent, place = self.engaged
        self.position, quaternion = m.tool_pose_of(p, self.z)
        self.axis = frames.rotation_of_quaternion(quaternion)[:, 2]
        across = tangent - ca.dot(tangent, self.axis) * self.axis
        size = ca.norm_2(across)
        # a feed along the axis is no milling of a wall: it has no x, and no chip
        self.x = across / ca.fmax(size, 1e-9)
        self.y = ca.cross(self.axis, self.x)
        self.feed = feed * size
        self.depth = ca.if_else(size > 1e-6, depth, 0.0)
        if look_back:  # the true tool, as far as it stands nearer to the wall than the reference
            self.speed = ca.jtimes(self.position, self.z, m.rate(p, self.z, self.v))
            near = cutting.wall.side * ca.dot(self.y, self.position - place) if len(m.task) >= 3 else 0.0
            self.depth = ca.if_else(self.depth > 0, ca.fmax(self.depth + near, 0.0), 0.0)

    def at(self, share: float):
        """The wrench on the tool at so much of the sub-step, without the steady one.  (6,)."""
        c, cutting = self.c, self.cutting
        a, b = self.feed, 0.0
        if self.look_back:
            moved = self.position + self.speed * (share * self.step) - self._before(share)
            a, b = ca.dot(self.x, moved), ca.dot(self.y, moved)
        tool, teeth, height = c.tool, cutting.tool.teeth, c.wall.axial_depth
        window = force.window(ca, tool, self.depth, cutting.wall.side)
        cuts = force.pieces(ca, tool, teeth, a, *window)
        angle = self.turned + c.spindle_speed * (share * self.step)
        F = force.force(ca, tool, c.coefficients, teeth, height, cuts, angle, b)
        f = F[0] * self.x + F[1] * self.y + F[2] * self.axis
        on = self.depth > 0
        return ca.if_else(on, ca.vertcat(f, height / 2 * ca.cross(self.axis, f) + F[3] * self.axis), ca.SX.zeros(6))

    def _before(self, share):
        """Where the tool was a tooth period before that time; the trail's first entry is a sub-step ago."""
        back = 2 * np.pi / (self.cutting.tool.teeth * self.c.spindle_speed) / self.step - share  # in sub-steps
        out = self.position
        trail = [self.position, *(self.trail[3 * i : 3 * i + 3] for i in range(self.look_back))]
        for i in range(self.look_back):
            part = back - i
            between = trail[i] + part * (trail[i + 1] - trail[i])
            out = ca.if_else(ca.logic_and(part >= 0, part <= 1), between, out)
        return out


def _cut(m, cutting, step, look_back):
    """The wrenches of the three times of a sub-step, the angle after it, the impulse so far, and the trail."""
    s = _Cut(m, cutting, step, look_back)
    impulse = ca.SX.sym("impulse", 6)
    begin, middle, end = (s.at(share) for share in (0.0, 0.5, 1.0))
    after = impulse + step / 6 * (begin + 4 * middle + end)
    out = [*(s.wrench + w for w in (begin, middle, end)), s.turned + s.c.spindle_speed * step, after]
    given = [*s.given, impulse]
    if look_back:
        given.append(s.trail)
        out.append(ca.vertcat(s.position, s.trail[:-3]))
    return ca.Function("cut", given, out)


def _now(m, cutting, step, look_back):
    """The wrench on the tool at the beginning of the sample."""
    s = _Cut(m, cutting, step, look_back)
    return ca.Function("cut_now", [*s.given, *([s.trail] if look_back else [])], [s.wrench + s.at(0.0)])


def columns(row, part) -> dict[str, np.ndarray]:
    """The cut's variables of a chunk, thinned by the slice `part`."""
    if "cutting_force" not in row:
        return {}
    return {"cutting_force": row["cutting_force"][part]} | {
        name: row[signal][part][..., 0] for name, (signal, *_) in VARIABLES.items()
    }
