"""The file of a subroutine: name.ngc in one of the folders that were named, and nothing else.

A folder may also be a mapping, name to text: the files a program called when it was loaded, kept with it.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from ...errors import ProgramError
from ...files import read_text

LARGEST_FILE = 64 * 1024 * 1024  # bytes
_PLAIN_NAME = re.compile(r"[a-z0-9_-][a-z0-9_.-]{0,99}")


def find_subroutine(label: str, folders: Sequence[Path | Mapping[str, str]]) -> tuple[Path, str] | None:
    """Path and text of the file of the subroutine `label`, from the first folder that has it; None: there is none.

    Links are followed only where they stay inside their folder.

    Raises
    ------
    ProgramError
        the label is no plain name, or the file leads out of its folder or is not a regular file of at most 64 MB.
    """
    if not _PLAIN_NAME.fullmatch(label):
        cure = "use letters, digits, _ and - only: a file is looked for in the program's folders"
        raise ProgramError("a subroutine of this name cannot have a file", value=repr(label[:40]), cure=cure)
    for folder in folders:
        if isinstance(folder, Mapping):
            if label in folder:
                return Path(f"{label}.ngc"), folder[label]
            continue
        path = Path(folder) / f"{label}.ngc"
        try:
            inside = path.resolve(strict=True).is_relative_to(Path(folder).resolve(strict=True))
        except (OSError, RuntimeError):  # it is not there, or a link leads to itself
            continue
        if not inside:
            raise ProgramError(
                "a subroutine's file must lie in its folder", value=repr(path.name), cure="copy it there"
            )
        return path, read_text(path, LARGEST_FILE, ProgramError)
    return None


class Called(Mapping):
    """The folders as a mapping that finds files in them and remembers the texts: `texts`, by name."""

    def __init__(self, folders: Sequence[Path]):
        self.folders, self.texts = tuple(folders), {}

    def __contains__(self, label: object) -> bool:
        if label not in self.texts:
            found = find_subroutine(str(label), self.folders)
            if found is None:
                return False
            self.texts[label] = found[1]
        return True

    def __getitem__(self, label: str) -> str:
        if label not in self:
            raise KeyError(label)
        return self.texts[label]

    def __iter__(self) -> Iterator[str]:
        return iter(self.texts)

    def __len__(self) -> int:
        return len(self.texts)
