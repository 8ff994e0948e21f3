"""Progress on stderr: bars on a terminal, a line at start and end elsewhere."""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

PATIENCE = 1.0  # s after which reading a program is worth a bar


@contextmanager
def preparing(name: str, quiet: bool) -> Iterator[None]:
    """A bar on the terminal while the program in the file `name` is read and planned, if that takes a while."""
    if quiet or not sys.stderr.isatty():
        yield
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn

    from ..program.progress import telling

    columns = [TextColumn("{task.description}"), BarColumn(), TaskProgressColumn(), TimeRemainingColumn()]
    bars, tasks, since = Progress(*columns, console=Console(stderr=True), transient=True), {}, time.monotonic()

    def listen(stage: str, share: float) -> None:
        if not tasks and time.monotonic() - since < PATIENCE:
            return
        if not tasks:
            bars.start()
        if stage not in tasks:
            tasks[stage] = bars.add_task(f"{stage} {name}", total=1.0)
        bars.update(tasks[stage], completed=share)

    try:
        with telling(listen):
            yield
    finally:
        if tasks:
            bars.stop()


class Shown:
    """Progress of several runs.  `tick` and `end` may be called from any thread."""

    def __init__(self, labels: list[str], quiet: bool):
        self.labels = labels
        self.stop = threading.Event()
        self.quiet = quiet
        self.bars: Any = None
        self.tasks: list[Any] = []
        self.started = [0.0] * len(labels)
        self.total: list[float | None] = [None] * len(labels)

    def __enter__(self) -> Shown:
        if not self.quiet and sys.stderr.isatty():
            from rich.console import Console
            from rich.progress import BarColumn, Progress, TextColumn

            columns = [TextColumn("{task.description}"), BarColumn(), TextColumn("{task.fields[told]}")]
            self.bars = Progress(*columns, console=Console(stderr=True))
            self.tasks = [self.bars.add_task(label, total=None, told="preparing") for label in self.labels]
            self.bars.start()
        elif not self.quiet:
            self._line(f"running {', '.join(self.labels)}")
        return self

    def __exit__(self, *_error: Any) -> None:
        if self.bars:
            self.bars.stop()

    def tick(self, i: int, done: float, total: float) -> None:
        """Run i has simulated `done` of `total` s.  Raises KeyboardInterrupt when the runs should stop."""
        if self.stop.is_set():
            raise KeyboardInterrupt
        if self.total[i] is None:
            self.total[i], self.started[i] = total, time.monotonic()
        if self.bars:
            spent = time.monotonic() - self.started[i]
            speed = f"{done / spent:5.0f} x real time" if spent > 0.2 else ""
            self.bars.update(self.tasks[i], completed=done, total=total, told=f"{done:6.1f} of {total:.1f} s  {speed}")

    def end(self, i: int, status: str) -> None:
        """Run i has ended, "done" or "failed"."""
        if self.bars:
            self.bars.update(self.tasks[i], told=status) if status == "failed" else None
        elif not self.quiet:
            simulated = f", {self.total[i]:.1f} s simulated" if self.total[i] and status == "done" else ""
            self._line(f"{self.labels[i]}: {status}{simulated}")

    def _line(self, text: str) -> None:
        print(text, file=sys.stderr, flush=True)
