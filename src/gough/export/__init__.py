"""What gough knows, in the files of other programs.

export(what, target) gives the text of a file; `gough export WHAT --target T` writes it.
"""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from typing import Any

from ..errors import ExperimentError, did_you_mean
from ..files import write_atomic

# target -> function of what is exported, what comes out
TARGETS = {"mjcf": ("gough.export.mjcf:mjcf", "an MJCF model for MuJoCo and Pinocchio")}

__all__ = ["TARGETS", "export"]


def export(what: Any, target: str = "mjcf", path: str | Path | None = None, **options: Any) -> str:
    """The text of a machine for another program, written to `path` where one is given.

    target "mjcf": the machine for MuJoCo and Pinocchio, see `gough.export.mjcf.mjcf` for its options.

    Raises
    ------
    ExperimentError
        no such target, or an option that the target does not know.
    SheetError
        the machine has something that the target cannot tell.
    StorageError
        the file could not be written.
    """
    if target not in TARGETS:
        raise ExperimentError(
            "no such target of an export", key="target", value=ascii(target), cure=did_you_mean(str(target), TARGETS)
        )
    module, _, name = TARGETS[target][0].partition(":")
    text = getattr(import_module(module), name)(what, **options)
    if path is not None:
        write_atomic(path, text)
    return text
