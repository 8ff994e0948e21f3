"""Moves of an NC program as its lines say them: the words of a piece of a move, in the modes in force."""

from __future__ import annotations

import numpy as np

from ..program.blocks import ARC, REST
from ..program.ngc.arcs import PLANES
from ..program.ngc.modes import INCH, MM
from .nc_text import Written, feed_text, number_text
from .pieces import Piece
from .trace import Origin

_PLACES = {MM: 6, INCH: 8}  # decimals of lengths; 1 nm and below
_ROUND = {MM: "0.001", INCH: "0.00004"}  # what corners between pieces may be rounded by under G61.1


class MoveText:
    """Writes moves of a path in its own frame; `origins` of its blocks."""

    def __init__(self, path, origins: list[Origin]):
        self.path, self.origins = path, origins

    def feed_word(self, i: int, feed: float, extent: float) -> str:
        """F of `extent` m or rad of block i at `feed` m/s or rad/s."""
        modes = self.origins[i].modes
        if modes.inverse_time:
            return feed_text(60 * feed / extent, 6)
        if self.path.turning_at_rest[i]:
            return feed_text(60 * float(np.degrees(feed)), 6)
        return feed_text(60 * feed / modes.unit, 6)

    def divided(self, told: Written, i: int, pieces: list[Piece]) -> list[str]:
        """The lines of block i in several pieces."""
        path, modes, out, begin = self.path, self.origins[i].modes, [], 0.0
        at = self._coordinates(i, 0.0)
        end = self._coordinates(i, float(path.extent[i]))
        moved = [
            k for k in range(6) if abs(end[k] - at[k]) > 1e-12 or (path.kind[i] == ARC and k in PLANES[modes.plane][:2])
        ]
        code = "G1" if path.rapid[i] else f"G{modes.motion // 10}"
        for n, piece in enumerate(pieces):
            last = n == len(pieces) - 1
            here = end if last else self._rounded(self._coordinates(i, piece.end), modes)
            if last and modes.absolute:
                words = " ".join(told.of("XYZABC"))
            else:
                shown = here if modes.absolute else [b - a for a, b in zip(at, here, strict=True)]
                words = " ".join(self._axis(k, shown[k], modes) for k in moved)
            if path.kind[i] == ARC:
                words += " " + self._center(i, at, told, modes)
            head = f"{told.number}{code} " if n == 0 else ""
            feed = self.feed_word(i, piece.feed, piece.end - begin)
            if path.tolerance[i] < 0 and last:
                out.append("G61.1")
            out.append(f"{head}{words} {feed}")
            at, begin = here, piece.end
        return [f"G64 P{_ROUND[modes.unit]}", *out] if path.tolerance[i] < 0 else out

    def _coordinates(self, i: int, u: float) -> list[float]:
        """Program coordinates of block i at the extent u, m and rad."""
        path, block, along = self.path, np.array([i]), np.array([u])
        length = along if path.kind[i] != REST else np.zeros(1)
        pose = [*path.point(block, length)[0].tolist(), *path.angles(block, along)[0].tolist()]
        return self.origins[i].offsets.to_program(pose)

    @staticmethod
    def _rounded(place, modes) -> list[float]:
        d = _PLACES[modes.unit]
        lengths = [round(v / modes.unit, d) * modes.unit for v in place[:3]]
        return lengths + [float(np.radians(round(float(np.degrees(v)), 6))) for v in place[3:]]

    @staticmethod
    def _axis(k: int, value: float, modes) -> str:
        if k < 3:
            return f"{'XYZ'[k]}{number_text(value / modes.unit, _PLACES[modes.unit])}"
        return f"{'ABC'[k - 3]}{number_text(float(np.degrees(value)), 6)}"

    def _center(self, i: int, at, told: Written, modes) -> str:
        """The words of the centre of an arc, seen from its start at `at`."""
        path, letters = self.path, "IJK"
        if modes.absolute_center and told.of("IJK"):
            return " ".join(told.of("IJK"))
        arcs = path.batches[ARC]
        center = self.origins[i].offsets.to_program([*arcs.center[path.index[i]].tolist(), 0.0, 0.0, 0.0])
        base = [0.0] * 3 if modes.absolute_center else at
        return " ".join(
            f"{letters[k]}{number_text((center[k] - base[k]) / modes.unit, _PLACES[modes.unit])}"
            for k in sorted(PLANES[modes.plane][:2])
        )
