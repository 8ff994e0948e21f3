"""Results folders: built beside their place, put there whole in one step, never over a stranger's files.

    results/.part.partial-4711/   while the run lasts       .gough, logs, page
    results/part/                 afterwards

The marker `.gough` names who makes the folder (host, process) and, when finished, the files that were made.  Only a
folder with a finished marker is ever replaced.  A run that is killed leaves its partial folder; the next run for the
same place removes it once its process is gone.
"""

from __future__ import annotations

import contextlib
import ctypes
import dataclasses
import glob
import json
import os
import shutil
import socket
from collections.abc import Iterator
from pathlib import Path

from .errors import ExperimentError, StorageError
from .files import storage_error, sync, write_atomic

MARKER = ".gough"


@contextlib.contextmanager
def results_folder(path: str | Path, force: bool = False) -> Iterator[Path]:
    """Build a results folder: yields a folder to write into; it takes its place when the block ends without error.

    An old folder that gough made is replaced; files that a person added to it move along.  Any other folder with
    something in it is refused, or with `force` receives the files beside those that are there.

    Raises
    ------
    ExperimentError
        the place is taken by a file or by a folder that gough did not make.
    StorageError
        the disk is full or the place not writable.
    """
    target = Path(path).absolute()
    if target.is_symlink():
        target = target.resolve()
    _refuse_foreign(target, path, force)
    partial = target.with_name(f".{target.name}.partial-{os.getpid()}")
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        _clean(target)
        if partial.exists():  # of this very process: a run before in the same session that could not be removed
            _remove(partial)
        partial.mkdir()
        (partial / MARKER).write_text(json.dumps({"schema": "gough-results-1", "finished": False, **_whoami()}))
    except OSError as error:
        raise storage_error(error, path) from error
    try:
        yield partial
        try:
            _finish(partial, target)
        except OSError as error:
            raise storage_error(error, path) from error
    except StorageError as error:
        raise _as_seen(error, str(partial), str(path)) from error
    finally:
        with contextlib.suppress(OSError):
            _remove(partial)


def _as_seen(error: StorageError, partial: str, target: str) -> StorageError:
    """The error with the place that was asked for instead of the one where it is built."""
    return StorageError(
        problems=[
            dataclasses.replace(
                problem,
                file=problem.file and problem.file.replace(partial, target),
                value=problem.value and problem.value.replace(partial, target),
                cure=problem.cure and problem.cure.replace(partial, target),
            )
            for problem in error.problems
        ]
    )


def made_by_gough(folder: Path) -> bool:
    """Whether the folder carries the marker of a finished run."""
    return _marker(folder).get("finished") is True


def _refuse_foreign(target: Path, shown: str | Path, force: bool) -> None:
    try:
        if not os.path.lexists(target):
            return
        if not target.is_dir():
            raise ExperimentError("must be a folder", key="--out", value=str(shown), cure="choose another name")
        foreign = any(target.iterdir()) and not made_by_gough(target)
    except OSError as error:
        raise storage_error(error, shown) from error
    if foreign and not force:
        raise ExperimentError(
            "the folder holds files that gough did not make",
            key="--out",
            value=str(shown),
            cure="choose another with --out, or add --force to write beside them",
        )


def _finish(partial: Path, target: Path) -> None:
    made = sorted(str(p.relative_to(partial)) for p in partial.rglob("*") if p.is_file() and p.name != MARKER)
    replace = not target.exists() or not any(target.iterdir()) or made_by_gough(target)
    if replace and target.exists():
        _carry_along(target, partial)
    if replace:
        marker = {"schema": "gough-results-1", "finished": True, "files": made}
        # in one step: a folder with files and a marker cut short by a kill would be nobody's
        write_atomic(partial / MARKER, json.dumps(marker, indent=1) + "\n")
    for entry in partial.rglob("*"):
        sync(entry)
    sync(partial)
    if not replace:  # a stranger's folder, with --force: file by file, and no marker, so that it is never replaced
        for name in made:
            (target / name).parent.mkdir(parents=True, exist_ok=True)
            os.replace(partial / name, target / name)
    elif target.exists():
        _swap(partial, target)
    else:
        os.rename(partial, target)
    sync(target.parent)


def _carry_along(old: Path, new: Path) -> None:
    """Give the new folder what a person put into the old one."""
    made = {Path(name).parts[0] for name in _marker(old).get("files", [])} | {MARKER}
    for entry in old.iterdir():
        if entry.name not in made and not (new / entry.name).exists():
            if entry.is_dir() and not entry.is_symlink():
                shutil.copytree(entry, new / entry.name, symlinks=True)
            else:
                shutil.copy2(entry, new / entry.name, follow_symlinks=False)


def _swap(partial: Path, target: Path) -> None:
    """Exchange two folders in one step of the file system; the old one is then at `partial`, to be removed."""
    try:
        rename = ctypes.CDLL(None, use_errno=True).renameat2
        at_cwd, exchange = -100, 2  # AT_FDCWD, RENAME_EXCHANGE
        if rename(at_cwd, os.fsencode(partial), at_cwd, os.fsencode(target), exchange) == 0:
            return
    except (OSError, AttributeError):
        pass
    # No exchange here (an old kernel, some network folders): two steps, and _clean repairs a kill between them.
    old = target.with_name(f".{target.name}.old-{os.getpid()}")
    os.rename(target, old)
    os.rename(partial, target)
    _remove(old)


def _clean(target: Path) -> None:
    """Remove what killed runs left; put an old folder back whose successor never arrived."""
    for old in target.parent.glob(f".{glob.escape(target.name)}.old-*"):
        if made_by_gough(old) and not _alive(old):
            if target.exists():
                _remove(old)
            else:
                os.rename(old, target)
    for left in target.parent.glob(f".{glob.escape(target.name)}.partial-*"):
        if not _alive(left) and (_marker(left) or {entry.name for entry in left.iterdir()} <= {MARKER}):
            _remove(left)


def _remove(folder: Path) -> None:
    """Remove a folder of gough's, its marker last: after a kill it is still known as ours."""
    if not folder.exists():
        return
    for entry in folder.iterdir():
        if entry.is_dir() and not entry.is_symlink():
            shutil.rmtree(entry)
        elif entry.name != MARKER:
            entry.unlink()
    shutil.rmtree(folder)


def _marker(folder: Path) -> dict:
    try:
        found = json.loads((folder / MARKER).read_text()[:1_000_000])
    except (OSError, ValueError):
        return {}
    return found if isinstance(found, dict) and found.get("schema") == "gough-results-1" else {}


def _whoami() -> dict:
    return {"host": socket.gethostname(), "pid": os.getpid(), "started": _start_of(os.getpid())}


def _alive(folder: Path) -> bool:
    """Whether the process that makes this folder still runs; on another host nobody can tell, so yes."""
    marker = _marker(folder)
    if marker.get("host", socket.gethostname()) != socket.gethostname():
        return True
    digits = folder.name.rpartition("-")[2]
    pid = int(digits) if digits.isdigit() else 0
    started = _start_of(pid) if pid else None
    if started is None:
        return False
    return marker.get("started", started) == started  # the number may have gone to another process


def _start_of(pid: int) -> str | None:
    """Start time of a process in ticks since boot, None when there is none."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[19]
    except (OSError, IndexError):
        return None
