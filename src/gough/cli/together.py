"""Several runs at a time, and an end within two seconds when a person asks for it.

The runs are threads: their time goes into compiled code, which does not hold the interpreter's lock.  The main thread
only waits, so Ctrl-C reaches it at once.
"""

from __future__ import annotations

import os
import queue
import threading
import time
from collections.abc import Callable, Sequence
from typing import Any

PATIENCE = 1.0  # s that threads get to see that they should stop


def together(jobs: Sequence[Callable[[], Any]], stop: threading.Event, at_once: int | None = None) -> list[Any]:
    """What each job returns, in their order; at most `at_once` run at a time, by default one for each core.

    The first error of a job stops the others and is raised.  On Ctrl-C `stop` is set, the jobs get a second to end,
    and KeyboardInterrupt goes on; a job asks `stop` now and then and may raise anything when it is set.
    """
    out: list[Any] = [None] * len(jobs)
    waiting: queue.SimpleQueue = queue.SimpleQueue()
    ended: queue.SimpleQueue = queue.SimpleQueue()
    for i in range(len(jobs)):
        waiting.put(i)

    def work() -> None:
        while not stop.is_set():
            try:
                i = waiting.get_nowait()
            except queue.Empty:
                return
            try:
                out[i] = jobs[i]()
                ended.put(None)
            except BaseException as error:  # to the main thread, whatever it is
                ended.put(error)

    count = min(len(jobs), at_once or len(os.sched_getaffinity(0)))
    threads = [threading.Thread(target=work, daemon=True) for _ in range(count)]
    try:
        for thread in threads:
            thread.start()
        for _ in jobs:
            error = ended.get()
            if error is not None:
                raise error
    except BaseException:
        stop.set()
        until = time.monotonic() + PATIENCE
        # not join(): a thread whose start was interrupted may not have begun
        while time.monotonic() < until and any(thread.is_alive() for thread in threads):
            time.sleep(0.01)
        raise
    return out
