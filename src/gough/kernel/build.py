"""From a text of LLVM to a library in memory, by way of the cache."""

from __future__ import annotations

import platform
from collections.abc import Callable

from ..errors import InputError
from . import cache as store
from . import lanes as lane
from . import ops


def no_native() -> str | None:
    """Why no machine code can be made here, or None."""
    try:
        import llvmlite.binding  # noqa: F401
    except (ImportError, OSError) as error:
        return f"llvmlite cannot be loaded ({error})"
    return None


def width_of(lanes: int | str) -> int:
    """How many lanes are asked for; "auto" is what this processor does best."""
    if lanes == "auto":
        return lane.native_width()
    if not isinstance(lanes, (int, str)) or isinstance(lanes, bool) or lanes not in (1, 2, 4, 8):
        raise InputError('lanes must be 1, 2, 4, 8 or "auto"', value=repr(lanes))
    return lanes


def library(export: str, description: tuple, width: int, make: Callable[[lane.Lanes], tuple], cache: bool):
    """The library that exports `export`, and whether the cache had it.

    `description` says all that decides the code beside the emitter, the compiler and the processor; `make(lanes)`
    gives the text and the symbols it needs, and is called only when the code is not in the cache.
    """
    from . import native

    key = store.key_of(export, description, width, native.version(), _functions_here(width))
    found = store.load(key) if cache else None
    if found:
        try:
            return native.Library(found[0], found[1]["symbols"], export), True
        except RuntimeError:
            pass  # whole and ours, and yet it does not link: compile
    text, symbols = make(lane.Lanes(width))
    image = native.compile_text(text)
    if cache:
        store.store(key, image, {"symbols": symbols})
    return native.Library(image, symbols, export), False


def _functions_here(width: int) -> tuple:
    """Which vector functions this machine has: the code calls them."""
    return (*(lane.vector_symbol(name, width) for name in ops.LIBM), platform.machine())
