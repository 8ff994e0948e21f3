"""Synthetic logs: a circle, a diamond and a square on a hexapod, with errors of a plausible kind.

Not a simulation: the errors are written down (friction peaks at reversals, corners, noise), so that a test knows them.
"""

from __future__ import annotations

import numpy as np
import pytest

from gough.log import Log

TASK = (("x", "m"), ("y", "m"), ("z", "m"), ("a", "rad"), ("b", "rad"), ("c", "rad"))
HOME_Z = -1.0
RADIUS = 0.1
FEED = 0.05  # m/s


def hexapod(x):
    """Strut lengths of a hexapod hanging under its base.  (n, 6) -> (n, 6), and the joints at home."""
    angle = np.deg2rad([0, 0, 120, 120, 240, 240]) + np.deg2rad([-8, 8] * 3)
    base = np.c_[0.75 * np.cos(angle), 0.75 * np.sin(angle), np.zeros(6)]
    angle = np.deg2rad([-60, 60, 60, 180, 180, 300]) + np.deg2rad([8, -8] * 3)
    platform = np.c_[0.28 * np.cos(angle), 0.28 * np.sin(angle), np.full(6, 0.4)]
    q = np.linalg.norm(x[:, None, :3] + platform - base, axis=2)
    return q, base, platform + [0, 0, HOME_Z]


def polygon(corners):
    """(position, corner distance) along a closed polygon, sampled at 1 kHz and FEED."""
    out = []
    for a, b in zip(corners, corners[1:] + corners[:1], strict=True):
        a, b = np.array(a), np.array(b)
        n = int(np.linalg.norm(b - a) / FEED * 1000)
        s = np.arange(n)[:, None] / n
        out.append(a + s * (b - a))
    return np.concatenate(out)


def path(seconds, rate):
    """Reference of the tool tip (n, 3), circle number (n,), line (n,)."""
    n = int(2 * np.pi * RADIUS / FEED * 1000)
    phi = np.arange(n) / n * 2 * np.pi
    circle = RADIUS * np.c_[np.cos(phi), np.sin(phi)]
    back = circle[::-1]
    diamond = polygon([(0.1, 0.0), (0.0, 0.1), (-0.1, 0.0), (0.0, -0.1)])
    square = polygon([(0.1, 0.0), (0.1, 0.1), (-0.1, 0.1), (-0.1, -0.1), (0.1, -0.1)])
    parts = [circle, back, diamond, square]
    xy = np.concatenate(parts)
    number = np.concatenate([np.full(len(part), i + 1 if i < 2 else 0) for i, part in enumerate(parts)])
    line = np.concatenate([np.full(len(part), 12 + 3 * i) for i, part in enumerate(parts)])
    index = np.minimum((np.arange(int(seconds * rate)) * (1000 / rate)).astype(int), len(xy) - 1)
    return np.c_[xy[index], np.full(len(index), HOME_Z)], number[index], line[index]


def make_log(kind="pid", scale=4e-6, seed=0, seconds=60.0, rate=1000, failed="", program_name="circle-diamond.ngc"):
    rng = np.random.default_rng(seed)
    p, number, line = path(seconds, rate)
    n = len(p)
    t = np.arange(n) / rate
    x_r = np.c_[p, np.zeros((n, 3))]
    q_r, base, platform = hexapod(x_r)
    qd = np.gradient(q_r, 1 / rate, axis=0) if n > 1 else np.zeros((n, 6))
    glitch, reversals = np.zeros(n), []
    for joint in range(6):
        for k in np.flatnonzero(np.diff(np.sign(qd[:, joint])) != 0):
            since = t - t[k]
            since = np.where((since > 0) & (since < 0.3), since, 0)
            glitch += 60 * since * np.exp(-since / 0.03) * scale
            reversals.append({"time": t[k], "joint": joint, "glitch": 2.5 * scale * (1 + 0.1 * joint)})
    along = np.unwrap(np.arctan2(p[:, 1], p[:, 0]))
    signed = scale * (1 + 0.6 * np.cos(2 * along)) + glitch + 0.15 * scale * rng.standard_normal(n)
    error = np.abs(signed)
    outward = np.c_[np.cos(along), np.sin(along), np.zeros(n)]
    x = x_r.copy()
    x[:, :3] += signed[:, None] * outward
    q = hexapod(x)[0]
    counted = np.ones(n, np.int8)
    counted[: n // 60] = counted[n - n // 30 :] = 0
    u = 350 + 900 * (q_r - 0.85) + 40 * np.sign(qd) + 2 * rng.standard_normal((n, 6))
    kept = np.flatnonzero(counted)
    worst = kept[np.argmax(error[kept])] if len(kept) else 0
    lag = 3 * scale * np.ones(n)
    metrics = None
    if len(kept):
        metrics = {
            "contour_error": {
                "max": error[worst],
                "rms": np.sqrt(np.mean(error[kept] ** 2)),
                "mean": error[kept].mean(),
                "at": t[worst],
                "line": line[worst],
            },
            "orientation_error": {"max": 8 * scale, "rms": 3 * scale, "mean": 2 * scale, "at": t[worst], "line": 15},
            "lag": {"max": 3 * scale, "rms": 3 * scale},
            "tracking": {"max": [5 * scale] * 6, "rms": [2 * scale] * 6},
            "reversals": {"count": len(reversals), "largest": 2.5 * scale * 1.5},
            "strut_force": {"peak": np.abs(u).max()},
            "strut_velocity": {"peak": np.abs(qd).max()},
            "saturated": 0.0025,
            "samples": n,
            "counted": len(kept),
        }
    info = {
        "version": "0.1.0",
        "versions": {"numpy": np.__version__, "casadi": "3.8.2", "python": "3.11.2"},
        "machine": {"name": "test-hexapod", "platform": {"mass": "150.0 kg"}, "joints": {"base": base.tolist()}},
        "machine_name": "test-hexapod",
        "controller": {"bandwidth": "20.0 Hz"},
        "controller_kind": kind,
        "program": {"name": program_name, "kind": "gcode", "text": "(circle, diamond, square)\nG21 G90 G17\n" * 12},
        "plant": {"friction.coulomb": "1.2 x"},
        "run": {"period": 1 / rate, "substeps": 4, "seed": seed},
        "hashes": {"program": "ab" * 32, "machine": "cd" * 32},
        "wall_time": 1.25,
        "simulated_time": seconds,
        "metrics": metrics,
        "circles": [
            {
                "id": i + 1,
                "line": 12 + 3 * i,
                "center": [0, 0, HOME_Z],
                "radius": RADIUS,
                "normal": [0, 0, 1],
                "feed": FEED,
                "ccw": i == 0,
            }
            for i in range(2)
            if (number == i + 1).any()
        ],
        "drawing": [
            {"name": "base", "points": np.vstack([base, base[:1]])},
            {"name": "platform", "points": np.vstack([platform, platform[:1]])},
            *({"name": f"strut {i + 1}", "points": [base[i], platform[i]]} for i in range(6)),
            {"name": "tool", "points": [platform.mean(0), [0, 0, HOME_Z]]},
        ],
        "reversals": reversals,
        "processor": "test",
    }
    values = {
        "x_r": x_r,
        "x": x,
        "q_r": q_r,
        "q": q,
        "q_m": q + 1e-7 * rng.standard_normal(q.shape),
        "u_c": u,
        "u": u,
        "saturated": np.abs(u) > 420,
        "line": line,
        "counted": counted,
        "block": line - 11,
        "s_r": FEED * t,
        "contour_error": error,
        "orientation_error": 2 * error,
        "lag": lag,
        "circle": number,
        "radial_error": np.where(number > 0, signed, 0),
        "controller.integral": 0.1 * u,
        "controller.count": t * rate,
        "plant.quaternion": np.tile([1.0, 0, 0, 0], (n, 1)),
    }
    return Log.build(t, values, task=TASK, joints=6, info=info, status="failed" if failed else "done", reason=failed)


@pytest.fixture(scope="session")
def logs():
    return [make_log("pid"), make_log("computed_torque", 1.2e-6, 1)]


@pytest.fixture(scope="session")
def short():
    """A log of 3 s at 100 Hz, for tests that write many files."""
    return make_log("pid", seconds=3.0, rate=100)
