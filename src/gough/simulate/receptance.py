"""What the tool gives way to a force on it while a law holds the machine: the dynamic compliance of the closed loop.

With s[k+1] = A s[k] + B_w w[k], d[k] = C s[k] of loop.py, a sample T, w the wrench on the tool held over a sample and d
[displacement; turn] of the tool when it is taken, both in W,

    H_s(f) = C (z - A)^-1 B_w / Z(f),   z = exp(i w T),   Z(f) = (1 - exp(-i w T)) / (i w T)                        (1)
    H(f)   = G(f) + H_s(f) - G_s(f)                                                                                 (2)

Z is what holding a force over a sample makes of it.  G is a free machine's response, eq. (15) of machine/vibration.py,
and G_s the same seen through samples as (1) sees it, from exp(A_c T): what sampling by itself feigns goes out, and of
the servo is left out only what it answers at other frequencies than it is asked at, f + n / T.  From `SHARE` / T on the
joints are taken as free: no sampled law holds anything there.  Below `LOW` / T, where G and G_s are large and alike, H
is H_s.
"""

from __future__ import annotations

import numpy as np

from ..machine import vibration
from ..machine.arrays import column
from . import law_tasks
from .loop import Loop
from .stability import choose_substeps

SHARE, LOW = 0.4, 2e-3  # of 1 / T
NEWTONS = 1.0  # of the differences; the machine is linear in a wrench but for what 1 N bends it, nm


def receptance(machine, law, frequencies, x=None, period: float = 1e-3, substeps: int | None = None) -> np.ndarray:
    """Eq. (2) of `law` on `machine` (a machine's `flexible()`) at rest at the pose x (d,), default home.

    frequencies (k,) Hz above 0.  (k, 6, 6) complex, m and rad by N and N m.

    Raises
    ------
    ExperimentError
        frequencies not above 0.
    """
    f = vibration.frequencies_of(frequencies)
    x = machine.home if x is None else column(x, len(machine.task), "pose")
    bound = law.on(machine.rigid, period)
    loop = Loop(machine, bound, period, substeps or choose_substeps(machine, period), x)
    A, B = loop.jacobians(inputs=False)[0], loop.pushed(NEWTONS)
    C = np.zeros((6, len(A)))
    small = vibration.small_motions(loop.machine, x)
    C[:, loop.rows["z"]] = small.W.T @ np.linalg.pinv(loop.S)
    T = law_tasks.cycle(bound, period)
    low = 2 * np.pi * f * T < 2 * np.pi * SHARE
    out = np.empty((len(f), 6, 6), complex)
    turn = 2j * np.pi * f[low] * T
    inner = np.linalg.solve(np.exp(turn)[:, None, None] * np.eye(len(A)) - A, np.broadcast_to(B, (low.sum(), *B.shape)))
    free = vibration.frequency_response(machine, x, f, source="tool", to="tool")
    out[~low] = free[~low]
    out[low] = C @ inner / _held(turn)[:, None, None]
    both = f[low] * T > LOW
    turn = turn[both]
    out[np.flatnonzero(low)[both]] += free[low][both] - _sampled(small, turn, T)
    return out


def _held(turn):
    """Z of eq. (1) at i w T."""
    return (1 - np.exp(-turn)) / turn


def _sampled(small, turn, T):
    """G_s of eq. (2) at i w T (k,).  (k, 6, 6)."""
    from scipy.linalg import expm

    m = len(small.M)
    whole = np.zeros((2 * m + 6, 2 * m + 6))
    whole[:m, m : 2 * m] = np.eye(m)
    whole[m : 2 * m] = np.linalg.solve(small.M, np.hstack([-small.K, -small.D, small.W]))
    step = expm(T * whole)
    A, B = step[: 2 * m, : 2 * m], step[: 2 * m, 2 * m :]
    inner = np.linalg.solve(np.exp(turn)[:, None, None] * np.eye(2 * m) - A, np.broadcast_to(B, (len(turn), *B.shape)))
    return small.W.T @ inner[:, :m] / _held(turn)[:, None, None]
