"""How surely a force on the tool is told from the drives, by pose.

The drives' forces hold w = -J' du against what is believed of them; if each of n joints is off by e_i with deviation
sigma_i, none knowing of the others, the wrench is off with covariance

    C = J' diag(sigma^2) J                                                                                          (1)

An ellipsoid of one deviation of its force has the half axes sqrt of the eigenvalues of C_ff (3 x 3), and one of its
moment about the tip those of C_mm.  Near a singular pose J loses a direction: there some wrench moves no joint and
cannot be told, however small sigma is.  Not C shows that but the condition number of J, which is given beside it and
flagged beyond that of the machine's own warning.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..errors import ExperimentError
from ..machine.workspace import condition


class Uncertainty(NamedTuple):
    """Of poses (...): one deviation of the wrench."""

    covariance: np.ndarray  # (..., 6, 6) N2, N2 m, N2 m2
    force_axes: np.ndarray  # (..., 3) N, half axes of the force's ellipsoid, falling
    force_directions: np.ndarray  # (..., 3, 3) columns: their directions in W
    moment_axes: np.ndarray  # (..., 3) N m, falling
    condition: np.ndarray  # (...) of J, its rotations scaled by the platform's radius
    poor: np.ndarray  # (...) bool: the condition is beyond the machine's warning


def wrench_uncertainty(machine, x, deviation) -> Uncertainty:
    """One deviation of the wrench at poses x (..., 6), for joint forces off by `deviation`, one or (n,) N, eq. (1).

    Raises
    ------
    ExperimentError
        a machine with fewer than six freedoms, a deviation that is none.
    """
    if len(machine.task) < 6:
        raise ExperimentError(
            "only a machine with six freedoms tells all of a wrench", key="machine", value=machine.name
        )
    sigma = np.broadcast_to(np.asarray(deviation, float), (machine.joints_count,))
    if not (np.isfinite(sigma).all() and (sigma >= 0).all()):
        raise ExperimentError("must be finite and at least 0 N", key="deviation", value=str(deviation)[:60])
    J = machine.jacobian(x)
    C = np.swapaxes(J, -1, -2) @ (sigma[:, None] ** 2 * J)
    values, vectors = np.linalg.eigh(C[..., :3, :3])
    moments = np.linalg.eigvalsh(C[..., 3:, 3:])
    force_axes, moment_axes = (np.sqrt(np.maximum(v[..., ::-1], 0.0)) for v in (values, moments))
    number = condition(machine, J)
    return Uncertainty(
        C, force_axes, vectors[..., ::-1], moment_axes, number, number > machine.limits.condition_warning
    )
