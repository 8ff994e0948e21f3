"""The store of a sweep: a folder with one small file a run, found by what made the run, checked when it is read.

    DIR/.gough                      says what the folder is
    DIR/experiments/KEY/            the resolved experiment with its sheet and program, as `gough run` takes it
    DIR/runs/ab/ab12....json        a run; its last entry is the SHA-256 of all before it
    DIR/.partial/*/                 files on their way, one folder a writer
    DIR/index.parquet, report.html  made of the files, and made again whenever a sweep ends

A file is written beside its place, flushed to the disk and moved there: it is whole or not there, whoever is killed.
The files of a batch are flushed side by side and their folders once, so that the disk's answer is waited for a few
times a batch, not once a run.  Two sweeps on one store write the same bytes to the same places; neither waits.
A power cut costs the batches that were not yet told to be stored, and no other.
"""

from __future__ import annotations

import contextlib
import fcntl
import hashlib
import json
import os
import shutil
import uuid
from collections.abc import Iterable, Mapping
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

from ..errors import ExperimentError, LogError, StorageError
from ..files import storage_error, sync, write_atomic
from .jobs import ID_DIGITS, SCHEMA

MARKER, STORE = ".gough", "gough-sweep-1"
LARGEST_RUN = 1 << 20  # bytes of one run's file; a usual one has 2 kB
_AT_ONCE = 8  # files that are flushed side by side
_SEAL = b',"sha256":"'


class Store:
    """Runs by id in a folder.  A context: on entering it the folder is made or recognised, and cleaned of the dead."""

    def __init__(self, folder: str | Path):
        self.folder = Path(folder)
        self.shared = False  # whether another sweep was at work here when this one began

    def __enter__(self) -> Store:
        try:
            self._refuse_foreign()
            self.folder.mkdir(parents=True, exist_ok=True)
            if not (self.folder / MARKER).exists():  # the first that is there: whoever sees more, sees whose it is
                write_atomic(self.folder / MARKER, json.dumps({"schema": STORE}) + "\n")
            for name in ("runs", "experiments", ".partial"):
                (self.folder / name).mkdir(exist_ok=True)
            with open(self.folder / ".partial" / "door", "ab") as door:  # nobody cleans while another one enters
                fcntl.flock(door, fcntl.LOCK_EX)
                self._clean()
                self._own = self.folder / ".partial" / uuid.uuid4().hex
                self._own.mkdir()
                self._lock = open(self._own / "lock", "wb")  # noqa: SIM115 - held as long as the store is open
                fcntl.flock(self._lock, fcntl.LOCK_EX)
        except OSError as error:
            raise storage_error(error, self.folder) from error
        self._flushers = ThreadPoolExecutor(_AT_ONCE)
        return self

    def __exit__(self, *_error: Any) -> None:
        self._flushers.shutdown()
        self._lock.close()
        shutil.rmtree(self._own, ignore_errors=True)

    def _refuse_foreign(self) -> None:
        if not os.path.lexists(self.folder):
            return
        if not self.folder.is_dir():
            raise ExperimentError("must be a folder", key="--out", value=str(self.folder), cure="choose another name")
        # a marker on its way is that of a sweep that begins, or was killed then
        known = [path for path in self.folder.iterdir() if not path.name.endswith(MARKER)]
        if not is_store(self.folder) and known:
            raise ExperimentError(
                "the folder holds files that are no sweep's", key="--out", value=str(self.folder),
                cure="choose another with --out",
            )  # fmt: skip

    def _clean(self) -> None:
        """Remove what killed sweeps left; a living one holds the lock of its folder."""
        for left in (self.folder / ".partial").glob("*/"):
            with contextlib.suppress(OSError), open(left / "lock", "ab") as lock:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
                shutil.rmtree(left)
            self.shared = self.shared or left.exists()

    # -- runs ---------------------------------------------------------------------------------------------------------

    def place(self, id: str) -> Path:
        """The file of a run."""
        return self.folder / "runs" / id[:2] / f"{id}.json"

    def get(self, id: str) -> dict[str, Any] | None:
        """The record of a run; None where there is none, or its file is damaged: then it is to be done again."""
        try:
            return unsealed(self.place(id).read_bytes(), id)
        except OSError:
            return None

    def put(self, records: Iterable[Mapping[str, Any]]) -> None:
        """Keep finished runs; they are on the disk when this returns.

        Raises
        ------
        StorageError
            the disk is full or not writable.  What was there is intact, and no file is cut short.
        """
        made = [(self.place(record["id"]), sealed(record)) for record in records]
        beside = [self._own / path.name for path, _ in made]
        try:
            try:
                for (_, data), temporary in zip(made, beside, strict=True):
                    temporary.write_bytes(data)
                list(self._flushers.map(sync, beside))
                folders = dict.fromkeys(path.parent for path, _ in made)
                for folder in folders:
                    if not folder.exists():
                        folder.mkdir(exist_ok=True)
                        sync(folder.parent)
                for (path, _), temporary in zip(made, beside, strict=True):
                    os.replace(temporary, path)
                list(self._flushers.map(sync, folders))
            finally:
                for temporary in beside:
                    temporary.unlink(missing_ok=True)
        except OSError as error:
            raise storage_error(error, self.folder) from error

    def find(self, start: str) -> dict[str, Any]:
        """The record of the run whose id begins so.

        Raises
        ------
        LogError
            there is none, or more than one.
        """
        start = start.lower()
        known = [p.stem for p in (self.folder / "runs").glob(f"{start[:2] if len(start) > 1 else ''}*/*.json")]
        found = [id for id in known if id.startswith(start)]
        if len(found) != 1:
            rule = "no run of the sweep has this id" if not found else "several runs have ids that begin so"
            cure = "the ids stand in index.parquet and report.html" if not found else "give more of its digits"
            raise LogError(rule, key="--rerun", value=start[:40], cure=cure)
        record = self.get(found[0])
        if record is None:
            cure = "gough sweep does it again"
            raise LogError("the file of the run is damaged", file=str(self.place(found[0])), cure=cure)
        return record

    # -- experiments --------------------------------------------------------------------------------------------------

    def keep_experiment(self, key: str, files: Mapping[str, str]) -> Path:
        """Keep the resolved experiment that runs of `key` are made of; the path of its experiment file."""
        folder = self.folder / "experiments" / key[:ID_DIGITS]
        try:
            for name, text in files.items():
                (folder / name).parent.mkdir(parents=True, exist_ok=True)
                write_atomic(folder / name, text)
        except OSError as error:
            raise storage_error(error, folder) from error
        return folder / "experiment.toml"

    def experiment_file(self, key: str) -> Path:
        return self.folder / "experiments" / key[:ID_DIGITS] / "experiment.toml"


def is_store(folder: Path) -> bool:
    """Whether a folder is the store of a sweep.

    Raises
    ------
    StorageError
        it is one of another version of gough.
    """
    try:
        found = json.loads((folder / MARKER).read_text()[:10_000])
    except (OSError, ValueError):
        return False
    schema = found.get("schema", "") if isinstance(found, dict) else ""
    if isinstance(schema, str) and schema != STORE and schema.startswith("gough-sweep-"):
        raise StorageError("a store of another version of gough", file=str(folder), value=schema, cure=f"not {STORE}")
    return schema == STORE


def sealed(record: Mapping[str, Any]) -> bytes:
    """The bytes of a run's file: JSON whose last entry is the hash of all before it."""
    body = json.dumps({"schema": SCHEMA, **record}, allow_nan=False, separators=(",", ":")).encode()[:-1]
    return body + _SEAL + hashlib.sha256(body).hexdigest().encode() + b'"}\n'


def unsealed(data: bytes, id: str) -> dict[str, Any] | None:
    """The record of a run's file; None if a bit of it is not as it was written, or it is another run's."""
    body, seal, rest = data[: LARGEST_RUN + 1].rpartition(_SEAL)
    if not seal or rest != hashlib.sha256(body).hexdigest().encode() + b'"}\n':
        return None
    record = json.loads(body + b"}")
    return record if record.get("schema") == SCHEMA and record.get("id") == id else None
