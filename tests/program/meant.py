"""Random NC programs, written together with what they mean: a second way to the path, without the reader's code."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

PLANES = {17: (0, 1, 2), 18: (2, 0, 1), 19: (1, 2, 0)}
KINDS = ("line", "arc", "helix", "rapid", "turn", "dwell", "mode", "tool", "inverse", "short", "tangent")


class Move(NamedTuple):
    """What one line of a program means, SI: from p0, abc0 to p1, abc1; `tolerance` of the junction behind it."""

    kind: str  # line, arc, turn or dwell
    line: int
    p0: np.ndarray
    p1: np.ndarray
    abc0: np.ndarray
    abc1: np.ndarray
    feed: float
    rapid: bool
    tolerance: float
    tool: float  # m, from the tip to T
    dwell: float = 0.0
    center: np.ndarray | None = None
    axes: np.ndarray | None = None  # rows: to the start, across, the normal
    radius: float = 0.0
    sweep: float = 0.0

    @property
    def length(self):
        if self.kind == "arc":
            return float(np.hypot(self.radius * self.sweep, self.axes[2] @ (self.p1 - self.p0)))
        return float(np.linalg.norm(self.p1 - self.p0))

    def at(self, share):
        """Positions (n, 3) at shares (n,) of the length."""
        share = np.asarray(share, float)[:, None]
        if self.kind != "arc":
            return self.p0 + share * (self.p1 - self.p0)
        angle = share * self.sweep
        rise = share * (self.axes[2] @ (self.p1 - self.p0))
        first, second, normal = self.axes
        return self.center + self.radius * (np.cos(angle) * first + np.sin(angle) * second) + rise * normal

    def abc(self, share):
        return self.abc0 + np.asarray(share, float)[:, None] * (self.abc1 - self.abc0)


def rotations(abc):
    """R = Rz(c) Ry(b) Rx(a), written out.  (n, 3) -> (n, 3, 3)."""
    (ca, cb, cc), (sa, sb, sc) = np.cos(abc.T), np.sin(abc.T)
    rows = [
        [cc * cb, cc * sb * sa - sc * ca, cc * sb * ca + sc * sa],
        [sc * cb, sc * sb * sa + cc * ca, sc * sb * ca - cc * sa],
        [-sb, cb * sa, cb * ca],
    ]
    return np.moveaxis(np.array(rows), 2, 0)


class Writer:
    """Writes lines and keeps what they mean; the tip is at `at`, mm, turned by `abc`, deg."""

    def __init__(self, seed, size=10.0, tilt=0.5):
        self.rng, self.size, self.tilt = np.random.default_rng(seed), size, tilt
        self.at, self.abc, self.head = np.zeros(3), np.zeros(3), np.array([1.0, 0, 0])
        self.feed, self.tolerance, self.arm = 1000.0, 0.0, 0.0
        self.lines, self.moves = ["G21 G90 G94 G17 F1000"], []

    def add(self, kind, text, p1, abc1, feed=0.0, rapid=False, **more):
        self.lines.append(text)
        move = Move(
            kind, len(self.lines), self.at * 1e-3, p1 * 1e-3, np.radians(self.abc), np.radians(abc1), feed, rapid,
            self.tolerance, self.arm * 1e-3, **more,
        )  # fmt: skip
        self.moves.append(move)
        if move.length:
            self.head = move.at([1.0])[0] - move.at([1 - 1e-6])[0]
            self.head /= np.linalg.norm(self.head)
        self.at, self.abc = p1, abc1

    def write(self, kind):
        if self.rng.random() < 0.3:
            self.feed = round(10 ** self.rng.uniform(2, 4.5), 3)
        if kind in ("arc", "helix"):
            self.arc(kind == "helix")
        elif kind in ("dwell", "turn", "mode", "tool"):
            getattr(self, kind)()
        else:
            self.line(kind)

    def mode(self):
        kind, tolerance = self.rng.integers(4), round(self.rng.uniform(0.005, 0.2), 6)
        self.lines.append(["G61", "G61.1", f"G64 P{tolerance}", f"G64 P{tolerance}"][kind])
        self.tolerance = [0.0, -1.0, tolerance * 1e-3, tolerance * 1e-3][kind]

    def dwell(self):
        wait = round(self.rng.uniform(0, 0.2), 3)
        self.add("dwell", f"G4 P{wait}", self.at, self.abc, dwell=wait)

    def tool(self):
        """T stays where it is; the tip of another tool is elsewhere."""
        arm = float(self.rng.choice([0.0, 20.0, 35.5]))
        if arm != self.arm:
            axis = rotations(np.radians(self.abc)[None])[0, :, 2]
            self.at, self.arm = self.at + axis * (self.arm - arm), arm
            self.add("dwell", f"G43.1 Z{arm}", self.at, self.abc)

    def turn(self):
        to = np.round(self.abc + self.rng.normal(size=3) * 6, 4)
        feed, rapid = round(10 ** self.rng.uniform(1.5, 4), 2), self.rng.random() < 0.3
        text = ("G0" if rapid else f"G1 F{feed}") + self.angles(to)
        self.add("turn", text, self.at, to, np.radians(feed) / 60, rapid)
        self.feed = self.feed if rapid else feed

    def angles(self, to):
        return "".join(f" {letter}{value:.4f}" for letter, value in zip("ABC", to, strict=True))

    def tilted(self):
        if self.rng.random() >= self.tilt / 2:
            return self.abc, ""
        to = np.round(self.abc + self.rng.normal(size=3) * 1.5, 4)
        return to, self.angles(to)

    def line(self, kind):
        rng, way = self.rng, self.rng.normal(size=3)
        if kind == "tangent":
            way = self.head + way * 10 ** rng.uniform(-4, -0.3)
        length = 10 ** rng.uniform(-4, -1) if kind == "short" else self.size * 10 ** rng.uniform(-1, 0.5)
        to = np.round(self.at + length * way / np.linalg.norm(way), 6)
        length = np.linalg.norm(to - self.at)
        if length < 1e-5:
            return
        abc, angles = self.tilted()
        words = "X{:.6f} Y{:.6f} Z{:.6f}".format(*to) + angles
        if kind == "rapid":
            self.add("line", f"G0 {words}", to, abc, rapid=True)
        elif kind == "inverse":
            rate = round(rng.uniform(1, 100), 4)
            self.add("line", f"G93 G1 {words} F{rate}", to, abc, length * 1e-3 * rate / 60)
            self.lines.append(f"G94 F{self.feed}")
        else:
            self.add("line", f"G1 {words} F{self.feed}", to, abc, self.feed * 1e-3 / 60)

    def arc(self, helix):
        rng = self.rng
        plane = int(rng.choice(list(PLANES)))
        i, j, k = PLANES[plane]
        sense = int(rng.choice([1, -1]))
        toward = rng.uniform(0, 2 * np.pi)
        if rng.random() < 0.5 and np.hypot(self.head[i], self.head[j]) > 0.3:  # goes on as the last move came
            toward = np.arctan2(self.head[j], self.head[i]) + sense * np.pi / 2
        radius = self.size * 10 ** rng.uniform(-1, 0.5)
        to_center = np.round(radius * np.array([np.cos(toward), np.sin(toward)]), 9)
        radius, angle = np.hypot(*to_center), np.arctan2(-to_center[1], -to_center[0])
        sweep, turns = rng.uniform(0.1, 2 * np.pi - 0.1), int(rng.choice([1, 2], p=[0.9, 0.1]))
        center, end = self.at.copy(), self.at.copy()
        center[[i, j]] += to_center
        if rng.random() < 0.1:
            sweep = 2 * np.pi
        else:
            end[[i, j]] = center[[i, j]] + radius * np.array(
                [np.cos(angle + sense * sweep), np.sin(angle + sense * sweep)]
            )
        end[k] += helix * rng.normal() * radius
        end = np.round(end, 9)
        axes = np.zeros((3, 3))
        axes[0, [i, j]] = np.cos(angle), np.sin(angle)
        axes[1, [i, j]] = -sense * np.sin(angle), sense * np.cos(angle)
        axes[2, k] = 1.0
        abc, angles = self.tilted()
        words = " ".join(f"{'XYZ'[n]}{end[n]:.9f}" for n in (i, j, k))
        words += f" {'IJK'[i]}{to_center[0]:.9f} {'IJK'[j]}{to_center[1]:.9f} P{turns}{angles} F{self.feed}"
        self.add(
            "arc", f"G{plane} G{2 if sense < 0 else 3} {words}", end, abc, self.feed * 1e-3 / 60,
            center=center * 1e-3, axes=axes, radius=radius * 1e-3, sweep=sweep + (turns - 1) * 2 * np.pi,
        )  # fmt: skip


def written(seed, n, kinds=KINDS, tilt=0.5, size=10.0):
    """The text of a program of about n lines and its moves."""
    writer = Writer(seed, size, tilt)
    for kind in ["mode", *writer.rng.choice(kinds, n), "line"]:
        writer.write(str(kind))
    return "\n".join([*writer.lines, "M2", ""]), writer.moves
