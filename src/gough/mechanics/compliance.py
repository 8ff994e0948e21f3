"""Elastic joints: six-component stiffness and damping, and what elements in series make of them.

An infinitesimal displacement d = [dx dy dz, rx ry rz] at a joint, in the joint's frame, and its wrench F:

    F = K d + D d',   K symmetric, positive definite,   C = K^-1                                                    (1)

Massless elements in series carry one drive's force u as the wrenches P_j u; by virtual work they are one spring

    c = sum of P_j' C_j P_j,   k = 1 / c                                                                            (2)
    d = k^2 sum of P_j' E_j P_j,   E_j = C_j D_j C_j                                                                (3)

along that drive.  (3) is what the elements dissipate at one force, exact where D_j = beta K_j with one beta for all of
them (d = beta k), and to first order in the frequency where not.  docs/theory/compliance.md derives both.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import casadi as ca
import numpy as np
from pydantic import Field, model_validator

from ..declare import Array, Part, quantity
from ..errors import InputError, SheetError

_FORCE, _TURN = "N/m, N/m, N/m", "N m/rad, N m/rad, N m/rad"
_SYMMETRIC = 1e-9  # of the largest entry: what rounding in a sheet leaves


class Compliance(Part):
    """One elastic joint of a machine: an entry of [[compliance]]."""

    input_error = SheetError

    joint: str = Field(max_length=40, description='which, "strut 3"; "struts" for all of a kind')
    stiffness: float | Array | None = quantity(
        f"{_FORCE}, {_TURN}",
        "one: along the joint, or alike in all translations; three: translations; six: and rotations",
        default=None, shape=(-1,),
    )  # fmt: skip
    translation: Array | None = quantity(
        "N/m", "of a full stiffness: force by displacement", default=None, shape=(3, 3)
    )
    rotation: Array | None = quantity("N m/rad", "of a full stiffness: moment by turn", default=None, shape=(3, 3))
    coupling: Array | None = quantity(
        "N", "of a full stiffness: force by turn; none if left out", default=None, shape=(3, 3)
    )
    damping: float | Array | None = quantity(
        "N s/m, N s/m, N s/m, N m s/rad, N m s/rad, N m s/rad", "as many numbers as stiffness has", default=None,
        at_least=0, shape=(-1,),
    )  # fmt: skip
    beta: float | None = quantity("s", "damping in proportion: D = beta K", default=None, at_least=0, at_most=1)
    damping_ratio: float | None = quantity(
        "1", "the same, by its damping ratio at `frequency`", default=None, at_least=0
    )
    frequency: float | None = quantity("Hz", "where the damping has damping_ratio", default=None, above=0)
    center: Array | None = quantity(
        "m", "place of the spring from the joint, in the joint's frame", default=None, shape=(3,)
    )

    @model_validator(mode="after")
    def _sound(self):
        blocks = self.translation is not None or self.rotation is not None or self.coupling is not None
        if (self.stiffness is not None) == blocks:
            raise InputError(
                "needs one stiffness", key="stiffness",
                cure="give stiffness (1, 3 or 6 numbers), or translation and rotation (3 x 3 each)",
            )  # fmt: skip
        if blocks and (self.translation is None or self.rotation is None):
            missing = "translation" if self.translation is None else "rotation"
            raise InputError("is missing", key=missing, cure="translation and rotation belong together")
        count = np.size(self.stiffness) if self.stiffness is not None else 0
        if not blocks and count not in (1, 3, 6):
            raise InputError("has one, three or six numbers", key="stiffness", value=str(count))
        if self.damping is not None and (blocks or np.size(self.damping) != count):
            rule = "goes with stiffness alone" if blocks else f"needs as many numbers as stiffness has, {count}"
            raise InputError(rule, key="damping", cure="give beta, or damping_ratio and frequency")
        given = [key for key in ("damping", "beta", "damping_ratio") if getattr(self, key) is not None]
        if len(given) > 1:
            raise InputError(f"{given[0]} already says it", key=given[1], cure="leave one of them out")
        if (self.damping_ratio is None) != (self.frequency is None):
            missing = "frequency" if self.frequency is None else "damping_ratio"
            raise InputError("is missing", key=missing, cure="a damping ratio holds at a frequency: give both")
        check_stiffness(*self._matrix(), key="stiffness" if not blocks else "translation")
        return self

    def _matrix(self) -> tuple[np.ndarray, list[str]]:
        """The stiffness as a square matrix (1, 3 or 6) and the unit of each row's diagonal."""
        if self.stiffness is not None:
            K = np.diag(np.atleast_1d(self.stiffness))
        else:
            coupling = np.zeros((3, 3)) if self.coupling is None else self.coupling
            K = np.block([[self.translation, coupling], [coupling.T, self.rotation]])
        return K, (["N/m"] * 3 + ["N m/rad"] * 3)[: len(K)]

    @property
    def time(self) -> float | None:
        """beta of D = beta K, s; 0 without damping; None where `damping` says it otherwise."""
        if self.damping is not None:
            return None
        if self.damping_ratio is not None:
            return self.damping_ratio / (np.pi * self.frequency)  # zeta = beta w / 2
        return self.beta or 0.0

    def along(self) -> tuple[float, float]:
        """c m/N and e m/(N/s) = s m/N of eqs. (2), (3), of a joint with one direction.

        Raises
        ------
        InputError
            three or six numbers.
        """
        if np.size(self.stiffness if self.stiffness is not None else self.translation) != 1:
            raise InputError(
                f"{self.joint} gives way along itself only", key="stiffness", cure="give one number, in N/m"
            )
        c = 1 / float(np.ravel(self.stiffness)[0])
        e = c * self.time if self.damping is None else c * c * float(np.ravel(self.damping)[0])
        return c, e

    def matrices(self) -> tuple[np.ndarray, np.ndarray]:
        """C and E of eqs. (1), (3) of a joint with six components; what has no number is rigid.  (6, 6) each, SI."""
        K, _ = self._matrix()
        K = K[0, 0] * np.eye(3) if len(K) == 1 else K
        C, E = np.zeros((6, 6)), np.zeros((6, 6))
        n = len(K)
        C[:n, :n] = _inverse(K)
        if self.damping is None:
            return C, C * self.time
        D = np.diag(np.broadcast_to(np.atleast_1d(self.damping), n))
        E[:n, :n] = C[:n, :n] @ D @ C[:n, :n]
        return C, E

    def spring(self) -> tuple[np.ndarray, np.ndarray]:
        """K and D of eq. (1), (6, 6) each, SI.

        Raises
        ------
        InputError
            fewer than six numbers: the other components would be free to move without end.
        """
        K, _ = self._matrix()
        if len(K) != 6:
            raise InputError(
                f"{self.joint} gives way in six components", key="stiffness",
                cure="give six numbers, N/m and N m/rad; a rigid component gets a large one",
            )  # fmt: skip
        return K, np.diag(self.damping) if self.damping is not None else K * self.time


def check_stiffness(K: np.ndarray, units: list[str], key: str = "stiffness") -> None:
    """Refuse a stiffness that is not symmetric and positive definite.

    Raises
    ------
    InputError
        with the eigenvalue, of translations and rotations apart where nothing couples them.
    """
    if not np.allclose(K, K.T, rtol=0, atol=_SYMMETRIC * np.abs(K).max()):
        raise InputError("a stiffness must be symmetric", key=key, cure="give Kxy = Kyx and so on")
    # with the diagonal scaled to 1 the test hangs on no unit
    diagonal = np.diag(K)
    scale = 1 / np.sqrt(np.where(diagonal > 0, diagonal, 1))
    if (diagonal > 0).all() and np.linalg.eigvalsh(K * np.outer(scale, scale))[0] > 1e-12:
        return
    parts = [slice(0, 3), slice(3, 6)] if len(K) == 6 and not K[:3, 3:].any() else [slice(0, len(K))]
    least, unit = min((np.linalg.eigvalsh(K[part, part])[0], units[part][0]) for part in parts)
    told = f"{least:.4g} {unit}" if len(parts) == 2 or len(K) < 6 else f"{least:.4g} (SI)"
    raise InputError(
        "a stiffness must be positive definite: every eigenvalue above 0", key=key, value=f"least eigenvalue {told}",
        cure="check the signs and the size of what couples; leave a rigid joint out",
    )  # fmt: skip


def _inverse(K: np.ndarray) -> np.ndarray:
    found = np.linalg.inv(K)
    return (found + found.T) / 2


class Springs(Part):
    """All elastic joints of a machine whose drives are condensed, as numbers of theta; made by machine/flexible.py."""

    constant: Array = quantity("m/N", "compliance that meets every drive's force as it is, one a drive", shape=(-1,))
    constant_loss: Array | None = quantity("s m/N", "E of eq. (3) of the same", default=None, shape=(-1,))
    leg: Array | None = quantity("m/N", "compliance along each leg", default=None, shape=(-1,))
    leg_loss: Array | None = quantity("s m/N", "E of eq. (3) of the same", default=None, shape=(-1,))
    places: tuple[str, ...] = ()
    full: Array | None = quantity(
        "1", "C of eq. (1), SI, a row of 36 for each place and drive", default=None, shape=(-1, -1)
    )
    full_loss: Array | None = quantity("1", "E of eq. (3), SI, likewise", default=None, shape=(-1, -1))
    center: Array | None = quantity("m", "from joint to spring, a row of 3 likewise", default=None, shape=(-1, -1))


class Series(NamedTuple):
    """The springs along the drives."""

    compliance: Any  # c (n,) m/N
    loss: Any  # (n,) s m/N, sum of P' E P; None without damping


def in_series(springs, p, ratio, wrenches) -> Series:
    """Eqs. (2), (3) for n drives.

    `springs` is the Springs, `p` its view; `ratio` (n,) the force along each leg by its drive's; `wrenches(place)`
    gives the force at the joint (3, n) per newton and what the drive itself takes of it behind the joint (3, n), or
    None.
    """
    c, e = p.constant, p.constant_loss
    if springs.leg is not None:
        c = c + ratio * ratio * p.leg
    if springs.leg_loss is not None:
        e = ratio * ratio * p.leg_loss if e is None else e + ratio * ratio * p.leg_loss
    n = springs.constant.shape[0]
    for k, place in enumerate(springs.places):
        at_joint, taken = wrenches(place)
        rows = range(k * n, (k + 1) * n)
        P = []
        for i, row in enumerate(rows):
            F = at_joint[:, i]
            moment = ca.SX(3, 1) if springs.center is None else ca.cross(F, p.center[row, :].T)
            P.append(ca.vertcat(F if taken is None else F - taken[:, i], moment))

        def quadratic(table, P=P, rows=rows):
            return ca.vertcat(*[P[i].T @ ca.reshape(table[row, :], 6, 6) @ P[i] for i, row in enumerate(rows)])

        c = c + quadratic(p.full)
        if springs.full_loss is not None:
            found = quadratic(p.full_loss)
            e = found if e is None else e + found
    return Series(c, e)
