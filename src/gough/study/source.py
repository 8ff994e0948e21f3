"""Which source a study was done with: the documentation says of its figures whether it is still the present one."""

from __future__ import annotations

import functools
import hashlib
from pathlib import Path

# rooms that no study is done with: those that stand above it, and what only looks at results or writes for others
OTHERS = ("cli", "experiment", "export", "linuxcnc", "monitor", "sweep", "tune", "view")
SUFFIXES = (".py", ".toml", ".mplstyle")


@functools.cache
def source_hash() -> str:
    """SHA-256 of those files of gough that numbers and figures of a study may hang on."""
    found, root = hashlib.sha256(), Path(__file__).parents[1]
    for path in sorted(path for path in root.rglob("*") if path.suffix in SUFFIXES):
        if path.relative_to(root).parts[0].removesuffix(".py") not in OTHERS:
            found.update(str(path.relative_to(root)).encode() + b"\0" + path.read_bytes() + b"\0")
    return found.hexdigest()
