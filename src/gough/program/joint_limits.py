"""Feeds that keep every joint below its greatest speed and acceleration.

With the joints q(u) along a block, g = dq/du and g' = d2q/du2,

    q' = g u',   q'' = g u'' + g' u'^2                                                                             (7)

so speed V and acceleration A of the feed keep the limits where, for every joint,

    |g| V <= speed,   |g| A + |g'| V^2 <= acceleration                                                             (8)

Blocks are cut into cells that g and g' hardly change in.  At first V is as large as leaves the share KEEP of the
joints' acceleration to A, and A takes all that V leaves.  Then the shares follow the profile: a cell that runs at its
V with acceleration to spare gives half of that to V, one that uses its A without coming to its V the other way round;
after a few profiles the fastest is kept.  At last it is sampled, finely and at the ends of all its parts; cells in
which a joint is too fast by the factor f are slowed by f (speed) and f or sqrt f (acceleration: A and V), and the
profile is made again, until no joint exceeds its limits.  docs/theory/feed.md, section 7.
"""

from __future__ import annotations

import numpy as np

from ..errors import ProgramError, WorkspaceError
from .path import Path
from .profiles.phases import Cells
from .tool_motion import tool_motion

KEEP = 0.3  # share of a joint's acceleration that is left for changes of the speed
_CELL = 1e-3  # m or rad
_MOST = 300_000  # cells more than blocks; with more, cells grow
_ROWS = 20_000  # asked of the machine at once
_PERIOD = 1e-3  # s, of the check
_NEAR = 0.5  # cells whose joints may come above this part of a limit are checked
_MARGIN = 1e-6  # what the limits are kept below by, so that rounding does not exceed them
_ROUNDS = 12  # of slowing down
_SHARES = 12  # of sharing out


class JointLimits:
    """The limits of a machine's joints along a path.

    Raises
    ------
    ProgramError
        a machine without limits.speed or limits.acceleration.
    """

    def __init__(self, path: Path, machine):
        self.path, self.machine = path, machine
        for name, example in (("speed", "18 m/min"), ("acceleration", "10 m/s2")):
            if getattr(machine.limits, name) is None:
                raise ProgramError(
                    f"joint_limits needs the {name} limit of the machine's joints", key="joint_limits",
                    cure=f'write {name} = "{example}" in [limits] of the machine',
                )  # fmt: skip
        self.speed = machine.limits.speed * (1 - _MARGIN)
        self.acceleration = machine.limits.acceleration * (1 - _MARGIN)

    def applied(self, feed, cells: Cells) -> None:
        """Make the profile of `feed` for the cells, slowed down until every joint keeps its limits.

        Raises
        ------
        ProgramError
            if slowing down does not lead there.
        """
        cells = self.cut(cells)
        if (cells.speed < self.most).any() or (cells.acceleration < self.hardest).any():
            cells = self.shared(feed, cells)
        for _ in range(_ROUNDS):
            feed.run(cells)
            fast, hard = self.excess(feed)
            if max(fast.max(), hard.max()) <= 1 + _MARGIN / 2:
                return
            cells = tightened(cells, fast, hard)
        block = int(feed.cells.block[np.argmax(np.maximum(fast, hard))])
        raise ProgramError(
            "the joints cannot keep their limits here", line=int(self.path.line[block]) or None,
            value=f"{max(fast.max(), hard.max()):.6g} times the limit",
            cure="leave joint_limits out, or change the path",
        )  # fmt: skip

    def shared(self, feed, cells: Cells) -> Cells:
        """The cells with each joint's acceleration shared out between V and A as the profile uses them."""
        g, h, most, hardest = self.g, self.h, self.most, self.hardest
        best, shortest = cells, np.inf
        for _ in range(_SHARES):
            feed.run(cells)
            if feed.duration < shortest:
                best, shortest = cells, feed.duration
            v, a = used(feed)
            V, A = cells.speed, cells.acceleration
            full, pushed = v >= 0.999 * V, a >= 0.999 * A
            with np.errstate(divide="ignore", invalid="ignore"):
                # at its speed and with acceleration to spare: half of that for V; the other way round: half of it for A
                A = np.where(full & ~pushed, (A + a) / 2, A)
                V = np.where(pushed & ~full, np.sqrt((V * V + v * v) / 2), V)
                fits = np.sqrt(((self.acceleration - g * A[:, None]) / h).min(1))
                V = np.where(full & ~pushed, np.minimum(most, fits), V)
                fits = ((self.acceleration - h * V[:, None] ** 2) / g).min(1)
                A = np.where(pushed & ~full, np.minimum(hardest, fits), A)
            cells = cells._replace(speed=V, acceleration=A)
        return best

    def cut(self, cells: Cells) -> Cells:
        """The cells cut short, each with a speed and an acceleration after (8)."""
        size = max(_CELL, cells.length.sum() / _MOST)
        count = np.maximum(np.ceil(cells.length / size - 1e-9).astype(int), 1)
        owner = np.repeat(np.arange(len(count)), count)
        part = np.arange(len(owner)) - np.repeat(np.cumsum(count) - count, count)
        length = cells.length[owner] / count[owner]
        stop = np.zeros(len(owner) + 1, bool)
        stop[np.concatenate([[0], np.cumsum(count)])] = cells.stop
        cut = Cells(
            cells.block[owner], cells.u[owner] + part * length, length,
            *(column[owner] for column in (cells.speed, cells.acceleration, cells.jerk, cells.pause)), stop,
        )  # fmt: skip
        moving = np.flatnonzero(length > 0)
        speed, acceleration = cut.speed.copy(), cut.acceleration.copy()
        self.most, self.hardest = cut.speed.copy(), cut.acceleration
        self.g, self.h = (np.zeros((len(owner), self.machine.joints_count)) for _ in range(2))
        for rows in np.array_split(moving, len(moving) // _ROWS + 1):
            g, h = self._gains(cut, rows)
            with np.errstate(divide="ignore"):
                self.g[rows], self.h[rows] = g, h
                self.most[rows] = np.minimum(speed[rows], self.speed / g.max(1))
                speed[rows] = V = np.minimum(self.most[rows], np.sqrt((1 - KEEP) * self.acceleration / h.max(1)))
                A = ((self.acceleration - h * V[:, None] ** 2) / g).min(1)
            acceleration[rows] = np.minimum(acceleration[rows], A)
        return cut._replace(speed=speed, acceleration=acceleration)

    def _gains(self, cells, rows):
        """Largest |g| and |g'| of each joint in the cells.  (n, joints) each.

        A parabola through both ends and the middle exceeds all three by an eighth of their second difference at most;
        a fifth is taken, for what is no parabola.
        """
        at = []
        for part in (0.0, 0.5, 1.0):
            u = cells.u[rows] + part * cells.length[rows]
            at.append(self._joints(cells.block[rows], u, np.ones(len(u)), np.zeros(len(u)))[1:])
        return tuple(
            np.max(np.abs([first, middle, last]), 0) + np.abs(first - 2 * middle + last) / 5
            for first, middle, last in zip(*at, strict=True)
        )

    def _joints(self, block, u, ud, udd):
        motion = tool_motion(self.path, block, u, ud, udd)
        x, xd, xdd = self.machine.task_motion(motion.x, motion.xd, motion.xdd)
        try:
            return self.machine.joint_motion(x, xd, xdd)
        except WorkspaceError:
            row, error = self.machine.unreachable(x)
            line = int(self.path.line[np.broadcast_to(block, len(x))[row]])
            raise error.at(where=f"NC line {line}" if line else "on the path") from None

    def excess(self, feed) -> tuple[np.ndarray, np.ndarray]:
        """By which factors a joint exceeds its speed and its acceleration in each cell.  (n,), (n,)."""
        fast, hard = np.zeros(len(feed.cells.length)), np.zeros(len(feed.cells.length))
        V, A = feed.cells.speed[:, None], feed.cells.acceleration[:, None]
        near = (self.g * V > _NEAR * self.speed) | (self.g * A + self.h * V**2 > _NEAR * self.acceleration)
        near = near.any(1)
        inside = 1e-9  # s: what is asked on both sides of an end
        ends = np.concatenate([feed.profile.phases.times, feed.profile.times])
        count = int(np.ceil(feed.duration / _PERIOD)) + 1
        for k in range(0, count, _ROWS):
            grid = np.arange(k, min(k + _ROWS, count)) * _PERIOD
            self._look(feed, near, grid, fast, hard)
        for some in np.array_split(ends, len(ends) // _ROWS + 1):
            self._look(feed, near, np.concatenate([some - inside, some + inside]), fast, hard)
        return fast, hard

    def _look(self, feed, near, t, fast, hard):
        cell = feed.cell(t)
        some = near[cell]
        if not some.any():
            return
        t, cell = t[some], cell[some]
        block, u, ud, udd, _ = feed.at(t)
        _, qd, qdd = self._joints(block, u, ud, udd)
        np.maximum.at(fast, cell, np.abs(qd).max(1) / self.speed)
        np.maximum.at(hard, cell, np.abs(qdd).max(1) / self.acceleration)


def tightened(cells: Cells, fast, hard) -> Cells:
    """The cells slowed by the factors that joints exceed their limits by."""
    fast, hard = np.maximum(fast, 1.0), np.maximum(hard, 1.0)
    # a little more than asked, or the last of the excess is halved for ever
    slower, softer = fast * np.sqrt(hard), hard
    slower, softer = (np.where(f > 1, f * (1 + _MARGIN / 2), 1.0) for f in (slower, softer))
    return cells._replace(speed=cells.speed / slower, acceleration=cells.acceleration / softer)


def used(feed) -> tuple[np.ndarray, np.ndarray]:
    """The largest speed and acceleration that the profile needs in each cell.  (n,), (n,).

    A trapezoid always goes to its limit and back; what it needs is what carries it from end to end of the cell.
    """
    phases, times, cells = feed.profile.phases, feed.profile.times, feed.cells
    # the speed is largest at the end of a phase or where a = 0, which is one; the acceleration at an end
    events = np.unique(np.concatenate([phases.times, times]))
    middle = (events[:-1] + events[1:]) / 2
    k, cell = phases.find(middle), feed.cell(middle)
    v, a = np.zeros(len(times) - 1), np.zeros(len(times) - 1)
    for t in (events[:-1], events[1:]):
        _, speed, acceleration, _ = phases.at(k, t)
        np.maximum.at(v, cell, speed)
        np.maximum.at(a, cell, np.abs(acceleration))
    ends = phases.at(phases.find(times), times)[1] ** 2
    net = np.abs(np.diff(ends)) / (2 * np.where(cells.length > 0, cells.length, 1.0))
    return v, np.where(np.isfinite(cells.jerk), a, net)
