"""A machine with one joint for each task coordinate: what the program asks is what the joints do."""

from types import SimpleNamespace

import numpy as np
import pytest


@pytest.fixture
def machine():
    feed = SimpleNamespace(rapid=0.3, acceleration=2.0, angular_rate=1.0, angular_acceleration=5.0)
    return SimpleNamespace(home=np.zeros(6), feed=feed, joints_count=6, joint_motion=lambda x, xd, xdd: (x, xd, xdd))
