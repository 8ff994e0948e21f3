"""The same equations on numbers of NumPy and on symbols of CasADi: the few functions that the two call differently."""

from __future__ import annotations

import numpy as np


class _Arrays:
    """NumPy under CasADi's names."""

    sin, cos, sqrt, floor, ceil = np.sin, np.cos, np.sqrt, np.floor, np.ceil
    acos, asin, fmin, fmax, fabs, if_else = np.arccos, np.arcsin, np.fmin, np.fmax, np.abs, np.where


ARRAYS = _Arrays


def sinc(xp, x):
    """sin(x) / x; below 1e-4 its series, whose next term is below 1e-18."""
    small = xp.fabs(x) < 1e-4
    whole = xp.if_else(small, 1.0, x)
    return xp.if_else(small, 1 - x * x / 6, xp.sin(whole) / whole)


def clip(xp, x, low, high):
    """x within [low, high]; a nan becomes `high`, never a nan that looks like a number."""
    return xp.fmax(xp.fmin(x, high), low)
