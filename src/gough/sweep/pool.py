"""Workers on this machine: processes, each with a pipe of its own.

A worker that dies (killed, out of memory) is replaced and its batch done again by another; what kills three workers in
a row is given up, and told.  Workers end with their parent, however it ends: their pipe does.
"""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import signal
from collections import deque
from collections.abc import Iterable, Iterator
from multiprocessing.connection import Connection, wait
from typing import Any, NamedTuple

from ..errors import RunError
from .work import Done, Task, work

MOST_TRIES = 3
_QUIET = 0.2  # s between looks for Ctrl-C


class Pool:
    """`with Pool(2) as pool: for number, done in pool.each(tasks): ...`, in the order in which they end."""

    def __init__(self, workers: int):
        self.workers = workers
        self._context = multiprocessing.get_context("spawn")  # a fork would share locks and threads of this process
        self._hands: list[_Hand] = []

    def __enter__(self) -> Pool:
        return self

    def __exit__(self, *_error: Any) -> None:
        for hand in self._hands:
            hand.process.kill()
        for hand in self._hands:
            hand.process.join()
            hand.pipe.close()

    def each(self, tasks: Iterable[Task], most: int) -> Iterator[tuple[int, Done]]:
        """(number of the task, what came of it), as they end; a task is asked for when a worker is free for it.

        `most` is the greatest number of tasks that there can be.

        Raises
        ------
        RunError
            a batch has killed three workers.
        """
        coming, again = enumerate(tasks), deque()
        tries: dict[int, int] = {}
        busy: dict[Connection, tuple[_Hand, tuple[int, Task]]] = {}

        def send(hand: _Hand) -> None:
            item = again.popleft() if again else next(coming, None)
            if item is None:
                return
            with contextlib.suppress(OSError):  # it has died: its pipe says so below
                hand.pipe.send(item[1])
            busy[hand.pipe] = hand, item

        self._hands = [self._hand() for _ in range(min(self.workers, most))]
        for hand in list(self._hands):
            send(hand)
        while busy:
            for pipe in wait(list(busy), _QUIET):
                hand, (number, task) = busy.pop(pipe)
                try:
                    done = pipe.recv()
                except (EOFError, OSError):
                    tries[number] = tries.get(number, 0) + 1
                    if tries[number] >= MOST_TRIES:
                        raise RunError(
                            f"a batch of {len(task.jobs)} runs has ended {MOST_TRIES} workers",
                            value=f"exit status {hand.ended()}, first run {task.jobs[0].id[:8]}",
                            cure="is there memory for so many --workers?",
                        ) from None
                    again.append((number, task))
                    self._hands.remove(hand)
                    hand.ended()
                    self._hands.append(self._hand())
                    send(self._hands[-1])
                else:
                    send(hand)  # it goes on while its results are being kept
                    yield number, done

    def _hand(self) -> _Hand:
        ours, theirs = self._context.Pipe()
        # as many threads of linear algebra as there are workers, not as many for each
        old = {name: os.environ.get(name) for name in _THREADS}
        os.environ.update({name: "1" for name, value in old.items() if value is None})
        try:
            process = self._context.Process(target=_serve, args=(theirs,), daemon=True)
            process.start()
        finally:
            for name, value in old.items():
                if value is None:
                    os.environ.pop(name, None)
        theirs.close()
        return _Hand(process, ours)


_THREADS = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")


class _Hand(NamedTuple):
    """One worker, and our end of its pipe."""

    process: Any
    pipe: Connection

    def ended(self) -> Any:
        self.process.join(timeout=5)
        return self.process.exitcode


def _serve(pipe: Connection) -> None:
    """The life of a worker: batches in, records out, until the pipe ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C goes to all of a terminal: the parent decides
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    while True:
        try:
            task = pipe.recv()
        except EOFError:
            return
        done = work(task)
        try:
            pipe.send(done)
        except OSError:
            return
