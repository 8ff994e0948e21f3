"""Object code on disk, verified before it is loaded: one flipped byte of machine code runs and gives wrong numbers.

A file is `magic, SHA-256 of the rest, key, length of the notes, notes (JSON), object code`.  The key is a hash of
everything the code depends on, so a foreign or outdated file has another.  The folder is ours alone (0700) and so is
every file; anything else is passed over and compiled anew.  Written by temporary file and rename, so two processes may
race.
"""

from __future__ import annotations

import contextlib
import functools
import hashlib
import json
import os
import re
import stat
import tempfile
from pathlib import Path

MAGIC = b"gough-kernel-1\n\0"
LIMIT = 512 << 20  # bytes; what was not used for longest goes first


@functools.cache
def source_digest() -> str:
    """Hash of the files that decide what code is made: a changed emitter finds no old code."""
    digest = hashlib.sha256()
    for path in sorted(Path(__file__).parent.glob("*.py")):
        digest.update(path.name.encode() + b"\0" + path.read_bytes() + b"\0")
    return digest.hexdigest()


def key_of(*parts) -> str:
    """SHA-256 over the parts, which must have a repr that says all."""
    return hashlib.sha256(repr((source_digest(), parts)).encode()).hexdigest()


def folder() -> Path | None:
    """$GOUGH_CACHE/kernel, else $XDG_CACHE_HOME/gough/kernel, else ~/.cache/gough/kernel; None without a home.

    A folder of our own in each case: it is made private and kept below LIMIT.
    """
    if os.environ.get("GOUGH_CACHE"):
        return Path(os.environ["GOUGH_CACHE"]) / "kernel"
    base = os.environ.get("XDG_CACHE_HOME") or (os.environ.get("HOME") and os.path.join(os.environ["HOME"], ".cache"))
    return Path(base) / "gough" / "kernel" if base and os.path.isabs(base) else None


def _ours(status: os.stat_result) -> bool:
    """Belongs to this user, and nobody else may write it."""
    return status.st_uid == os.geteuid() and not status.st_mode & (stat.S_IWGRP | stat.S_IWOTH)


def _usable(path: Path | None, make: bool) -> bool:
    if path is None:
        return False
    try:
        if make:
            path.mkdir(mode=0o700, parents=True, exist_ok=True)
        status = path.lstat()
        if not stat.S_ISDIR(status.st_mode) or not _ours(status):
            return False
        if status.st_mode & 0o077:
            path.chmod(0o700)
        return True
    except OSError:
        return False


def load(key: str) -> tuple[bytes, dict] | None:
    """The object code and the notes stored under a key, or None when there is none that can be trusted."""
    path = folder()
    if not _usable(path, make=False):
        return None
    try:
        handle = os.open(path / f"{key}.bin", os.O_RDONLY | os.O_NOFOLLOW | os.O_CLOEXEC)
    except OSError:
        return None
    try:
        with os.fdopen(handle, "rb") as file:
            status = os.fstat(file.fileno())
            if not stat.S_ISREG(status.st_mode) or not _ours(status):
                return None
            found = decode(file.read(), key)
            if found is not None:
                with contextlib.suppress(OSError):  # a cache that may only be read is still a cache
                    os.utime(file.fileno())
            return found
    except OSError:
        return None


def store(key: str, image: bytes, notes: dict) -> bool:
    """Keeps object code for next time.  False where that is not possible, which is no error: it is compiled again."""
    path = folder()
    if not _usable(path, make=True):
        return False
    try:
        handle, temporary = tempfile.mkstemp(prefix=".new-", dir=path)
        try:
            with os.fdopen(handle, "wb") as file:
                file.write(encode(image, key, notes))
            os.replace(temporary, path / f"{key}.bin")
        except BaseException:
            os.unlink(temporary)
            raise
        _trim(path)
        return True
    except OSError:
        return False


def encode(image: bytes, key: str, notes: dict) -> bytes:
    text = json.dumps(notes, sort_keys=True).encode()
    rest = bytes.fromhex(key) + len(text).to_bytes(8, "little") + text + image
    return MAGIC + hashlib.sha256(rest).digest() + rest


def decode(data: bytes, key: str) -> tuple[bytes, dict] | None:
    """What `encode` made, if not one bit of it has changed and it is of this key."""
    start = len(MAGIC) + 32
    if data[: len(MAGIC)] != MAGIC or hashlib.sha256(data[start:]).digest() != data[len(MAGIC) : start]:
        return None
    if data[start : start + 32] != bytes.fromhex(key):
        return None
    length = int.from_bytes(data[start + 32 : start + 40], "little")
    end = start + 40 + length
    return data[end:], json.loads(data[start + 40 : end])


_OURS = re.compile(r"[0-9a-f]{64}\.bin|\.new-.*")


def _trim(path: Path):
    """The oldest of our own files go until the rest is below LIMIT; what else lies there is not ours to touch."""
    files = []
    for entry in os.scandir(path):
        if not _OURS.fullmatch(entry.name):
            continue
        try:
            status = entry.stat(follow_symlinks=False)
        except FileNotFoundError:  # another process was quicker
            continue
        files.append((status.st_mtime, status.st_size, entry.path))
    total = sum(size for _, size, _ in files)
    for _, size, name in sorted(files):
        if total <= LIMIT:
            return
        total -= size
        try:
            os.unlink(name)
        except OSError:
            continue
