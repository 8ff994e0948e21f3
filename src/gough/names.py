"""Names that are safe in paths, pages and lists.  No letters that look like others, none that turn the text around."""

from __future__ import annotations

import re
import unicodedata
from hashlib import sha256
from typing import Any

from .errors import ExperimentError, InputError

LONGEST_NAME = 64
_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]*")


def check_name(name: Any, key: str = "name", kind: type[InputError] = ExperimentError) -> str:
    """A name that is safe in paths, pages and lists: ASCII letters, digits, . _ -, at most 64, no leading dot.

    Raises
    ------
    InputError
        of the given kind, at `key`.
    """
    if not isinstance(name, str) or len(name) > LONGEST_NAME or not _NAME.fullmatch(name):
        raise kind(
            f"a name has 1 to {LONGEST_NAME} ASCII letters, digits and . _ -, and begins with a letter or digit",
            key=key,
            value=ascii(name if not isinstance(name, str) or len(name) <= 40 else name[:37] + "..."),
            cure=f"write e.g. {slug(name)!r}" if isinstance(name, str) else None,
        )
    return name


def slug(text: str) -> str:
    """`text` as a file name: itself if it is a safe name, else its safe characters and eight digits of its hash."""
    if len(text) <= LONGEST_NAME and _NAME.fullmatch(text):
        return text
    plain = unicodedata.normalize("NFKD", text).encode("ascii", "ignore").decode()
    safe = re.sub(r"[^A-Za-z0-9_-]+", "-", plain).strip("-_")[:40]
    return f"{safe or 'unnamed'}-{sha256(text.encode('utf-8', 'surrogatepass')).hexdigest()[:8]}"


def printable(text: str) -> str:
    """`text` for a message: characters that do not print, or that turn text around, are written as escapes."""
    return "".join(c if c.isprintable() else repr(c)[1:-1] for c in text)
