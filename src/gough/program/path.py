"""The path of the tool: blocks in order, each a segment the tool tip follows while a, b, c change in proportion.

A block knows its NC line, its feed and whether it is a rapid.  Its *extent* is what the feed runs along: the length of
its segment in m; for a turn about a resting tip the length of the change of (a, b, c) in rad; nothing for a dwell.
The path length s counts metres only.  Blocks are kept as arrays, so that a program of 100 000 lines stays small.

A path is written in the program's frame O and placed in W by `placed(p_WO, R_WO)`:  p_W = p_WO + R_WO p,
R_WT = R_WO R(abc).  The angles a b c stay those of the program; `pose_angles` gives those of R_WT.

Paths that are made rather than programmed (`Path.of`) may also hold curves, and blocks along which the angles are
polynomials of the extent.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from ..frames import abc_of_rotation_np, rotation_of_abc_np
from .blocks import CURVE, REST, Block, Blocks, CircleOfPath
from .curves import Curves
from .listing import listing
from .path_check import check
from .rounds import circles_of, find_circles
from .segments import norm, rotated
from .turns import Turns, linear_bounds

_FULL = 2 * np.pi - 1e-6  # rad, a circle closed to the rounding of its end points


class Path:
    """Blocks in order as arrays; row i belongs to block i.

    kind, index     which batch holds the segment, and where        length, extent   (m,) m; m or rad
    s0              (m + 1,) path length at the start of each, and at the end
    abc0, turn      (m, 3) angles at the start, rad; their mean change per unit of extent
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
        self._make(table.columns(), [*table.batches(), Curves(np.zeros((0, 6, 3)))])
        self.circle, self._rounds = find_circles(self, circle_from)

    @classmethod
    def of(cls, columns: dict, batches: list, bent: tuple | None = None, like: Path | None = None) -> Path:
        """A path of columns and batches, as Blocks has them, and Curves behind them; without circles.

        `bent` are angles that are polynomials: the rows (k,) of their blocks and coefficients (k, 6, 3), rad, by
        extent / length.  It is placed as the path `like` is.

        Raises
        ------
        ProgramError
            as above.
        """
        path = object.__new__(cls)
        path._make(dict(columns), batches, bent, like)
        path.circle, path._rounds = np.zeros(len(path), np.int16), []
        return path

    def _make(self, columns, batches, bent=None, like=None):
        abc1 = columns.pop("abc1")
        self.__dict__.update(columns)
        change = abc1 - self.abc0
        self.p_WO, self.R_WO = (np.zeros(3), np.eye(3)) if like is None else (like.p_WO, like.R_WO)
        self._set(batches)
        resting = self.kind == REST
        self.extent = np.where(resting, norm(change), self.length)
        with np.errstate(divide="ignore", invalid="ignore"):
            self.turn = np.where((self.extent > 0)[:, None], change / self.extent[:, None], 0.0)
        self.turning_at_rest = resting & (self.extent > 0)
        self.bent, self.turns = None, None
        if bent is not None and len(bent[0]):
            self.bent = np.full(len(self), -1)
            self.bent[bent[0]] = np.arange(len(bent[0]))
            self.turns = Turns(bent[1], self.extent[bent[0]])
        check(self, abc1)
        self._direct_rests()

    def _set(self, segments):
        self.batches = segments
        self.length = np.zeros(len(self.kind))
        for k, batch in enumerate(segments):
            rows = self.kind == k
            self.length[rows] = batch.length[self.index[rows]]
        self.s0 = np.concatenate([[0.0], np.cumsum(self.length)])

    def __len__(self):
        return len(self.kind)

    def __str__(self):
        return listing(self)

    def _direct_rests(self):
        """Where the tip rests, the path still has a direction: the one it came with, at the start the one it takes."""
        rests, moves = np.flatnonzero(self.kind == REST), np.flatnonzero(self.kind != REST)
        if len(rests) and len(moves):
            before = np.searchsorted(moves, rests) - 1
            j = moves[np.maximum(before, 0)]
            s = np.where(before >= 0, self.length[j], 0.0)
            self.batches[REST].direction[self.index[rests]] = self.tangent(j, s)

    @property
    def circles(self) -> list[CircleOfPath]:
        """The circles on the path, as placed."""
        return circles_of(self, self._rounds)

    # -- geometry: block numbers i (n,) and lengths u (n,) from the start of the block --------------------------

    def _ask(self, what, i, *rows):
        kinds = np.unique(self.kind[i])
        if len(kinds) <= 1:
            batch = self.batches[kinds[0] if len(kinds) else 0]
            return getattr(batch, what)(self.index[i], *rows)
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

    def frame(self, i, u):
        """Position, unit tangent and curvature vector, as the three above.  (n, 3) each."""
        curved = self.kind[i] == CURVE
        if not curved.any():
            return self.point(i, u), self.tangent(i, u), self.bend(i, u)
        if curved.all():
            return self.batches[CURVE].frame(self.index[i], u)
        out = tuple(np.empty((len(i), 3)) for _ in range(3))
        for rows in (np.flatnonzero(curved), np.flatnonzero(~curved)):
            for column, part in zip(out, self.frame(i[rows], u[rows]), strict=True):
                column[rows] = part
        return out

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
            if rows.any():
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
        return self._turned("value", self.abc0[i] + self.turn[i] * u[:, None], i, u)

    def angle_rate(self, i, u):
        """d(abc)/du.  (n, 3)."""
        return self._turned("rate", self.turn[i], i, u)

    def angle_bend(self, i, u):
        """d2(abc)/du2.  (n, 3)."""
        return self._turned("bend", np.zeros((len(i), 3)), i, u)

    def _turned(self, what, straight, i, u):
        if self.turns is None:
            return straight
        rows = np.flatnonzero(self.bent[i] >= 0)
        straight[rows] = getattr(self.turns, what)(self.bent[i[rows]], u[rows])
        return straight

    def turning(self):
        """Largest |w_k| and a bound of |w_k'| along each block, for w_k = E(abc) d(abc)/du.  (m,), (m,)."""
        rate, change = linear_bounds(self.abc0, self.turn, self.extent)
        if self.turns is not None:
            rows = np.flatnonzero(self.bent >= 0)
            bounds = self.turns.bounds()
            rate[rows], change[rows] = (bound[self.bent[rows]] for bound in bounds)
        return rate, change

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
