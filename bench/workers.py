"""Two workers against one, beside two copies of a plain arithmetic loop against one.

On a machine with a shared clock, shared caches or neighbours two copies of anything do less than twice the work of one;
the loop says how much less is nobody's fault.
"""

from __future__ import annotations

import multiprocessing
import time

SECONDS = 1.0  # wall, of each measurement


def _worker(pipe):
    """Answers (what, until) with work done a second: "loop" sums, "batch" simulates, until the wall clock says so."""
    from .loops import Loop, machines

    loop = Loop(machines()["LuGre"])
    kernel = loop.compiled("auto")
    loop.rate(kernel, kernel.lanes, 100)

    def sums():
        x = 0.5
        for _ in range(100_000):
            x = 3.7 * x * (1.0 - x)
        return 1

    def batch():
        loop.rate(kernel, kernel.lanes, 500)
        return 1

    work = {"loop": sums, "batch": batch}
    pipe.send("ready")
    while True:
        what = pipe.recv()
        if what is None:
            return
        begun, done = time.perf_counter(), 0
        while time.perf_counter() - begun < SECONDS:
            done += work[what]()
        pipe.send(done / (time.perf_counter() - begun))


class Workers:
    """Two processes that work when asked, alone or together."""

    def __enter__(self) -> Workers:
        context = multiprocessing.get_context("spawn")
        self._pipes, self._processes = [], []
        for _ in range(2):
            ours, theirs = context.Pipe()
            process = context.Process(target=_worker, args=(theirs,), daemon=True)
            process.start()
            self._pipes.append(ours)
            self._processes.append(process)
        for pipe in self._pipes:
            if not pipe.poll(120):
                raise TimeoutError("a worker of the bench did not start")
            pipe.recv()
        return self

    def __exit__(self, *_):
        for pipe, process in zip(self._pipes, self._processes, strict=True):
            pipe.send(None)
            process.join(10)

    def _ask(self, what: str, count: int) -> float:
        for pipe in self._pipes[:count]:
            pipe.send(what)
        return sum(pipe.recv() for pipe in self._pipes[:count])

    def round(self) -> dict[str, float]:
        """Work of two against one, for both kinds of work, and the ratio of the two."""
        # one, two, two, one: a machine that slows down or recovers meanwhile does so for both
        found = {}
        for what in ("loop", "batch"):
            alone, both = self._ask(what, 1), self._ask(what, 2)
            both, alone = both + self._ask(what, 2), alone + self._ask(what, 1)
            found[what] = both / alone
        return {"loop, two / one": found["loop"], "batch, two / one": found["batch"],
                "workers": found["batch"] / found["loop"]}  # fmt: skip
