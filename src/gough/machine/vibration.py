"""Small motions about rest of a machine with elastic joints: stiffness at the tool, modes, frequency responses.

With d the displacement that belongs to the velocities v, at the rest z_0, u_0 of equilibrium.py:

    M d'' + D d' + K d = J' du + W w,   K = -F_z S,   D = h_v,   W = d(wrench on v) / dw                            (11)
    q_m = Q d,   tool: W' d = [displacement; turn] of T, in W                                                       (12)

all of them derivatives of the very equations that the plant steps.  K holds the geometric stiffness of gravity and of
the forces in the legs.  With the joints held d = N y, J N = 0:

    C_T = W' N (N' K N)^-1 N' W                                 compliance of the tool, (6, 6)                      (13)
    (s^2 N' M N + s N' D N + N' K N) y = 0                      modes                                               (14)
    G(s) = [Q; W'] (s^2 M + s D + K)^-1 [J' W]                  frequency response, the joints free                 (15)

docs/theory/compliance.md, section 4.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import casadi as ca
import numpy as np

from ..declare import Shape
from ..errors import ExperimentError, RunError
from ..kernel.building import BUILDING
from ..quantities import brief
from .equilibrium import at_rest, pose_of, static_force, unmoved


class Small(NamedTuple):
    """Eqs. (11), (12) at one rest, in SI."""

    M: np.ndarray  # (m, m)
    D: np.ndarray  # (m, m)
    K: np.ndarray  # (m, m)
    J: np.ndarray  # (n, m) joints by d
    Q: np.ndarray  # (n, m) readings by d
    W: np.ndarray  # (m, 6) forces on v by the wrench on the tool
    z: np.ndarray
    u: np.ndarray  # (n,) N


class Modes(NamedTuple):
    """Natural frequencies from the lowest, Hz, their damping ratios, and their shapes."""

    frequency: np.ndarray  # (k,) Hz, of the undamped machine's turn where damped: |s| / 2 pi
    damping: np.ndarray  # (k,) 1, -Re s / |s|
    shape: np.ndarray  # (m, k) complex: velocities of the machine, largest entry 1
    tool: np.ndarray  # (6, k) complex: [displacement m; turn rad] of T, in W, of that shape


def small_motions(machine, x, wrench=None) -> Small:
    """Eqs. (11), (12) at rest with the joints where the rigid machine has the pose x (d,)."""
    z, u = at_rest(machine, x, wrench)
    found = _functions(Shape(machine))(machine.theta, z, u, np.zeros(6) if wrench is None else wrench)
    return Small(*(np.array(one) for one in found), z, u)


def tool_compliance(machine, x, wrench=None) -> np.ndarray:
    """C_T of eq. (13): [displacement; turn] of the tool tip by [f; m] on it, in W, SI.  (6, 6)."""
    return _compliance(small_motions(machine, x, wrench))


def _compliance(one: Small) -> np.ndarray:
    N = unmoved(one.J)
    return one.W.T @ N @ np.linalg.solve(N.T @ one.K @ N, N.T @ one.W)


def modes(machine, x, held: bool = True, wrench=None) -> Modes:
    """Eq. (14), or with the joints free: what oscillates, without what drifts or creeps."""
    return _modes(small_motions(machine, x, wrench), held)


def _modes(one: Small, held: bool) -> Modes:
    N = unmoved(one.J) if held else np.eye(len(one.M))
    M, D, K = (N.T @ part @ N for part in (one.M, one.D, one.K))
    k = len(M)
    A = np.block([[np.zeros((k, k)), np.eye(k)], [-np.linalg.solve(M, K), -np.linalg.solve(M, D)]])
    s, vectors = np.linalg.eig(A)
    # rounding leaves some sqrt(1e-16) of the largest pole where a joint is free to drift
    kept = np.flatnonzero((s.imag >= 0) & (np.abs(s) > 1e-6 * np.abs(s).max()) & (s.imag > 1e-9 * np.abs(s)))
    kept = kept[np.argsort(np.abs(s[kept]))]
    shape = N @ vectors[:k, kept]
    if shape.size:
        shape = shape / shape[np.abs(shape).argmax(0), np.arange(len(kept))]
    return Modes(np.abs(s[kept]) / (2 * np.pi), -s[kept].real / np.abs(s[kept]), shape, one.W.T @ shape)


_SOURCES, _TARGETS = ("motor", "tool"), ("encoder", "tool")


def frequency_response(machine, x, frequencies, source: str = "motor", to: str = "tool", wrench=None) -> np.ndarray:
    """Eq. (15), from the drives' forces (n, N) or the wrench on the tool (6, N and N m) to the encoders (n, m) or the
    tool (6, m and rad, in W), at `frequencies` (k,) Hz above 0, the joints free.  (k, outputs, inputs) complex.

    Raises
    ------
    ExperimentError
        no such source or target; frequencies not above 0.
    """
    for key, value, known in (("source", source, _SOURCES), ("to", to, _TARGETS)):
        if value not in known:
            raise ExperimentError(f'must be "{known[0]}" or "{known[1]}"', key=key, value=brief(value))
    f = frequencies_of(frequencies)
    one = small_motions(machine, x, wrench)
    pushed = one.J.T if source == "motor" else one.W
    shown = one.Q if to == "encoder" else one.W.T
    s = 2j * np.pi * f[:, None, None]
    return shown @ np.linalg.solve(s * s * one.M + s * one.D + one.K, np.broadcast_to(pushed, (len(f), *pushed.shape)))


def held_response(machine, x, frequencies, wrench=None) -> np.ndarray:
    """Eq. (15) from the wrench on the tool to the tool with the joints held, d = N y: (k, 6, 6) complex, in W, SI.

    Raises
    ------
    ExperimentError
        frequencies not above 0.
    """
    f = frequencies_of(frequencies)
    one = small_motions(machine, x, wrench)
    N = unmoved(one.J)
    M, D, K, W = N.T @ one.M @ N, N.T @ one.D @ N, N.T @ one.K @ N, N.T @ one.W
    s = 2j * np.pi * f[:, None, None]
    return W.T @ np.linalg.solve(s * s * M + s * D + K, np.broadcast_to(W, (len(f), *W.shape)))


def frequencies_of(frequencies) -> np.ndarray:
    """Frequencies (k,) Hz as numbers above 0; ExperimentError else."""
    f = np.asarray(frequencies, float)
    if f.ndim != 1 or not (np.isfinite(f) & (f > 0)).all():
        raise ExperimentError(
            "frequencies must be a row of numbers above 0", key="frequencies", value=brief(frequencies)
        )
    return f


def stiffness_map(machine, poses) -> dict[str, np.ndarray]:
    """What changes over the workspace, at poses (N, d): rows of NaN where the machine cannot stand.

    {"stiffness": (N, 3) N/m along x y z of W, the joints held, "least": (N,) N/m in the softest direction,
    "frequency": (N,) Hz, the first with the joints held, "sag": (N, 3) m of the tip at rest, in W}
    """
    poses = np.atleast_2d(np.asarray(poses, float))
    found = np.full((len(poses), 8), np.nan)
    for row, x in zip(found, poses, strict=True):
        try:
            one = small_motions(machine, x)
        except RunError:
            continue
        C = _compliance(one)[:3, :3]
        sag = pose_of(machine, one.z)[:3] - machine.rigid.tool_pose(x)[:3]
        least = 1 / np.linalg.eigvalsh((C + C.T) / 2)[-1]
        row[:] = [*(1 / np.diag(C)), least, _modes(one, True).frequency[0], *sag]
    return {"stiffness": found[:, :3], "least": found[:, 3], "frequency": found[:, 4], "sag": found[:, 5:]}


@lru_cache(maxsize=64)
def _functions(shape: Shape) -> ca.Function:
    """(theta, z, u, w) -> M, D, K, J, Q, W."""
    m = shape.part
    with BUILDING:
        p, theta = m.symbols
        z, v = ca.SX.sym("z", m.coordinate_count), ca.SX.sym("v", len(m.velocities))
        u, w = ca.SX.sym("u", m.joints_count), ca.SX.sym("w", 6)
        rest = ca.SX.zeros(len(m.velocities))
        S = ca.jacobian(m.rate(p, z, v), v)  # z' is linear in v
        pi = {key: value for key, (value, _) in m.inertial(p).items()}
        M, h = m.mass_and_bias(p, pi, z, v)
        F, _ = static_force(m, p, z, u, w)
        out = [
            M,
            ca.substitute(ca.jacobian(h, v), v, rest),
            -ca.jacobian(F, z) @ S,
            m.jacobian_of(p, z),
            ca.jacobian(m.measured_of(p, z), z) @ S,
            ca.jacobian(m.wrench_of(p, z, w), w),
        ]
    return ca.Function("small", [theta, z, u, w], [ca.densify(one) for one in out])
