"""What gough knows, in the files of other programs.

export(what, target) gives the text of a file, export_folder the files of a folder; `gough export WHAT --target T`
writes them.
"""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from typing import Any

from ..errors import ExperimentError, did_you_mean
from ..files import write_atomic
from ..results import results_folder

# target -> function of what is exported, what comes out
TARGETS = {"mjcf": ("gough.export.mjcf:mjcf", "an MJCF model for MuJoCo and Pinocchio")}
# of these a folder of files comes out, as {name: text}
FOLDERS = {
    "c": ("gough.export.c.folder:c_files", "C99 with a self-test"),
    "linuxcnc": ("gough.export.linuxcnc:linuxcnc_files", "a simulation for LinuxCNC"),
}
# of these one file that is no text, as bytes
BINARIES = {"fmu": ("gough.export.fmu.archive:fmu", "an FMU (FMI 2.0, co-simulation)")}

__all__ = ["BINARIES", "FOLDERS", "TARGETS", "export", "export_folder"]


def export(what: Any, target: str = "mjcf", path: str | Path | None = None, **options: Any) -> str | bytes:
    """The file of a machine for another program, written to `path` where one is given: its text, or its bytes.

    target "mjcf": the machine for MuJoCo and Pinocchio, see `gough.export.mjcf.mjcf` for its options.
    target "fmu": a machine, or an experiment's plant, see `gough.export.fmu.archive.fmu`.

    Raises
    ------
    ExperimentError
        no such target, or an option that the target does not know.
    SheetError
        the machine has something that the target cannot tell.
    StorageError
        the file could not be written.
    """
    text = _maker(target, TARGETS | BINARIES)(what, **options)
    if path is not None:
        write_atomic(path, text)
    return text


def export_folder(
    what: Any, target: str, path: str | Path | None = None, force: bool = False, **options: Any
) -> dict[str, str]:
    """The files of a target that needs a folder, {name: text}, written into the folder `path` where one is given.

    target "c": a machine or an experiment in C99, see `gough.export.c.folder.c_files`.
    target "linuxcnc": a machine, or that of an experiment, see `gough.export.linuxcnc.linuxcnc_files`.
    The folder is there whole or not at all; one that gough did not make is refused, unless `force`.

    Raises
    ------
    ExperimentError
        no such target, what the target cannot say, a folder with a stranger's files.
    StorageError
        the folder could not be written.
    """
    files = _maker(target, FOLDERS)(what, **options)
    if path is not None:
        with results_folder(path, force) as folder:
            for name, text in files.items():
                (folder / name).parent.mkdir(parents=True, exist_ok=True)
                write_atomic(folder / name, text)
    return files


def _maker(target: str, known: dict[str, tuple[str, str]]):
    if target not in known:
        cure = did_you_mean(str(target), known)
        if target in TARGETS | BINARIES | FOLDERS:
            cure = f"use {'export_folder' if target in FOLDERS else 'export'}"
        raise ExperimentError("no such target of an export", key="target", value=ascii(target), cure=cure)
    module, _, name = known[target][0].partition(":")
    return getattr(import_module(module), name)
