"""How far the reading and planning of a program have come, told to whoever waits for it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar

Listener = Callable[[str, float], None]

_LISTENER: ContextVar[Listener | None] = ContextVar("listener", default=None)


@contextmanager
def telling(listener: Listener) -> Iterator[None]:
    """Within this block `listener(stage, share)` hears what is done, "reading" or "planning", and how much, 0 to 1."""
    token = _LISTENER.set(listener)
    try:
        yield
    finally:
        _LISTENER.reset(token)


def tell(stage: str, share: float) -> None:
    """Say that `share`, 0 to 1, of a stage is done."""
    listener = _LISTENER.get()
    if listener is not None:
        listener(stage, share)
