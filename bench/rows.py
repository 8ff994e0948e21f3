"""One million rows through kinematics and dynamics, from Python, on one core."""

from __future__ import annotations

import time

import numpy as np

import gough as gk
from gough.machine.workspace import random_poses

COUNT = 1_000_000
LIMITS = {"inverse kinematics": 0.15, "forward kinematics": 1.0, "inverse dynamics": 0.6}  # s; the aims of issue 4


class Rows:
    """Random poses of the workspace, twists, and the calls that are timed."""

    def __init__(self):
        machine, rng = gk.load_machine("nist-octahedral"), np.random.default_rng(0)
        few = random_poses(machine, 100_000, rng)
        x = np.tile(few, (COUNT // len(few), 1))
        # a little beside: no row is another's copy, and all stay inside the limits the search is checked against
        x[:, :2] *= rng.uniform(0.99, 1.0, (COUNT, 1))
        q = machine.inverse_kinematics(x)
        xd, xdd = rng.uniform(-1, 1, (2, COUNT, 6))
        u = machine.inverse_dynamics(x, xd, xdd)
        self.calls = {
            "inverse kinematics": lambda: machine.inverse_kinematics(x),
            "forward kinematics": lambda: machine.forward_kinematics(q),
            "inverse dynamics": lambda: machine.inverse_dynamics(x, xd, xdd),
            "forward dynamics": lambda: machine.forward_dynamics(x, xd, u),
            "Jacobian": lambda: machine.jacobian(x),
        }
        for call in self.calls.values():  # compiled, and the memory touched once
            call()

    def times(self) -> dict[str, float]:
        """CPU seconds of each call."""
        found = {}
        for name, call in self.calls.items():
            begun = time.process_time()
            call()
            found[name] = time.process_time() - begun
        return found
