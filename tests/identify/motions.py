"""Motions for the tests of identification, and logs made of them without a simulation."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

import gough as gk
from gough.log import Log
from gough.program import Fourier


@lru_cache
def machine_of(name: str):
    return gk.load_machine(name)


def fourier(
    seed: int, tip: float = 0.05, turn: float = 0.1, period: float = 6.0, harmonics: int = 4, **more
) -> Fourier:
    """A motion from rest to rest of about `tip` m and `turn` rad; 0 leaves it out."""
    rng, k = np.random.default_rng(seed), np.arange(1.0, harmonics + 1)[:, None]

    def series(size, power):
        rows = size * rng.uniform(-1, 1, (harmonics, 3)) / k
        rows[-1] -= (k**power * rows).sum(0) / harmonics**power
        return rows

    given = {}
    for names, size in ((("sine", "cosine"), tip), (("turn_sine", "turn_cosine"), turn)):
        for power, name in enumerate(names, start=1):
            rows = series(size, power)
            if size:
                given[name] = rows
    return Fourier(period=period, **given, **more)


def sampled(machine, program: Fourier, Ts: float = 0.02):
    """x, xd, xdd of a program's period, at the middle of samples."""
    motion = program.plan(machine)
    n = round(program.period * program.cycles / Ts)
    r = motion.sample(0, n, Ts)
    return r.x, r.xd, r.xdd


def planted(machine, names, seed: int = 0, share: float = 0.2) -> np.ndarray:
    """True values: the sheet's, changed at random, and never 0."""
    rng = np.random.default_rng(seed)
    sheet = dict(zip(machine.parameters.names, machine.parameters.values, strict=True))
    out = []
    for name in names:
        if name.startswith("friction.coulomb"):
            value = rng.uniform(50, 200)
        elif name.startswith("friction.viscous"):
            value = rng.uniform(200, 800)
        elif name.startswith("friction"):
            value = rng.uniform(0.1, 0.3)
        else:
            value = sheet[name] * (1 + share * rng.uniform(-1, 1)) + 0.3 * rng.uniform(-1, 1)
        out.append(value)
    return np.array(out)


def log_of(
    machine, program: Fourier, values, /, Ts: float = 1e-3, hold: float = 0.0, friction=True, noise=0.0, **info
) -> Log:
    """A log of q_m and of the forces that parameters `values` need, held over `hold` s where it is above 0."""
    motion = program.plan(machine)
    n = motion.count(Ts)
    r = motion.sample(0, n, Ts)

    def forces(shift):
        p = motion.sample(0, n, Ts) if not shift else _shifted(motion, n, Ts, shift)
        return machine.regressor(p.x, p.xd, p.xdd, friction=friction) @ values

    u = forces(0.0)
    if hold:  # the mean over the time it is held, by Simpson's rule
        u = (u + 4 * forces(hold / 2) + forces(hold)) / 6
    rng = np.random.default_rng(1)
    u = u + noise * rng.standard_normal(u.shape)
    values = {"q_m": r.q, "u": u, "x_r": r.x}
    return Log.build(np.arange(n) * Ts, values, task=machine.task, joints=machine.joints_count, info=info)


def _shifted(motion, n, Ts, shift):
    motion.lead_in -= shift
    try:
        return motion.sample(0, n, Ts)
    finally:
        motion.lead_in += shift
