"""A scene on a viser server: nodes that are made once and moved after, so that a frame is a few hundred bytes.

Straight parts are cylinders of length 1, scaled and turned to where the machine says; closed ones (platform, base) are
plates.  Colours: a joint's force from blue (pulling, negative) over grey to red, the path by its contour error in the
colours of the report.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..report.style import ERROR_SCALE
from .scene import Scene

LOOKS = {  # colour and radius, in thousandths of the machine's size
    "base": ((74, 84, 94), 9), "platform": ((0, 114, 178), 9), "tool": ((213, 94, 0), 8), "rail": ((74, 84, 94), 6),
    "arm": ((74, 84, 94), 9), "carriage": ((74, 84, 94), 15), "slid": ((74, 84, 94), 15), "ram": ((213, 94, 0), 9),
}  # fmt: skip
PLAIN = ((141, 152, 163), 6)
PULL, REST, PUSH = np.array([33, 102, 172]), np.array([200, 205, 210]), np.array([178, 24, 43])


class Stage:
    """One scene as nodes of a viser server (or of what records one)."""

    def __init__(self, server: Any, scene: Scene):
        self.api, self.scene = server.scene, scene
        self.by_force = True
        self.up = _up(scene.machine)
        self.api.set_up_direction(tuple(self.up))
        self._ground()
        home = scene.at(0) or list(scene.points)
        self.nodes = [self._part(i, points) for i, points in enumerate(home)]
        self.thread = self._thread()
        self.driven = None
        self.magnify(scene.fitting)
        self.marks = [self._mark(i, mark) for i, mark in enumerate(scene.reversals)]
        self.show(0)

    def show(self, row: int) -> None:
        """Move the machine to a row of the log; where it cannot be drawn it stays."""
        points = self.scene.at(row)
        if points is None:
            return
        for part, nodes, at in zip(self.scene.parts, self.nodes, points, strict=True):
            if part.closed:
                nodes[-1].vertices = _plate(at)[0]
            for node, (start, end) in zip(nodes[: len(at) - 1], zip(at[:-1], at[1:], strict=True), strict=True):
                node.position, node.wxyz = (start + end) / 2, turned(end - start)
                node.scale = (1.0, 1.0, max(float(np.linalg.norm(end - start)), 1e-9))
            if part.joint is not None:
                colour = self.colour(part, row)
                for node in nodes[: len(at) - 1]:
                    node.color = colour

    def colour(self, part, row: int) -> tuple[int, int, int]:
        if part.joint is None or not self.by_force:
            return _look(part.name)[0]
        return force_colour(self.scene.u[row, part.joint] / self.scene.force)

    def magnify(self, times: float) -> None:
        """Draw the driven path with deviations `times` as large."""
        points = self.scene.magnified(times)
        colours = error_colours(self.scene.error[self.scene.path] / self.scene.largest_error)
        segments = np.stack([points[:-1], points[1:]], axis=1).astype(np.float32)
        pairs = np.stack([colours[:-1], colours[1:]], axis=1)
        if self.driven is not None:
            self.driven.remove()
        self.driven = self.api.add_line_segments(
            "/path/driven", segments, pairs, thickness=3.0, thickness_units="screen"
        )

    def mark(self, visible: bool) -> None:
        """Show or hide where joints reverse."""
        for node in self.marks:
            node.visible = visible

    # -- what is made once ----------------------------------------------------------------------------------------

    def _part(self, number: int, points: np.ndarray) -> list[Any]:
        part = self.scene.parts[number]
        colour, size = _look(part.name)
        radius, nodes = size * 1e-3 * self.scene.extent, []
        for k in range(len(points) - 1):
            nodes.append(
                self.api.add_cylinder(
                    f"/machine/{number}/{k}", radius=radius, height=1.0, color=colour, radial_segments=16
                )
            )
        if part.closed:
            vertices, faces = _plate(points)
            nodes.append(
                self.api.add_mesh_simple(
                    f"/machine/{number}/plate",
                    vertices,
                    faces,
                    color=colour,
                    opacity=0.35,
                    side="double",
                    cast_shadow=False,
                )  # fmt: skip
            )
        return nodes

    def _thread(self) -> Any:
        points = self.scene.programmed
        segments = np.stack([points[:-1], points[1:]], axis=1).astype(np.float32)
        return self.api.add_line_segments(
            "/path/programmed", segments, (150, 160, 170), thickness=1.0, thickness_units="screen"
        )

    def _mark(self, number: int, mark) -> Any:
        radius = 0.02 * max(float(np.ptp(self.scene.programmed, axis=0).max()), 1e-4)
        return self.api.add_icosphere(
            f"/reversals/{number}", radius=radius, color=(40, 46, 52), subdivisions=1, position=mark.place
        )

    def _ground(self) -> None:
        scene = self.scene
        corners = np.concatenate([*scene.points, scene.programmed])
        low, high = corners.min(0), corners.max(0)
        self.middle, self.size = (low + high) / 2, float(np.linalg.norm(high - low))
        axis = int(np.argmax(np.abs(self.up)))
        floor = np.where(np.arange(3) == axis, low if self.up[axis] > 0 else high, self.middle)
        cell = 10.0 ** np.floor(np.log10(max(scene.extent, 1e-3)))
        self.api.add_grid(
            "/ground", width=1.5 * scene.extent, height=1.5 * scene.extent, plane=("yz", "xz", "xy")[axis],
            cell_size=cell / 10, section_size=cell, cell_color=(226, 230, 234), section_color=(200, 206, 212),
            shadow_opacity=0.0, position=floor,
        )  # fmt: skip

    def camera(self) -> tuple[np.ndarray, np.ndarray]:
        """Where to look from, and at, to see the whole machine, (3,) m each."""
        axis = int(np.argmax(np.abs(self.up)))
        beside = np.roll([0.5 * self.up[axis], 0.72, -0.85], axis)  # up first, then the two that follow it
        return self.middle + 0.75 * self.size * beside, self.middle


def _up(machine: Any) -> np.ndarray:
    """The axis of W that points up: against gravity; z where there is none."""
    gravity = np.asarray(getattr(machine, "gravity", (0, 0, -9.81)), float)
    if not gravity.any():
        gravity = np.array([0, 0, -9.81])
    axis = int(np.argmax(np.abs(gravity)))
    return -np.sign(gravity[axis]) * np.eye(3)[axis]


def turned(direction: np.ndarray) -> np.ndarray:
    """Quaternion wxyz, (4,), that turns z to a direction (3,); the identity where there is none."""
    length = float(np.linalg.norm(direction))
    if length == 0:
        return np.array([1.0, 0, 0, 0])
    x, y, z = direction / length
    if z < -1 + 1e-12:
        return np.array([0.0, 1, 0, 0])
    q = np.array([1 + z, -y, x, 0.0])
    return q / np.linalg.norm(q)


def force_colour(share: float) -> tuple[int, int, int]:
    """Colour of a force as a share, -1 to 1, of the largest; grey where it is not finite."""
    share = float(np.clip(share, -1, 1)) if np.isfinite(share) else 0.0
    mixed = REST + abs(share) ** 0.7 * ((PUSH if share > 0 else PULL) - REST)
    return tuple(int(round(c)) for c in mixed)


def error_colours(share: np.ndarray) -> np.ndarray:
    """Colours (M, 3) uint8 of contour errors as shares, 0 to 1, of the largest, as the report's."""
    stops = np.array([place for place, _ in ERROR_SCALE])
    table = np.array([[int(text[i : i + 2], 16) for i in (1, 3, 5)] for _, text in ERROR_SCALE], float)
    share = np.clip(np.nan_to_num(share, nan=1.0), 0, 1)
    return np.stack([np.interp(share, stops, table[:, i]) for i in range(3)], axis=1).round().astype(np.uint8)


def _look(name: str):
    return next((look for key, look in LOOKS.items() if name.startswith(key)), PLAIN)


def _plate(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The surface inside a closed outline (k, 3), whose last point is its first: vertices and triangles."""
    ring = points[:-1]
    vertices = np.vstack([ring.mean(0), ring]).astype(np.float32)
    k = len(ring)
    faces = np.array([[0, 1 + i, 1 + (i + 1) % k] for i in range(k)], np.uint32)
    return vertices, faces
