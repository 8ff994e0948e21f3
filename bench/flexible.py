"""Closed loops on flexible plants: simulated seconds a CPU second, and what the chosen step costs in accuracy.

python -m bench.flexible        one core; the rows of docs/flexible.md
"""

from __future__ import annotations

import time

import numpy as np

import gough as gk
from gough.simulate.stability import choose_substeps, fastest_pole

PERIOD = 1e-3
LAWS = {
    "nist-octahedral": gk.PID(bandwidth=4.0),
    "eth-hexaglide": gk.PID(bandwidth=8.0),
    "ifma-hsm": gk.PID(bandwidth=3.0),
}
PROGRAM = gk.Circle(radius=0.05, feed=0.05)


def row(name: str) -> dict:
    """One machine: sub-steps, speed of gk.simulate() and of the machine code, error of the chosen step."""
    m = gk.load_machine(name)
    plant = gk.Plant(machine=m, flexible=True)
    steps = choose_substeps(m.flexible(), PERIOD)
    gk.simulate(m, LAWS[name], PROGRAM, plant=plant)  # compiled
    begun = time.process_time()
    log = gk.simulate(m, LAWS[name], PROGRAM, plant=plant)
    spent = time.process_time() - begun
    ideal = m.frictionless().with_perfect_drives()
    smooth = gk.Plant(machine=ideal, flexible=True)
    x = [gk.simulate(ideal, LAWS[name], PROGRAM, plant=smooth, substeps=n).dataset.x.values for n in (steps, 4 * steps)]
    return {
        "machine": name,
        "pole": fastest_pole(m.flexible()),
        "substeps": steps,
        "times real time": log.info["simulated_time"] / spent,
        "of the loop alone": log.info["simulated_time"] / log.info["wall_time"],
        "step error": float(np.abs(x[0] - x[1])[:, :3].max()),
    }


def main() -> None:
    """The rows as a table."""
    for name in LAWS:
        found = row(name)
        print(
            f"{found['machine']:16} pole {found['pole']:6.0f} 1/s  {found['substeps']:2} sub-steps  "
            f"{found['times real time']:5.1f} x real time ({found['of the loop alone']:5.1f} x the loop alone)  "
            f"step error {found['step error'] * 1e9:.2g} nm"
        )


if __name__ == "__main__":
    main()
