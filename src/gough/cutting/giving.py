"""What a machine with elastic joints gives way to the cut, to be added to what its tool does.

The cut F_x F_y F_z M_z of the frame C (force.py) acts at half the height of the wall, as in simulate/cut.py, eq. (1).
With C_T of machine/vibration.py, eq. (13), at the pose of the place, its motors held, the tool moves and turns by

    [d; r] = C_T w,   delta_m(z) = y . (d + r x z a) = delta_m + z psi,   delta_m = y . d,   psi = -x . r           (1)

and under a tool that leans by theta_t and goes back by R_a tan(theta_t) at its tip (deflection.py, eq. (1)) the whole
is (R_a tan(theta_t) + delta_m) - z (tan(theta_t) - psi).  Against it the command is moved and turned as eq. (1) of
compensation.py has it, but by

    theta = theta_t - psi,     delta = R_a tan(theta_t) + delta_m                                                   (2)

The rest is that of gravity; what the cut adds to it is taken as linear, and as slow: the mean force of the teeth, far
below the first mode.  Servos hold the motors, where their encoders are.
"""

from __future__ import annotations

import numpy as np

from ..errors import ExperimentError
from ..machine.vibration import tool_compliance
from ..program.blocks import REST
from ..program.path import Path
from .profile import frame

APART = 10e-3  # m of the path between poses whose compliance is asked for; straight lines between them
_NAMES = "xyzabc"


class Giving:
    """C_T along the part of a path between the places `first` and `last` m.

    `flexible` is a machine's `flexible()`, `path` as placed in W.

    Raises
    ------
    ExperimentError
        a machine whose coordinates are none of a pose.
    RunError
        the machine cannot rest on the path.
    """

    def __init__(self, flexible, path: Path, first: float, last: float):
        task = [name for name, _ in flexible.rigid.task]
        if not set(task) <= set(_NAMES):
            raise ExperimentError(
                "only of machines with coordinates x y z a b c can it be told", key="machine", value=flexible.name
            )
        self.path = path
        rests = path.s0[:-1][(path.kind == REST) & path.turning_at_rest]  # poses jump there, places do not
        inside = rests[(rests > first) & (rests < last)]
        self.s = np.unique(np.concatenate([
            np.linspace(first, last, max(2, int(np.ceil((last - first) / APART)) + 1)), inside - 1e-9, inside + 1e-9,
        ]))  # fmt: skip
        i, u = path.locate(self.s)
        u = np.minimum(u, path.extent[i])
        poses = np.concatenate([path.point(i, np.minimum(u, path.length[i])), path.angles(i, u)], 1)
        asked = poses[:, [_NAMES.index(name) for name in task]]
        self.compliance = np.array([tool_compliance(flexible, x) for x in asked])  # (k, 6, 6)

    def under(self, s, force, height: float) -> tuple[np.ndarray, np.ndarray]:
        """delta_m (n,) m and psi (n,) rad at places s (n,) m, eq. (1), under forces (n, 4) N, N m in C.

        `height` is that of the wall, R_a, m.
        """
        s, F = np.asarray(s, float), np.asarray(force, float)
        e = np.stack(frame(self.path, s), -1)  # (n, 3, 3): x y z of C as columns, in W
        f = np.einsum("nij,nj->ni", e, F[:, :3])
        axis = e[..., 2]
        w = np.concatenate([f, height / 2 * np.cross(axis, f) + F[:, 3:] * axis], 1)
        k = np.clip(np.searchsorted(self.s, s) - 1, 0, len(self.s) - 2)
        share = np.clip((s - self.s[k]) / (self.s[k + 1] - self.s[k]), 0, 1)[:, None, None]
        C = self.compliance[k] + share * (self.compliance[k + 1] - self.compliance[k])
        moved = np.einsum("nij,nj->ni", C, w)
        return (e[..., 1] * moved[:, :3]).sum(1), -(e[..., 0] * moved[:, 3:]).sum(1)
