"""Base parameters: what a motion can show, with names a person can read.

Each column of the stacked regressor is multiplied by the size s of its parameter (its value, or what its body's mass
makes usual) and each row divided by the deviation of its noise, A = W Y S.  With A = U diag(sigma) V',

    the direction v_k of parameters is known to 1 / sigma_k, as a share of its size                                (1)

so a direction is shown where sigma_k > 1 / LIMIT: its deviation is less than half its size.  Without noise only
rounding limits: sigma_k > ROUNDING sigma_1.  A parameter whose own column is shorter than 1 / LIMIT is not shown,
whatever else is known.  Of the others the directions not shown, V_2 (p, p - r), say which parameters go together: one
parameter a direction is put into the others: of directions that no noise hides the last by name that weighs a tenth of
the heaviest, of the rest the heaviest.  With Q R the QR decomposition of the r columns A_1 kept, and A_2 the others,

    beta = R^-1 Q' A_2,   base = pi_1 + S_1 beta S_2^-1 pi_2                                                         (2)

Gautier and Khalil, IEEE Trans. Robotics and Automation 6(3), 1990; Gautier, J. Robotic Systems 8(4), 1991 (QR, SVD).
Theory: docs/theory/identification.md.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

LIMIT = 0.5  # of its size: a deviation beyond is no knowledge
ROUNDING = 1e-9  # of the largest singular value; those of rounding are 1e-15 of it, those of machines above 1e-5
_SHOWN = 1e-2  # of a size: what a name leaves out, and what leaves a parameter alone
_TERMS = 4  # that a name shows
_ZERO = 1e-12  # of a coefficient: rounding of eq. (2)
_TENTH = 0.1


@dataclass(frozen=True)
class BaseParameters:
    """The r combinations of p parameters that a motion shows."""

    names: tuple[str, ...]  # (r,) of the combinations
    units: tuple[str, ...]  # (r,)
    kept: np.ndarray  # (r,) columns that stand for them, rising
    K: np.ndarray  # (r, p): base = K pi; Y pi = Y[:, kept] base for what is shown
    seen: tuple[str, ...]  # (p,) "alone", "combined" or "not" for each parameter
    condition: float  # of the kept columns, scaled
    singular: np.ndarray  # (p,) of A, falling

    @property
    def rank(self) -> int:
        """r."""
        return len(self.kept)


def sizes(names: Sequence[str], units: Sequence[str], values, fallback) -> np.ndarray:
    """What each parameter is usually as large as.  (p,), above 0.

    Its value; for a first moment or inertia at least what its body's mass makes at the body's radius of gyration; and
    where nothing is known `fallback` (p,): what explains the whole force.
    """
    values = np.abs(np.asarray(values, float))
    mass = {name.rpartition(".")[0]: v for name, unit, v in zip(names, units, values, strict=True) if unit == "kg"}
    inertia: dict[str, float] = {}
    for name, unit, v in zip(names, units, values, strict=True):
        if unit == "kg m2":
            body = name.rpartition(".")[0]
            inertia[body] = max(inertia.get(body, 0.0), v)
    out = np.empty(len(values))
    for i, (name, unit) in enumerate(zip(names, units, strict=True)):
        body = name.rpartition(".")[0]
        usual = {"kg m2": inertia.get(body, 0.0), "kg m": np.sqrt(mass.get(body, 0.0) * inertia.get(body, 0.0))}
        out[i] = max(values[i], usual.get(unit, 0.0)) or fallback[i]
    return np.where(out > 0, out, 1.0)


def base_parameters(A, names: Sequence[str], units: Sequence[str], size, noise: bool = True) -> BaseParameters:
    """The base parameters of a scaled regressor A = W Y S (m, p), sizes S (p,); see the module.

    noise=False: A has no noise to be weighed against, only rounding limits (the machine itself, planned motions).
    """
    A, size = np.asarray(A, float), np.asarray(size, float)
    p = A.shape[1]
    if len(A) > p:  # the same singular values and columns, in few rows
        A = np.linalg.qr(A, mode="r")
    length = np.linalg.norm(A, axis=0)
    most = length.max(initial=0.0)
    least = max(1 / LIMIT if noise else 0.0, ROUNDING * most)
    live = np.flatnonzero(length > least)
    singular = np.zeros(p)
    kept, K, seen = np.zeros(0, int), np.zeros((0, p)), np.full(p, "not", object)
    condition = 1.0
    if len(live):
        _, s, Vt = np.linalg.svd(A[:, live], full_matrices=len(A) < len(live))
        singular[: len(s)] = s
        r = int((s > max(1 / LIMIT if noise else 0.0, ROUNDING * s[0])).sum())
        exact = int((s <= ROUNDING * s[0]).sum()) + len(live) - len(s)
        out = _joined(Vt[r:].T, exact)
        chosen, rest = np.delete(live, out), live[out]
        Q, R = np.linalg.qr(A[:, chosen])
        beta = np.linalg.solve(R, Q.T @ A[:, rest])
        beta[np.abs(beta) < _ZERO] = 0.0
        kept, K = chosen, np.zeros((r, p))
        K[np.arange(r), kept] = 1.0
        K[:, rest] = beta * size[kept, None] / size[rest]
        together = np.abs(beta) >= _SHOWN
        seen[kept] = np.where(together.any(1), "combined", "alone")
        seen[rest] = np.where(together.any(0), "combined", "not")
        kept_s = np.linalg.svd(A[:, kept], compute_uv=False)
        condition = float(kept_s[0] / kept_s[-1]) if r else 1.0
    combined = tuple(_name(K[i], k, names, size) for i, k in enumerate(kept))
    return BaseParameters(
        combined, tuple(units[k] for k in kept), kept, K, tuple(map(str, seen)), condition, singular
    )  # fmt: skip


def _joined(V2, exact: int) -> np.ndarray:
    """The rows of V2 (p, k) that are put into the others, one a column, rising; of the last `exact` by name."""
    strict, left, out = V2[:, V2.shape[1] - exact :], V2, []
    while left.shape[1]:
        weight = np.linalg.norm(strict if strict.shape[1] else left, axis=1)
        weight[out] = 0.0
        heavy = np.flatnonzero(weight >= _TENTH * weight.max())
        j = int(heavy[-1] if strict.shape[1] else np.argmax(weight))
        out.append(j)
        left, strict = _without(left, j), _without(strict, j)
    return np.sort(np.array(out, int))


def _without(V, j: int) -> np.ndarray:
    """The directions among V (p, k) that have no part of row j.  (p, k - 1)."""
    if not V.shape[1]:
        return V
    return V @ np.linalg.qr(V[j][:, None], mode="complete")[0][:, 1:]


def _name(row, k: int, names, size) -> str:
    """ "platform.m + 2.3 drive.m": the kept parameter first, then what goes with it, the weightiest first."""
    weight = np.abs(row) * size / size[k]
    others = [j for j in np.argsort(-weight, kind="stable") if j != k and weight[j] >= _SHOWN]
    text = names[k]
    for j in others[:_TERMS]:
        factor = f"{abs(row[j]):.3g}"
        text += f" {'+' if row[j] > 0 else '-'} {'' if factor == '1' else factor + ' '}{names[j]}"
    return text + (" + ..." if len(others) > _TERMS else "")
