"""What the study of Okuda et al. 2006 hangs on: numbers over the ranges of what was chosen; where t_0 comes from.

python -m tests.study.sensitivity      prints both tables of docs/studies/okuda2006.md; some minutes
"""

from __future__ import annotations

import sys
from typing import NamedTuple

import numpy as np

from gough.machine.hexapod_parts import JointFriction
from gough.mechanics.friction import LuGre
from gough.study.okuda2006 import experiments, load, rows, setup

ARM = 0.2  # times a radius: the arm of a joint's friction


def machine(platform=0.005, base=0.06, stiffness=1e8, plain=False):
    """The true machine of the study with other radii of the joints' friction, m, and bristles, N/m.

    `plain`: struts without a Stribeck rise and viscous friction.
    """
    more = {} if plain else {"static": 1.2 * setup.F_0 * setup.SPREAD, "stribeck": 2e-3, "viscous": 150.0}
    damping = 2e5 * np.sqrt(stiffness / 1e8)  # the same damping ratio
    made = setup.machine().replace(
        friction=LuGre(coulomb=setup.F_0 * setup.SPREAD, stiffness=stiffness, damping=damping, **more)
    )
    if platform == base == 0:
        return made
    friction = JointFriction(coefficient=ARM, platform_radius=platform, base_radius=base, smoothing=2e-3)
    return made.replace(joints=made.joints.replace(friction=friction))


class Found(NamedTuple):
    """What the study's experiments give on a machine."""

    m_S: tuple[float, float]  # kg, and its deviation
    f_0: float  # largest error, N
    t_0: tuple[float, float]  # least and greatest, N m
    residual: float  # rms, N
    rms: tuple[float, float]  # of the torques over their range, worst strut, both tilts
    most: tuple[float, float]  # 95 % of their errors
    held: float  # held-out over residual
    loaded: tuple[float, float]  # m_S with torques that grow with the load, and the residual


def circles(true) -> Found:
    """Learn from circles of 100 mm on `true`, predict those of 144 mm."""
    every = [*experiments.TAUGHT, *experiments.SHOWN]
    logs = [experiments.measured(setup.circle(*one), true, k, None) for k, one in enumerate(every)]
    taught, shown = logs[: len(experiments.TAUGHT)], logs[len(experiments.TAUGHT) :]
    fit, grows = experiments.fitted(taught), experiments.fitted(taught, True)
    named, more = rows._named(fit), rows._named(grows)
    shares = [rows.shares(experiments.predicted(n, c, fit.full)) for n, c in zip(setup.TILTS, shown, strict=True)]
    rms, most = (tuple(float(share[k].max()) for share in shares) for k in range(2))
    f_0, t_0 = (np.array([named[f"{name}[{j}]"][0] for j in range(6)]) for name in ("f_0", "t_0"))
    return Found(
        named["m_S"], float(np.abs(f_0 - setup.F_0 * setup.SPREAD).max()), (float(t_0.min()), float(t_0.max())),
        fit.residual_rms, rms, most, fit.held_out_rms / fit.residual_rms, (more["m_S"][0], grows.residual_rms),
    )  # fmt: skip


def static(true) -> dict[str, tuple[float, float, float]]:
    """Largest error, its bound, and its share at 3.5 kN over that at 0.5 kN, of the static load in X and Y."""
    out = {}
    for name, axis in load.DIRECTIONS.items():
        test = load.loaded(axis, true, True, 100 + axis)
        low, high = rows.share(test, axis)
        out[name] = float(np.abs(test.error(axis)).max()), float(test.bound[axis]), high / low
    return out


CHOSEN = {
    "as in the study": {}, "platform joints: arm 0.05 mm": {"platform": 0.05e-3 / ARM},
    "0.4 mm": {"platform": 0.4e-3 / ARM}, "2 mm": {"platform": 2e-3 / ARM}, "4 mm": {"platform": 4e-3 / ARM},
    "bristles: 1e7 N/m": {"stiffness": 1e7}, "1e9 N/m": {"stiffness": 1e9},
    "base joints: arm 6 mm": {"base": 6e-3 / ARM}, "18 mm": {"base": 18e-3 / ARM},
}  # fmt: skip
PARTS = {
    "all, as in the study": {}, "base joints without friction": {"base": 0.0},
    "platform joints without friction": {"platform": 0.0}, "both": {"base": 0.0, "platform": 0.0},
    "both, struts with Coulomb friction alone": {"base": 0.0, "platform": 0.0, "plain": True},
}  # fmt: skip


def main() -> int:
    """Print both tables."""
    print("| chosen | torques, rms | 95 % | held out | static error X, Y | share X, Y | m_S, t_0j grow |")
    print("|---|---|---|---|---|---|---|")
    for name, options in CHOSEN.items():
        true = machine(**options)
        found, test = circles(true), static(true)
        rms, most = (" and ".join(f"{100 * v:.1f} %" for v in pair) for pair in (found.rms, found.most))
        errors = " and ".join(f"{e:.0f} N" for e, _, _ in test.values())
        shares = " and ".join(f"{s:.2f}" for _, _, s in test.values())
        print(
            f"| {name} | {rms} | {most} | {found.held:.2f} | {errors} | {shares} | {found.loaded[0]:.1f} kg |",
            flush=True,
        )
    print("\n| the machine has | m_S | t_0j | f_0j off by | rms error | t_j = c_j \\|u_j\\|: m_S, rms error |")
    print("|---|---|---|---|---|---|")
    for name, options in PARTS.items():
        found = circles(machine(**options))
        t_0 = f"{found.t_0[0]:.1f} to {found.t_0[1]:.1f} N m"
        print(
            f"| {name} | {found.m_S[0]:.2f} +- {found.m_S[1]:.2f} kg | {t_0} | {found.f_0:.1f} N | "
            f"{found.residual:.1f} N | {found.loaded[0]:.2f} kg, {found.loaded[1]:.1f} N |", flush=True,
        )  # fmt: skip
    return 0


if __name__ == "__main__":
    sys.exit(main())
