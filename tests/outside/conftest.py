"""Records with known truth: a circle of the PM-600, its readings and the forces of its own inverse dynamics."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pytest

import gough as gk
from gough.log.outside import Record, load_map

MAP = """\
schema = "gough-log-map-1"
[time]
column = "t"
period = "1 ms"
[joints]
columns = ["q1", "q2", "q3", "q4", "q5", "q6"]
unit = "mm"
[forces]
columns = ["u1", "u2", "u3", "u4", "u5", "u6"]
unit = "N"
"""
NAMES = ["t", *(f"q{i}" for i in range(1, 7)), *(f"u{i}" for i in range(1, 7))]


class Truth(NamedTuple):
    """The rows of a record, SI, and as its file has them: ms, mm, N."""

    t: np.ndarray
    q: np.ndarray
    u: np.ndarray

    @property
    def table(self) -> np.ndarray:
        return np.column_stack([self.t, self.q * 1e3, self.u])


@pytest.fixture(scope="session")
def okuma():
    return gk.load_machine("okuma-pm600")


@pytest.fixture(scope="session")
def truth(okuma):
    return circle(okuma, 400)


def circle(machine, n, radius=0.05, rate=2.0, wrench=None):
    """n samples of a circle of `radius` m at `rate` rad/s, under the forces it needs against `wrench` (n, 6)."""
    t = np.arange(n) * 1e-3
    c, s, zero = np.cos(rate * t), np.sin(rate * t), np.zeros(n)
    x = machine.home + radius * np.column_stack([c, s, zero, zero, zero, zero])
    xd = radius * rate * np.column_stack([-s, c, zero, zero, zero, zero])
    xdd = -radius * rate**2 * np.column_stack([c, s, zero, zero, zero, zero])
    return Truth(t, machine.inverse_kinematics(x), machine.inverse_dynamics(x, xd, xdd, wrench))


def csv_text(table, names=NAMES, delimiter=",", decimal=".", end="\n"):
    rows = [delimiter.join(repr(float(v)).replace(".", decimal) for v in row) for row in table]
    return end.join([delimiter.join(names), *rows]) + end


@pytest.fixture
def record(tmp_path, okuma):
    """`record(text_or_table, map_text=MAP)`: the Record of a CSV file, and all its samples joined."""

    def read(content, map_text=MAP, name="log.csv", machine=None):
        path = tmp_path / name
        if isinstance(content, np.ndarray):
            content = csv_text(content)
        if isinstance(content, str):
            content = content.encode()
        if content is not None:
            path.write_bytes(content)
        (tmp_path / "map.toml").write_text(map_text)
        found = Record(path, machine or okuma, load_map(tmp_path / "map.toml"))
        parts = list(found.parts())
        return found, Truth(*(np.concatenate([getattr(p, k) for p in parts]) for k in ("t", "q", "u"))), parts

    return read
