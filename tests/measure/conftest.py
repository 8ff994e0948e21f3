"""A machine with one joint for each task coordinate: what the program asks is what the joints do."""

from types import SimpleNamespace

import numpy as np
import pytest


class Direct:
    """What a program asks of a machine."""

    home, joints_count = np.zeros(6), 6
    feed = SimpleNamespace(rapid=0.3, acceleration=2.0, jerk=50.0, angular_rate=1.0, angular_acceleration=5.0)

    task = ("x", "y", "z", "a", "b", "c")
    program_zero = property(lambda self: self.home)

    def task_motion(self, x, xd, xdd):
        return x, xd, xdd

    def joint_motion(self, x, xd, xdd, on_fail="raise"):
        return x, xd, xdd


@pytest.fixture
def machine():
    return Direct()
