"""The path of the tool: blocks in order, each a segment the tool tip follows while a, b, c change in proportion.

A block knows its NC line, its feed and whether it is a rapid.  Its *extent* is what the feed runs along: the length of
its segment in m; for a turn about a resting tip the length of the change of (a, b, c) in rad; nothing for a dwell.
The path length s counts metres only.  Blocks are kept as arrays, so that a program of 100 000 lines stays small.

A path is written in the program's frame O and placed in W by `placed(p_WO, R_WO)`:  p_W = p_WO + R_WO p,
R_WT = R_WO R(abc).  The angles a b c stay those of the program; `pose_angles` gives those of R_WT.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from ..errors import ProgramError
from ..frames import abc_of_rotation_np, rotation_of_abc_np
from .blocks import ARC, REST, Block, Blocks, CircleOfPath
from .segments import dot, norm, rotated

_FULL = 2 * np.pi - 1e-6  # rad, a circle closed to the rounding of its end points
_SHORTEST = 1e-9  # m, as long as no machine can resolve: shorter moves have no direction


class Path:
    """Blocks in order as arrays; row i belongs to block i.

    kind, index     which batch holds the segment, and where        length, extent   (m,) m; m or rad
    s0              (m + 1,) path length at the start of each, and at the end
    abc0, turn      (m, 3) angles at the start, rad; their change per unit of extent
    feed rapid dwell line circle                                   circle: id, or 0
    tolerance tool spindle                                         as in Block
    """

    def __init__(self, blocks: Iterable[Block], circle_from: float = _FULL):
        """`circle_from`: from how many rad on arcs on one circle get a polar plot of their own.

        Raises
        ------
        ProgramError
            no blocks, a number that is not finite, a move without length, a gap between blocks, an arc without radius.
        """
        table = blocks if isinstance(blocks, Blocks) else Blocks(blocks)
        if not len(table):
            raise ProgramError("a path has at least one block")
        columns = table.columns()
        abc1 = columns.pop("abc1")
        self.__dict__.update(columns)
        change = abc1 - self.abc0
        self.p_WO, self.R_WO = np.zeros(3), np.eye(3)
        self._set(table.batches())
        resting = self.kind == REST
        self.extent = np.where(resting, norm(change), self.length)
        with np.errstate(divide="ignore", invalid="ignore"):
            self.turn = np.where((self.extent > 0)[:, None], change / self.extent[:, None], 0.0)
        self.turning_at_rest = resting & (self.extent > 0)
        self._check(abc1)
        self._direct_rests()
        self.circle, self._rounds = self._find_circles(circle_from)

    def _set(self, segments):
        self.batches = segments
        self.length = np.zeros(len(self.kind))
        for k, batch in enumerate(segments):
            rows = self.kind == k
            self.length[rows] = batch.length[self.index[rows]]
        self.s0 = np.concatenate([[0.0], np.cumsum(self.length)])

    def __len__(self):
        return len(self.kind)

    def _check(self, abc1):
        numbers = np.column_stack(
            [self.length, self.extent, self.turn, self.abc0, self.feed, self.dwell, self.tool, self.spindle]
        )
        wrong = np.flatnonzero(~np.isfinite(numbers).all(1))
        if len(wrong):
            raise ProgramError("a block must have finite numbers", line=self._line(wrong[0]))
        moves = self.kind != REST
        wrong = np.flatnonzero(moves & (self.length < _SHORTEST))
        if len(wrong):
            i = wrong[0]
            raise ProgramError("a move has no length", value=f"{self.length[i]:.3g} m", line=self._line(i))
        slow = np.flatnonzero(~self.rapid & (moves | self.turning_at_rest) & ~(self.feed > 0))
        if len(slow):
            raise ProgramError("the feed must be above 0", value=f"{self.feed[slow[0]]:g}", line=self._line(slow[0]))
        every = np.arange(len(self))
        first, last = self.point(every, np.zeros(len(self))), self.point(every, self.length)
        # with another tool the tip stands elsewhere while the machine stays: T is where it was
        changed = np.flatnonzero((self.tool[1:] != self.tool[:-1]).any(1))
        if len(changed):
            R_OT = rotation_of_abc_np(abc1[changed])
            last[changed] += rotated(R_OT, self.tool[changed] - self.tool[changed + 1])
        gap = norm(first[1:] - last[:-1])
        wrong = np.flatnonzero(~(gap <= 1e-9 + 1e-12 * np.abs(last[:-1]).max(1)))  # rounding of long paths
        if len(wrong):
            raise ProgramError(
                "a block must start where the last one ended",
                value=f"a gap of {gap[wrong[0]]:.3g} m",
                line=self._line(wrong[0] + 1),
            )
        jump = np.abs(self.abc0[1:] - abc1[:-1]).max(1, initial=0.0)
        if (jump > 1e-9).any():
            i = int(np.argmax(jump)) + 1
            raise ProgramError("a block must start with the angles the last one ended with", line=self._line(i))

    def _line(self, i):
        return int(self.line[i]) or None

    def _direct_rests(self):
        """Where the tip rests, the path still has a direction: the one it came with, at the start the one it takes."""
        rests = self.batches[REST]
        moves = np.flatnonzero(self.kind != REST)
        for i in np.flatnonzero(self.kind == REST):
            before = np.searchsorted(moves, i) - 1
            if len(moves):
                j = moves[before : before + 1] if before >= 0 else moves[:1]
                s = self.length[j] if before >= 0 else np.zeros(1)
                rests.direction[self.index[i]] = self.tangent(j, s)[0]

    def _find_circles(self, circle_from):
        """Consecutive arcs on one circle are one circle, if they turn by `circle_from` together."""
        circle, found = np.zeros(len(self), np.int16), []
        arcs, i = self.batches[ARC], 0
        while i < len(self):
            j = i + 1
            if self.kind[i] == ARC:
                a = self.index[i]
                sweep = arcs.sweep[a]
                while j < len(self) and self._same_circle(i, j):
                    sweep += arcs.sweep[self.index[j]]
                    j += 1
                if arcs.rise[a] == 0 and not self.rapid[i] and sweep >= circle_from and len(found) < 32_000:
                    found.append(i)
                    circle[i:j] = len(found)
            i = j
        return circle, found

    def _same_circle(self, i, j):
        arcs = self.batches[ARC]
        if self.kind[j] != ARC or self.feed[i] != self.feed[j] or self.rapid[j]:
            return False
        a, b = self.index[i], self.index[j]
        near = norm(arcs.center[a] - arcs.center[b]) < 1e-7 and abs(arcs.radius[a] - arcs.radius[b]) < 1e-7
        return bool(near and arcs.rise[a] == arcs.rise[b] == 0 and dot(arcs.normal[a], arcs.normal[b]) > 1 - 1e-12)

    @property
    def circles(self) -> list[CircleOfPath]:
        """The circles on the path, as placed."""
        arcs = self.batches[ARC]
        return [
            CircleOfPath(
                number + 1,
                int(self.line[i]),
                arcs.center[a],
                float(arcs.radius[a]),
                arcs.normal[a],
                float(self.feed[i]),
                bool(arcs.normal[a][2] > 0),
            )
            for number, i in enumerate(self._rounds)
            for a in [self.index[i]]
        ]

    # -- geometry: block numbers i (n,) and lengths u (n,) from the start of the block --------------------------

    def _ask(self, what, i, *rows):
        kinds = np.unique(self.kind[i])
        if len(kinds) == 1:
            return getattr(self.batches[kinds[0]], what)(self.index[i], *rows)
        out = None
        for k in kinds:
            at = np.flatnonzero(self.kind[i] == k)
            part = getattr(self.batches[k], what)(self.index[i[at]], *(row[at] for row in rows))
            out = np.empty((len(i),) + part.shape[1:]) if out is None else out
            out[at] = part
        return out

    def point(self, i, u):
        """Position in W.  (n, 3) m."""
        return self._ask("point", i, u)

    def tangent(self, i, u):
        """Unit tangent in W.  (n, 3).  At rest: the direction of the move before, or else behind."""
        return self._ask("tangent", i, u)

    def bend(self, i, u):
        """Curvature vector p'' in W, towards the centre.  (n, 3) 1/m."""
        return self._ask("bend", i, u)

    def closest(self, i, p, lo, hi, near):
        """Length in [lo, hi], from the start of block i, of its point closest to p.  (n,) m."""
        return self._ask("closest", i, p, lo, hi, near)

    def sharpest(self):
        """Largest curvature of each block.  (m,) 1/m."""
        return self._most("sharpest")

    def third(self):
        """Largest |p'''| of each block.  (m,) 1/m2."""
        return self._most("third")

    def _most(self, what):
        out = np.zeros(len(self))
        for k, batch in enumerate(self.batches):
            rows = self.kind == k
            out[rows] = getattr(batch, what)()[self.index[rows]]
        return out

    def locate(self, s):
        """Block and length in it for path lengths s (n,).  At a junction: the later block that moves."""
        i = np.searchsorted(self.s0, s, "right") - 1
        i = np.where(i < 0, 0, np.where(i > len(self) - 1, len(self) - 1, i))
        return i, s - self.s0[i]

    # -- orientation: the extent u travelled in block i --------------------------------------------------------

    def angles(self, i, u):
        """a b c of the program.  (n, 3) rad."""
        return self.abc0[i] + self.turn[i] * u[:, None]

    def angle_rate(self, i, u):
        """d(abc)/du.  (n, 3)."""
        return self.turn[i]

    def angle_bend(self, i, u):
        """d2(abc)/du2.  (n, 3)."""
        return np.zeros((len(i), 3))

    def turning(self):
        """Largest |w_k| and a bound of |w_k'| along each block, for w_k = E(abc) d(abc)/du.  (m,), (m,).

        |w_k|^2 = a'^2 + b'^2 + c'^2 - 2 a' c' sin b, and w_k' = a' (c' ez + b' e_b) x e_a + b' c' ez x e_b.
        """
        a, b, c = np.abs(self.turn).T
        first, last = self.abc0[:, 1], self.abc0[:, 1] + self.turn[:, 1] * self.extent
        steepest = np.floor(first / np.pi - 0.5) != np.floor(last / np.pi - 0.5)  # passes an odd multiple of 90 deg
        sine = np.where(steepest, 1.0, np.maximum(np.abs(np.sin(first)), np.abs(np.sin(last))))
        return np.sqrt(a * a + b * b + c * c + 2 * a * c * sine), a * c + a * b + b * c

    def rotation(self, abc):
        """R_WT for angles of the program.  (n, 3) -> (n, 3, 3)."""
        R_OT = rotation_of_abc_np(abc)
        return np.stack([rotated(self.R_WO, R_OT[..., :, j]) for j in range(3)], -1)

    def pose_angles(self, abc):
        """a b c of R_WT: the program's own where the frame is not turned, else on the branch next to them.  (n, 3)."""
        if np.array_equal(self.R_WO, np.eye(3)):
            return abc
        out = abc_of_rotation_np(self.rotation(abc))
        about = abc + abc_of_rotation_np(self.R_WO)
        return out + 2 * np.pi * np.round((about - out) / (2 * np.pi)) * np.array([1.0, 0.0, 1.0])

    def placed(self, p_WO, R_WO) -> Path:
        """The path with its frame O at p_WO (3,) m, turned by R_WO (3, 3), in W."""
        p_WO, R_WO = np.asarray(p_WO, float), np.asarray(R_WO, float)
        moved = object.__new__(Path)
        moved.__dict__.update(self.__dict__)
        moved._set([batch.placed(p_WO, R_WO) for batch in self.batches])
        moved.p_WO, moved.R_WO = p_WO + rotated(R_WO, self.p_WO), R_WO @ self.R_WO
        # the lengths are the program's: a rotation only rounds them
        moved.length, moved.s0 = self.length, self.s0
        return moved
