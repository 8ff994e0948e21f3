"""Which parameters of a machine belong to one body, and what its pseudo-inertia is made of.

A body is found by its names: "platform.m", "platform.m cx", ..., "platform.Iyz" are one of ten numbers; m, m c and I
one that is slender (beside its Iaxial).  A mass or inertia that stands alone (a carriage's, a drive's) is a number
above 0.  Friction is no body's: a coefficient that is 0 may well be estimated a deviation below it.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from .cholesky import PAIRS, of_log_cholesky, of_pseudo_inertia

_MOMENTS = tuple(f"I{'xyz'[i]}{'xyz'[j]}" for i, j in PAIRS)
_FREE = "friction"


class Body(NamedTuple):
    """Some of the p parameters as J = U U', and back."""

    name: str
    places: tuple[int, ...]  # in the p parameters
    order: int  # of J: 4 a body, 2 a slender one, 1 a number above 0
    form: np.ndarray  # (len(places), order, order): pi[places][k] = sum of form[k] * J

    def basis(self) -> np.ndarray:
        """A with J = sum over k of A[k] pi[places[k]]; entries that no parameter gives are 0.  (k, order, order)."""
        entries = [(i, j) for i in range(self.order) for j in range(i, self.order)]
        system = np.array([[f[i, j] + (f[j, i] if i != j else 0.0) for i, j in entries] for f in self.form])
        out = np.zeros((len(self.places), self.order, self.order))
        for (i, j), row in zip(entries, np.linalg.pinv(system), strict=True):
            out[:, i, j] = out[:, j, i] = row
        return out

    def pseudo(self, pi) -> np.ndarray:
        """J of the parameters pi (p,).  (order, order)."""
        return np.tensordot(np.asarray(pi, float)[list(self.places)], self.basis(), 1)

    def least(self, pi) -> float:
        """The least eigenvalue of J, as a share of what its diagonal makes usual; above 0: the body can exist."""
        J = self.pseudo(pi)
        scale = np.sqrt(np.abs(np.diag(J)))
        scale[scale == 0] = 1.0
        return float(np.linalg.eigvalsh(J / scale / scale[:, None])[0])

    def made(self, lam) -> tuple[np.ndarray, np.ndarray]:
        """pi[places] of a lambda, and its derivatives.  (k,), (k, len(lambda))."""
        J, slope = of_log_cholesky(lam, self.order)
        return np.einsum("kij,ij->k", self.form, J), np.einsum("kij,lij->kl", self.form, slope)


def bodies_of(names: Sequence[str]) -> list[Body]:
    """The bodies and the single masses among the parameters; what may have any sign is in none."""
    index = {name: k for k, name in enumerate(names)}
    groups: dict[str, dict[str, int]] = {}
    for name, k in index.items():
        group, _, key = name.rpartition(".")
        groups.setdefault(group, {})[key] = k
    out = []
    for group, keys in groups.items():
        whole = _whole(group, keys) or _slender(group, keys)
        if whole is not None:
            out.append(whole)
        for key, k in keys.items():
            if not group.startswith(_FREE) and (whole is None or k not in whole.places):
                out.append(Body(f"{group}.{key}", (k,), 1, np.ones((1, 1, 1))))
    return out


def _whole(group: str, keys: dict[str, int]) -> Body | None:
    """A body of m, m c and the six inertias.  A strut's part may leave cx, cy out, and measures c along its axis."""
    if "m" not in keys or not all(key in keys for key in _MOMENTS):
        return None
    basis = np.zeros((10, 4, 4))  # the ten numbers as linear forms of J
    for i in range(4):
        for j in range(4):
            E = np.zeros((4, 4))
            E[i, j] = 1.0
            basis[:, i, j] = of_pseudo_inertia(E)
    basis = (basis + np.swapaxes(basis, 1, 2)) / 2
    along = -1.0 if group.endswith(".moving") else 1.0  # from B towards A: against the third axis
    wanted = [("m", 0, 1.0), ("m cx", 1, 1.0), ("m cy", 2, 1.0), ("m cz", 3, 1.0), ("m c", 3, along)]
    wanted += [(key, 4 + k, 1.0) for k, key in enumerate(_MOMENTS)]
    found = [(keys[key], sign * basis[row]) for key, row, sign in wanted if key in keys]
    return Body(group, tuple(k for k, _ in found), 4, np.array([form for _, form in found]))


def _slender(group: str, keys: dict[str, int]) -> Body | None:
    if not {"m", "m c", "I"} <= set(keys):
        return None
    forms = {"m": [[0, 0], [0, 1]], "m c": [[0, 0.5], [0.5, 0]], "I": [[1, 0], [0, 0]]}
    return Body(group, tuple(keys[key] for key in forms), 2, np.array(list(forms.values()), float))
