"""Preflight: whether a machine can follow a program, told before metal is cut, worst line first.

What is judged is one of two motions:

    "cartesian"  the program as a controller drives it that knows the limits of the tool (data sheet, [feed]) and none
                 of the joints, as LinuxCNC's planner does in coordinated moves: F as commanded, trapezoids of the speed
    "joints"     the same with the feed kept within the joints' speed and acceleration (program/joint_limits.py)
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..errors import Problem, WorkspaceError
from ..machine.workspace import outside_workspace, workspace_margins
from ..program.size import WOULD_FIT, too_large
from .advice import ELSEWHERE, advise
from .course import state
from .demand import FORCE, POSE, Demand, parted
from .judge import Found, judge

if TYPE_CHECKING:
    from ..simulate.plant import Plant

CARTESIAN, JOINTS = "cartesian", "joints"
_NEAR = 0.7  # of the drives' force: sampled loops were seen to add a third of the limit for some samples
ADVISED = 200  # findings that get advice of their own
_ROWS = 20_000
IN_MM = "are its numbers mm? then write G21"


class Finding(NamedTuple):
    """A limit that the program exceeds on one line, where it does so most."""

    line: int  # of the program; 0: none
    kind: str  # "pose", "speed", "acceleration" or "force"
    joint: str  # "strut 3", or "pose"
    what: str
    value: str
    limit: str
    use: float  # value by limit; of a pose how far beyond home it is, the limit being 1
    time: float  # s
    advice: str | None

    def problem(self, file: str | None) -> Problem:
        """The finding as an error tells it."""
        return Problem(
            self.what, file=file, line=self.line or None, where=self.joint, value=self.value, limit=self.limit,
            time=self.time, cure=self.advice,
        )  # fmt: skip


class Peak(NamedTuple):
    """How much of one limit the program uses at most."""

    joint: str
    what: str
    kind: str
    value: str
    limit: str
    use: float
    line: int
    time: float


class Preflight:
    """What a preflight found.  It prints itself."""

    def __init__(self, motion, demand: Demand, found: Found, name: str, controller: str, text: str | None = None):
        self.motion, self.demand, self.found = motion, demand, found
        self.name, self.controller, self.machine = name, controller, demand.machine
        self.duration = float(motion.duration)
        self.findings = _findings(motion, demand, found)
        self.size = too_large(motion.course.path, self.machine, text) if self.findings else None
        if self.size is not None and self.size.endswith(WOULD_FIT):  # --place would look in vain
            self.findings = [one._replace(advice=IN_MM) if one.advice == ELSEWHERE else one for one in self.findings]
        self.warnings = _warnings(motion, demand, found)

    @property
    def exceeded(self) -> int:
        """How many limits are exceeded, of all lines; `findings` are the worst of them."""
        return len(self.findings) + self.found.exceeded - len(self.found.beyond)

    @property
    def passed(self) -> bool:
        """Whether the machine can follow the program."""
        return not self.findings

    @property
    def least(self) -> float:
        """The least margin over all limits: 0 at a limit, below 0 beyond it."""
        return float("-inf") if self.found.unreachable else 1 - float(self.found.top.max())

    @property
    def peaks(self) -> list[Peak]:
        """The greatest use of every limit, greatest first."""
        found, out = self.found, []
        for c in np.argsort(-found.top, kind="stable"):
            told = self.demand.told(int(c), float(found.top[c]))
            joint, what = self.demand.name(int(c))
            place = float(found.top[c]), int(found.top_line[c]), float(found.top_time[c])
            out.append(Peak(joint, str(what), told.kind, told.value, told.limit, *place))
        return out

    def error(self) -> WorkspaceError:
        """The findings as an error, worst first."""
        return WorkspaceError(problems=[finding.problem(self.name) for finding in self.findings])

    def to_json(self) -> dict[str, Any]:
        """Plain numbers and texts."""
        found = self.found
        return {
            "program": self.name,
            "machine": self.machine.name,
            "controller": self.controller,
            "passed": self.passed,
            "exceeded": self.exceeded,
            "duration": self.duration,
            "least_margin": self.least,
            "unchecked": list(self.demand.unchecked),
            "findings": [finding._asdict() for finding in self.findings],
            "peaks": [peak._asdict() for peak in self.peaks],
            "warnings": [*([] if self.size is None else [self.size]), *self.warnings],
            "condition": found.condition,
            "rows": found.rows,
        }

    def __str__(self) -> str:
        return report(self)


def preflight(
    machine, program, controller: str = CARTESIAN, tell: Callable[[float], None] | None = None,
    plant: Plant | None = None,
) -> Preflight:  # fmt: skip
    """What a machine is asked for along a whole program: stroke, joint angles, speeds, accelerations, forces.

    program      an NC program or a standard one, cut along a path
    controller   which motion is judged: "cartesian" or "joints", see above
    tell         called with the share that is done
    plant        what the machine really is: its numbers, payload and steady force are asked, on the motion that the
                 machine, as it is believed, is commanded

    Raises
    ------
    ProgramError
        a path that cannot be followed at all, or a motion given over time.
    """
    motion = planned(machine, program, controller)
    demand = Demand(machine, plant=plant)
    found = judge(motion, demand, tell)
    name, text = getattr(program, "name", type(program).__name__), getattr(program, "text", None)
    return Preflight(motion, demand, found, name, controller, text)


def planned(machine, program, controller: str = CARTESIAN):
    """The motion that is judged."""
    wanted = controller == JOINTS
    if getattr(program, "joint_limits", wanted) != wanted:
        program = program.replace(joint_limits=wanted)
    return program.plan(machine.rigid)


def _findings(motion, demand: Demand, found: Found) -> list[Finding]:
    out = []
    for line, (t, x) in found.unreachable.items():
        _, error = demand.machine.unreachable(np.atleast_2d(x)) or (0, None)
        told = error.problems[0] if error else Problem("no joint coordinates have this pose")
        joint, what = parted(told.rule)
        value = told.value or f"x y z = {', '.join(f'{1e3 * v:.4g}' for v in x[:3])} mm"
        out.append(Finding(line, POSE, joint, what, value, told.limit or "reach", float("inf"), t, ELSEWHERE))
    advice = advise(motion, demand, found.beyond[:ADVISED])
    for i, b in enumerate(found.beyond):
        told = demand.told(b.column, b.use)
        out.append(Finding(b.line, told.kind, told.joint, told.what, told.value, told.limit, b.use, b.time,
                           advice[i] if i < len(advice) else None))  # fmt: skip
    limit = demand.machine.limits.condition
    if found.condition > limit:
        out.append(Finding(found.condition_line, POSE, "pose", "near a singularity: condition number of J",
                           f"{found.condition:.3g}", f"{limit:g}", found.condition / limit, found.condition_time,
                           ELSEWHERE))  # fmt: skip
    return sorted(out, key=lambda one: (one.kind != POSE, -one.use))  # no feed cures a pose: these first


def _warnings(motion, demand: Demand, found: Found) -> list[str]:
    """What ends no run: a pose outside the declared workspace, a poor condition number, limits that nobody gave."""
    machine, out = demand.machine, []
    if demand.unchecked:
        kinds = " and ".join(demand.unchecked)
        out.append(f"{machine.name} has no limit of its joints' {kinds}: not checked")
    if demand.unjudged:
        out.append(f"not in the forces told here: {', '.join(demand.unjudged)} of the plant")
    force = [u for u, kind in zip(found.top, demand.kinds, strict=True) if kind == FORCE]
    if force and _NEAR < max(force) <= 1:
        out.append(
            f"{100 * max(force):.0f} % of the drives' force are used: a control loop adds to it where the acceleration "
            "steps (--loop of an experiment tells how much)"
        )
    if machine.limits.condition_warning < found.condition <= machine.limits.condition:
        out.append(
            f"line {found.condition_line}: near a singularity: condition number of J {found.condition:.3g} "
            f"(warning from {machine.limits.condition_warning:g} on)"
        )
    if machine.limits.workspace is None:
        return out
    path, worst = motion.course.path, {}
    for share in (0.0, 0.5, 1.0):
        for k in range(0, len(path), _ROWS):
            block = np.arange(k, min(k + _ROWS, len(path)))
            still = np.zeros(len(block))
            here = state(motion, block, share * path.extent[block], still, still)
            margins = workspace_margins(machine, machine.standing(here.x))
            for c in np.flatnonzero((margins < 0).any(0)):
                i = int(np.nanargmin(margins[:, c]))
                if c not in worst or margins[i, c] < worst[c][0]:
                    worst[c] = (float(margins[i, c]), int(path.line[block[i]]))
    for c, (margin, line) in sorted(worst.items()):
        told = outside_workspace(machine, int(c), margin, f"line {line}" if line else None).problems[0]
        out.append(f"{told.where}: {told.rule}: {told.value} (declared {told.limit})")
    return out


def report(result: Preflight, most: int = 20) -> str:
    """The verdict, what is exceeded with the worst line first, and how near the rest comes."""
    drives = {
        CARTESIAN: "F as written, limits of the tool alone", JOINTS: "F as written, kept within the joints' limits"
    }[result.controller]  # fmt: skip
    lines = [f"{result.name} on {result.machine.name}: {result.duration:.2f} s ({drives})"]
    if result.size is not None:
        lines.append(result.size)
    if result.findings:
        lines.append(f"{_count(result.exceeded, 'limit')} exceeded, worst first:")
        shown = [(f.line, f.joint, f.what, f.value, f.limit, f.time, f.advice or "") for f in result.findings[:most]]
        last = "what to do"
    else:
        lines.append("no limit is exceeded; nearest to one:")
        shown = [(p.line, p.joint, p.what, p.value, p.limit, p.time, f"{100 * p.use:.1f} %") for p in result.peaks[:5]]
        last = "used"
    lines += _table(("line", "joint", "what", "value", "limit", "t / s", last), shown)
    if result.exceeded > most:
        lines.append(f"and {result.exceeded - most} more")
    return "\n".join([*lines, *(f"warning: {text}" for text in result.warnings)])


def _table(head, shown) -> list[str]:
    cells = [head] + [(str(row[0] or ""), *row[1:5], f"{row[5]:.3f}", row[6]) for row in shown]
    widths = [max(len(row[k]) for row in cells) for k in range(6)]
    right = (0, 3, 4, 5)
    return [
        "  ".join([*(row[k].rjust(w) if k in right else row[k].ljust(w) for k, w in enumerate(widths)), row[6]])
        for row in cells
    ]


def _count(n: int, what: str) -> str:
    return f"1 {what} is" if n == 1 else f"{n} {what}s are"
