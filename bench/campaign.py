"""A campaign: the same circle on many drawn machines under an adaptive law, in two processes as a sweep runs them.

    python -m bench.campaign            10 000 circles of 1 s: wall clock, CPU, memory of all processes
    python -m bench.campaign growth     10 ... 100 000 runs, 1 ... 16 s, one machine after the other
    python -m bench campaign            the same, into docs/performance.md

Every run is one second of nist-octahedral, 1 kHz, on a circle of 20 mm under `RobustAdaptive`, with the friction of the
sheet (LuGre that scales with the load, encoders that count) times a factor of its own, normal(1, 0.2).  What is timed
holds all of it: starting the processes, drawing, set-up, simulating, contour error, metrics.  Memory is the sum over
the processes of their largest resident sets (shared pages counted in each).
"""

from __future__ import annotations

import json
import multiprocessing
import resource
import sys
import time

import numpy as np

RUNS, WORKERS, PIECE = 10_000, 2, 500
RADIUS, FEED, SETTLE = 0.02, 0.15, 0.1  # one turn takes 1.01 s with its ramps and its time at rest
SPREAD = 0.2
MOST_WALL, MOST_MEMORY = 60.0, 1e9  # aims for RUNS runs
MACHINES = ("nist-octahedral", "okuma-pm600", "eth-hexaglide", "ccu-3prs", "ifma-hsm")


def program(seconds: float = 1.0):
    """A circle of 20 mm, as many turns as take about `seconds`; one turn takes 1.01 s."""
    import gough as gk

    return gk.Circle(radius=RADIUS, feed=FEED, settle=SETTLE, turns=max(1, round(seconds)))


def factors(first: int, count: int) -> np.ndarray:
    """The factor on the friction of runs first, first + 1 ...: each hangs on its number alone."""
    return np.array([max(0.1, np.random.default_rng([11, i]).normal(1.0, SPREAD)) for i in range(first, first + count)])


def piece(first: int, count: int, seconds: float = 1.0) -> np.ndarray:
    """Contour error of runs first ... first + count - 1, rms, m."""
    import gough as gk
    from gough.simulate.drift import scaled

    machine = gk.load_machine("nist-octahedral")
    plants = [gk.Plant(machine=scaled(machine, c)) for c in factors(first, count)]
    law = gk.RobustAdaptive(slope=200.0, damping=400.0)
    log = gk.simulate(machine, law, program(seconds), plant=plants, keep="metrics")
    assert log.status == "done", log.reason
    return log.metrics["contour_error"]["rms"]


def _worker(pipe):
    """Answers (first, count, seconds) with the errors; None ends it with its largest resident set, bytes."""
    while (asked := pipe.recv()) is not None:
        pipe.send(piece(*asked))
    pipe.send(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024)


def campaign(runs: int = RUNS, workers: int = WORKERS, seconds: float = 1.0) -> dict[str, float]:
    """`runs` circles on `workers` processes: wall clock s, CPU s, memory bytes, and the median error for the record."""
    from multiprocessing.connection import wait

    begun, spent = time.perf_counter(), _children()
    context = multiprocessing.get_context("spawn")
    pipes, processes = [], []
    for _ in range(workers):
        ours, theirs = context.Pipe()
        processes.append(context.Process(target=_worker, args=(theirs,), daemon=True))
        processes[-1].start()
        theirs.close()
        pipes.append(ours)
    size = max(8, min(PIECE, -(-runs // workers // 8) * 8))
    todo = [(first, min(size, runs - first), seconds) for first in range(0, runs, size)][::-1]
    found, doing = {}, {}
    for pipe in pipes:
        if todo:
            doing[pipe] = todo.pop()
            pipe.send(doing[pipe])
    while doing:
        for pipe in wait(list(doing)):
            found[doing.pop(pipe)[0]] = pipe.recv()
            if todo:
                doing[pipe] = todo.pop()
                pipe.send(doing[pipe])
    wall = time.perf_counter() - begun
    for pipe in pipes:
        pipe.send(None)
    memory = sum(pipe.recv() for pipe in pipes) + resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
    for process in processes:
        process.join(30)
    errors = np.concatenate([found[first] for first in sorted(found)])
    assert len(errors) == runs and np.isfinite(errors).all()
    return {
        "runs": runs, "seconds": seconds, "wall_s": wall, "cpu_s": _children() - spent, "memory": memory,
        "median_rms": float(np.median(errors)),
    }  # fmt: skip


def machines(count: int = 64) -> list[dict]:
    """CPU of a batch of the same circle on each machine under a law that all of them take, with its own payloads."""
    import gough as gk

    found = []
    for name in MACHINES:
        machine, law = gk.load_machine(name), gk.FuzzyFriction(slope=60.0, damping=120.0)
        plants = [gk.Plant(machine=machine, payload=1.0 + 0.02 * i) for i in range(count)]
        path = gk.Circle(radius=RADIUS / 2, feed=FEED / 2, settle=SETTLE)
        gk.simulate(machine, law, path, plants[:1] * 2, keep="metrics")
        begun = time.process_time()
        log = gk.simulate(machine, law, path, plants, keep="metrics")
        seconds = log.metrics["samples"].mean() * 1e-3
        found.append({"machine": name, "runs": count, "cpu_s": (time.process_time() - begun) / seconds})
    return found


def _children() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def growth(most: int = 100_000) -> dict[str, list[dict]]:
    """Cost against the number of runs, the samples of a run, and the machine."""
    counts = [count for count in (10, 100, 1000, 10_000, 100_000) if count <= most]
    return {
        "runs": [campaign(count) for count in counts],
        "steps": [campaign(256, seconds=seconds) for seconds in (1, 2, 4, 8, 16)],
        "machines": machines(),
    }


if __name__ == "__main__":
    asked = sys.argv[1:] or ["10000"]
    print(json.dumps(growth() if asked == ["growth"] else campaign(int(asked[0])), indent=1))
