"""make bench: simulated seconds a CPU second of one closed loop, beside CasADi's interpreter.

The loop: nist-octahedral under computed torque at 1 kHz, RK4 at 0.25 ms, on the program of the demo's kind (a circle
of 0.2 m at 3 m/min), once with friction without memory and once with LuGre.  "kernel" is the machine code alone;
"simulate" is gk.simulate() with the reference, the checks, the contour error and the log.  Every engine runs once a
round; the figure is the median of the rounds, the ratios are medians of the ratios within a round.
"""

from __future__ import annotations

import json
import os
import statistics
import time
from pathlib import Path

import numpy as np

import gough as gk
from gough import kernel as kernels
from gough.frames import quaternion_of_abc_np
from gough.program.reference import Reference
from gough.simulate import tick
from gough.simulate.provenance import processor

ROUNDS = 5
PERIOD, SUBSTEPS = 1e-3, 4
LUGRE = gk.load_machine("nist-octahedral")
STRIBECK = LUGRE.replace(
    friction={
        "kind": "stribeck",
        "coulomb": 300.0,
        "static": 400.0,
        "stribeck": 2e-3,
        "viscous": 930.0,
        "smoothing": 1e-3,
    }
)
PROGRAM = gk.Circle(radius=0.2, feed=0.05)


def closed_loop(machine):
    """Schedule, parameters, states and reference table of the loop."""
    law = gk.ComputedTorque(bandwidth=16.0).on(machine, PERIOD)
    motion = PROGRAM.plan(machine)
    table = motion.sample(0, 4000, PERIOD)
    row = Reference(*(column[0] for column in table))
    u0 = machine.inverse_dynamics(row.x, np.zeros(6), np.zeros(6))
    state = law.init(row, u0)
    schedule = tick.build(machine, law, state, row, PERIOD, SUBSTEPS)
    parameters = {"theta_plant": machine.theta, "theta_law": law.theta, "wrench": np.zeros(6)}
    z = np.concatenate([row.x[:3], quaternion_of_abc_np(row.x[3:])])
    states = tick.first_states(schedule, z, state, u0)
    return schedule, parameters, states, np.concatenate(table, axis=1)


def rate(kernel, parameters, states, table, runs, ticks):
    """Simulated seconds (of all runs) a CPU second."""
    simulation = kernel.start(parameters, states, runs=runs)
    start = time.process_time()
    rows = simulation.advance(ticks, {"reference": table[:ticks]})
    spent = time.process_time() - start
    assert len(rows) == ticks
    return runs * ticks * PERIOD / spent


def whole(machine):
    """Simulated seconds a CPU second of gk.simulate(), reference to log."""
    start = time.process_time()
    log = gk.simulate(machine, gk.ComputedTorque(bandwidth=16.0), PROGRAM)
    assert log.dataset.attrs["status"] == "done"
    return log.info["simulated_time"] / (time.process_time() - start)


def main():
    result = {
        "processor": processor(),
        "threads": os.cpu_count(),
        "version": gk.__version__,
        "rounds": ROUNDS,
        "cases": {},
    }
    for name, machine in (("without memory", STRIBECK), ("LuGre", LUGRE)):
        schedule, *start = closed_loop(machine)
        begun = time.perf_counter()
        one = kernels.compile(schedule, lanes=1, cache=False)
        compiled = time.perf_counter() - begun
        eight = kernels.compile(schedule, lanes="auto", cache=False)
        slow = kernels.compile(schedule, native=False)
        whole(machine)  # fills the caches
        figures = {"interpreter": [], "one lane": [], "lanes": [], "simulate": []}
        for _ in range(ROUNDS):
            figures["interpreter"].append(rate(slow, *start, runs=1, ticks=100))
            figures["one lane"].append(rate(one, *start, runs=1, ticks=4000))
            figures["lanes"].append(rate(eight, *start, runs=eight.lanes, ticks=4000))
            figures["simulate"].append(whole(machine))
        ratio = lambda a, b: statistics.median(x / y for x, y in zip(figures[a], figures[b], strict=True))  # noqa: E731, B023
        result["cases"][name] = {key: statistics.median(values) for key, values in figures.items()} | {
            "lanes_width": eight.lanes, "operations": one.operations, "compile_s": compiled,
            "one lane / interpreter": ratio("one lane", "interpreter"), "lanes / one lane": ratio("lanes", "one lane"),
        }  # fmt: skip
    write(result)


def write(result):
    lines = [
        "# Performance", "",
        "Written by `make bench`.  Simulated seconds a CPU second, one core, medians of "
        f"{result['rounds']} interleaved rounds; the octahedral hexapod under computed torque,",
        "1 kHz, RK4 at 0.25 ms.", "",
        f"Processor: {result['processor']}", "",
        "| | " + " | ".join(f"friction {name}" for name in result["cases"]) + " |",
        "|---|" + "---|" * len(result["cases"]),
    ]  # fmt: skip
    cases = list(result["cases"].values())
    for key, label in (
        ("interpreter", "CasADi's interpreter"), ("one lane", "kernel, one lane"),
        ("lanes", f"kernel, {cases[0]['lanes_width']} lanes"),
        ("simulate", "`gk.simulate()`, one run, with reference, contour error and log"),
        ("one lane / interpreter", "one lane against the interpreter"),
        ("lanes / one lane", "all lanes against one lane"),
        ("operations", "operations a sample"), ("compile_s", "compile time of one lane, s"),
    ):  # fmt: skip
        cells = [f"{case[key]:.3g}" if isinstance(case[key], float) else f"{case[key]}" for case in cases]
        lines.append(f"| {label} | " + " | ".join(cells) + " |")
    text = "\n".join(lines) + "\n"
    print(text)
    docs = Path(__file__).parent.parent / "docs"
    (docs / "performance.md").write_text(text)
    (docs / "performance.json").write_text(json.dumps(result, indent=1) + "\n")


if __name__ == "__main__":
    main()
