"""Overshoot: how far a joint runs past the place where its reference has come to rest.

    o = max of (q - q_r) sign(q_r' when it last moved), over all samples in which |q_r'| <= 1 um/s                 (1)

What lags is no overshoot, and before the reference has moved there is none.  Of a reference that never rests behind a
motion (a program that ends on the last sample of its path) nothing is measured.
"""

from __future__ import annotations

import numpy as np

from .reversal import AT_REST, carried


class OvershootMeter:
    """Takes samples in chunks of any size.  `largest` is o of eq. (1), m, at least 0; None before a reference rests."""

    def __init__(self):
        self.largest: float | None = None
        self._sign = None

    def update(self, q_r, qd_r, q) -> None:
        """The next n samples: (n, joints), m and m/s."""
        qd_r = np.asarray(qd_r, float)
        if not len(qd_r):
            return
        if self._sign is None:
            self._sign = np.zeros(qd_r.shape[1])
        resting = np.abs(qd_r) <= AT_REST
        sign = carried(np.concatenate([self._sign[None], np.where(resting, 0.0, np.sign(qd_r))]))[1:]
        self._sign = sign[-1].copy()
        looked_at = resting & (sign != 0)
        if looked_at.any():
            found = float(np.max(((np.asarray(q, float) - q_r) * sign)[looked_at]))
            # a NaN stays: what is not known is not called small
            self.largest = float(np.maximum(self.largest or 0.0, found))
