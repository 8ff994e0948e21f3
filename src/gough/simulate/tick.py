"""One sample of a digital controller on a machine, as a kernel schedule.

    sense     q, q' of the plant; encoder; friction, for the log
    law ...   those of the law's tasks that are due in this sample
    control   the law's step: pose and speed from the encoder, force
    drive     delay, limit
    plant     `substeps` times: the forces in the joints that scale friction, from the acceleration of the sub-step
              before; half a step of the friction's memory with the velocity held, one RK4 step of the mechanics with
              the memory held, half a step of the memory (Strang); then the quaternion is normalised, or what depends
              on other coordinates pulled back to its closure
    limits    stroke, cones, det J

The memory inside RK4 would be stiff at high speed and gives NaN at these steps; split off, it is exact
(mechanics/friction.py).  Loads from the acceleration of now would be an algebraic loop; the mean one of the sub-step
before, (v+ - v) / h, is a step old, and the loads are held over the sub-step.  The friction of the log is that of the
loads held last: the bristles of LuGre stand where these put them.
"""

from __future__ import annotations

from functools import lru_cache

import casadi as ca
import numpy as np

from ..control.base import Controller
from ..declare import Shape
from ..frames import rotation_of_abc_np
from ..kernel import Schedule, Signal, Task
from ..kernel.pack import flatten, names
from ..machine.base import Machine
from ..mechanics.linear import solve_spd
from ..program.reference import Reference
from . import law_tasks
from .drive import drive, encoder

LOGGED = ("z", "v", "q", "qd", "q_m", "u_c", "u", "friction", "saturated")


def build(machine: Machine, law: Controller, state, reference: Reference, period: float, substeps: int) -> Schedule:
    """The schedule for the true `machine` under `law` whose first state is `state`.

    `period` is that of the plant's sample; the law may tick at a multiple of it (`law.period`), and its tasks at
    multiples of that.  `reference` is any row; of it, and of `state`, only names and sizes matter, of machine and law
    only the structure.

    Raises
    ------
    InputError
        the law's period is no multiple of `period`, or that of one of its tasks none of the law's.
    """
    rates = law_tasks.rates(law, period)
    made = _built if law.symbolic else _built.__wrapped__  # a function of Python's belongs to this very law
    return made(Shape(machine), Shape(law), _Template(state), _Template(reference), period, substeps, rates)


class _Template:
    """A NamedTuple as a key: equal for those with the same names."""

    def __init__(self, value):
        self.value, self.key = value, (type(value), names(value))

    def __hash__(self):
        return hash(self.key)

    def __eq__(self, other):
        return self.key == other.key


@lru_cache(maxsize=64)
def _built(
    machine: Shape,
    law: Shape,
    state: _Template,
    reference: _Template,
    period: float,
    substeps: int,
    rates: tuple[int, ...],
) -> Schedule:
    machine, law, state, reference = machine.part, law.part, state.value, reference.value
    n, v_count = machine.joints_count, len(machine.velocities)
    memory, loads = machine.memory_count, machine.load_count
    noisy = machine.drive.noise is not None
    z_count = machine.coordinate_count
    sizes = {"z": z_count, "v": v_count}
    signals = [
        Signal("theta_plant", len(machine.theta), "parameter", machine.names),
        Signal("theta_law", len(law.theta), "parameter", law.names),
        Signal("wrench", 6, "parameter"),
        Signal("reference", sum(np.size(part) for part in reference), "input", names(reference)),
        Signal("z", z_count, "state"),
        Signal("v", v_count, "state", machine.velocities),
        Signal("memory", memory, "state"),
        Signal("law", len(names(state)), "state", names(state)),
        Signal("u", n, "state", machine.joint_names),
        Signal("waiting", n, "state", machine.joint_names),
        *(Signal(name, n, "wire", machine.joint_names) for name in ("q", "qd", "q_m", "friction", "saturated")),
        Signal(
            "u_c", n, "wire" if rates[-1] == 1 else "state", machine.joint_names
        ),  # kept between the ticks of a slower law
        *(Signal(f"{name}{i}", size, "wire") for name, size in sizes.items() for i in (2, 3, 4)),
        *(Signal(f"{name}d{i}", size, "wire") for name, size in sizes.items() for i in (1, 2, 3, 4)),
    ]
    if noisy:
        signals.append(Signal("noise", n, "noise"))
    seen = () if machine.pose_is_state else ("tool", "xd")
    if seen:
        signals += [Signal("tool", 7, "wire"), Signal("xd", len(machine.task), "wire")]
    if loads:
        signals += [Signal("acceleration", v_count, "state", machine.velocities), Signal("loads", loads, "state")]
    limit_names, limits = _limits(machine)
    signals.append(Signal("limits", len(limit_names), "wire", limit_names))
    held = ("loads",) if loads else ()
    tasks = (
        Task(
            "sense",
            _sense(machine, noisy),
            ("theta_plant", "z", "v", "memory", *held) + (("noise",) if noisy else ()),
            ("q", "qd", "q_m", "friction", *seen),
        ),
        *law_tasks.tasks(law, state, reference, n, rates),
        Task("drive", _drive(machine, n), ("theta_plant", "u_c", "waiting"), ("u", "saturated", "waiting")),
    )
    return Schedule(
        signals,
        tasks,
        _substep(machine, period / substeps),
        substeps,
        Task("limits", limits, ("theta_plant", "z"), ("limits",)),
        LOGGED + ("law",) + (("memory",) if memory else ()) + seen,
        period,
    )


def first_states(schedule: Schedule, z, law_state, u0) -> dict[str, np.ndarray]:
    """The states of `schedule` at rest at the coordinates z, held by the forces u0."""
    given = {"z": z, "law": flatten(law_state), "u": u0, "waiting": u0, "u_c": u0}
    found = {s.name: np.asarray(given.get(s.name, np.zeros(s.size))) for s in schedule.of_kind("state")}
    # known from the first sub-step on; before it nothing moves, and any load but 0 gives the friction 0
    return found | {name: np.ones_like(value) for name, value in found.items() if name == "loads"}


def rest_row(machine: Machine, x: np.ndarray) -> Reference:
    """The reference of standing still at the pose x (d,)."""
    d, n = len(machine.task), machine.joints_count
    axis = rotation_of_abc_np(machine.tool_pose(x)[3:])[:, 2]
    zero = np.zeros
    return Reference(
        x,
        zero(d),
        zero(d),
        machine.inverse_kinematics(x),
        zero(n),
        zero(n),
        zero(1),
        zero(1),
        zero(3),
        zero(3),
        zero(1),
        axis,
    )


def rate(machine, p, z, v, memory, u, w, loads=None):
    """z' and v' under joint forces u, friction and a wrench w on the tool: eq. (1) of machine.base."""
    pi = {key: value for key, (value, _) in machine.inertial(p).items()}
    M, h = machine.mass_and_bias(p, pi, z, v)
    J = machine.jacobian_of(p, z)
    force = J.T @ (u - machine.strut_friction(p, J @ v, memory, loads)) + machine.wrench_of(p, z, w) - h
    if machine.load_count:
        force += machine.joint_friction(p, z, v, loads)
    return machine.rate(p, z, v), solve_spd(M, force)


def symbols_of(machine):
    """View and theta of a machine, z, v and the friction's memory, as fresh symbols."""
    p, theta = machine.symbols
    z = ca.SX.sym("z", machine.coordinate_count)
    return p, theta, z, ca.SX.sym("v", len(machine.velocities)), ca.SX.sym("memory", machine.memory_count)


def loads_symbol(machine):
    """The forces in the joints that friction asks for, as fresh symbols (none where it asks for none)."""
    return ca.SX.sym("loads", machine.load_count)


_LOADS = ("theta_plant", "z", "v", "memory", "acceleration", "u")


def loads_function(machine) -> ca.Function:
    """(theta, z, v, memory, v', u) -> the forces in the joints that friction asks for."""
    return _loads_of(Shape(machine))  # one object for all its tasks: the kernel compiles it once


@lru_cache(maxsize=64)
def _loads_of(shape: Shape) -> ca.Function:
    machine = shape.part
    p, theta, z, v, mem = symbols_of(machine)
    vd, u = ca.SX.sym("vd", v.shape), ca.SX.sym("u", machine.joints_count)
    return ca.Function("loads", [theta, z, v, mem, vd, u], [machine.loads_of(p, z, v, vd, mem, u)])


def _sense(machine, noisy):
    p, theta, z, v, mem = symbols_of(machine)
    loads = loads_symbol(machine)
    q = machine.joints_of(p, z)
    normal = ca.SX.sym("noise", machine.joints_count)
    qd = machine.jacobian_of(p, z) @ v
    friction = machine.strut_friction(p, qd, mem, loads)
    inputs = [theta, z, v, mem] + ([loads] if machine.load_count else []) + ([normal] if noisy else [])
    out = [q, qd, encoder(machine, p, machine.measured_of(p, z), normal), friction]
    if not machine.pose_is_state:
        out += [ca.vertcat(*machine.tool_pose_of(p, z)), machine.task_rate_of(p, z, v)]
    return ca.Function("sense", inputs, out)


def _drive(machine, n):
    p, theta = machine.symbols
    u_c, waiting = ca.SX.sym("u_c", n), ca.SX.sym("waiting", n)
    return ca.Function("drive", [theta, u_c, waiting], list(drive(machine, p, u_c, waiting)))


def _limits(machine):
    p, theta, z, _, _ = symbols_of(machine)
    found, values = machine.margins(p, z)
    return found, ca.Function("limits", [theta, z], [values])


def _substep(machine, h):
    p, theta, z, v, mem = symbols_of(machine)
    u, w = ca.SX.sym("u", machine.joints_count), ca.SX.sym("w", 6)
    loads = loads_symbol(machine)
    held, held_symbols = (("loads",), [loads]) if machine.load_count else ((), [])
    dynamics = ca.Function(
        "rate", [theta, z, v, mem, u, w, *held_symbols], list(rate(machine, p, z, v, mem, u, w, loads))
    )
    zd, vd = ca.SX.sym("zd", z.shape), ca.SX.sym("vd", v.shape)
    half, full = (
        ca.Function(name, [z, v, zd, vd], [z + c * zd, v + c * vd]) for name, c in (("half", h / 2), ("full", h))
    )
    slopes = [ca.SX.sym(f"{name}{i}", y.shape) for i in range(4) for name, y in (("zd", z), ("vd", v))]
    z_next, v_next = (y + h / 6 * (a + 2 * b + 2 * c + d) for y, (a, b, c, d) in ((z, slopes[::2]), (v, slopes[1::2])))
    ends = [machine.normalised(p, z_next), v_next] + ([(v_next - v) / h] if machine.load_count else [])
    finish = ca.Function("finish", [theta, z, v, *slopes], ends)
    given = ("memory", "u", "wrench", *held)
    stages = []
    for i, step in enumerate((None, half, half, full)):
        at = ("z", "v") if step is None else (f"z{i + 1}", f"v{i + 1}")
        if step is not None:
            stages.append(Task(f"stage {i + 1}", step, ("z", "v", f"zd{i}", f"vd{i}"), at))
        stages.append(Task(f"rate {i + 1}", dynamics, ("theta_plant", *at, *given), (f"zd{i + 1}", f"vd{i + 1}")))
    stages.append(
        Task(
            "finish",
            finish,
            ("theta_plant", "z", "v", *(f"{name}d{i}" for i in (1, 2, 3, 4) for name in "zv")),
            ("z", "v") + (("acceleration",) if machine.load_count else ()),
        )
    )
    if mem.numel():
        qd = machine.jacobian_of(p, z) @ v
        advanced = machine.memory_advanced(p, qd, mem, h / 2, loads)
        advance = ca.Function("memory", [theta, z, v, mem, *held_symbols], [advanced])
        before, after = (
            Task(f"memory {when}", advance, ("theta_plant", "z", "v", "memory", *held), ("memory",))
            for when in ("before", "after")
        )
        stages = [before, *stages, after]
    if machine.load_count:
        stages = [Task("loads", loads_function(machine), _LOADS, held), *stages]
    return tuple(stages)
