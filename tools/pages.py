"""Carries out the pages of docs: what a reader can copy runs, and prints what the page says.

    python tools/pages.py docs/tutorial.md ...

A page is carried out from top to bottom in a folder of its own, in which `examples` is there:

    ```python    one after the other in one namespace
    ```sh        line by line: gough, python and make commands; each must end with status 0
    ```text      directly behind one of these: what it prints, words alike and numbers to 2 %; a line ... is any lines
    <!-- file: part.ngc -->            the block that follows is that file
    <!-- status: 2 -->                 the commands that follow end so
    <!-- not run: its reason -->       the block that follows is only shown
    <!-- needs: linuxcnc -->           so is it where there is no such program

Whatever else is fenced (toml, ngc, console) is only shown.  The first thing that differs ends the page with its line.
"""

from __future__ import annotations

import io
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import traceback
from collections.abc import Iterator
from contextlib import redirect_stdout
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[1]
FENCE = re.compile(r"^```(\w*)\n(.*?)^```$", re.S | re.M)
NOTE = re.compile(r"<!-- (file|status|not run|needs): (.*?) -->\s*$")
LONGEST = 300  # s, of a page
STARTS = {"gough": [sys.executable, "-m", "gough"], "python": [sys.executable], "make": ["make"]}


class Block(NamedTuple):
    """A fenced block: its language, its text, its first line in the page, and what the note above it says."""

    language: str
    text: str
    line: int
    note: tuple[str, str] | None
    follows: bool  # directly behind the block before


class PageError(Exception):
    """A page does not do what it says."""


def blocks(text: str) -> Iterator[Block]:
    """The fenced blocks of a page, in order."""
    end = 0
    for found in FENCE.finditer(text):
        before = text[end : found.start()]
        note = NOTE.search(before)
        line = text.count("\n", 0, found.start()) + 2
        yield Block(found[1], found[2], line, note and note.groups(), end > 0 and not before.strip())
        end = found.end()


def runs(text: str) -> bool:
    """Whether a page has anything to carry out."""
    return any(b.language in ("python", "sh") and (b.note or ("",))[0] != "not run" for b in blocks(text))


def carry_out(path: Path) -> None:
    """Carry out a page in the working directory.

    Raises
    ------
    PageError
        the first place where the page is wrong.
    """
    namespace: dict = {"__name__": "__main__"}
    printed: str | None = None
    for block in blocks(path.read_text("utf-8")):
        kind, told = block.note or ("", "")
        place = f"{path.name}:{block.line}"
        if kind == "not run" or (kind == "needs" and shutil.which(told) is None):
            printed = None
        elif kind == "file":
            target = Path(told)
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_text(block.text)
        elif block.language == "python":
            printed = _python(block.text, namespace, place)
        elif block.language == "sh":
            printed = _shell(block.text, place, int(told) if kind == "status" else 0)
        elif block.language == "text" and block.follows and printed is not None:
            compare(block.text, printed, place)
            printed = None


def _python(text: str, namespace: dict, place: str) -> str:
    out = io.StringIO()
    try:
        with redirect_stdout(out):
            exec(compile(text, place, "exec"), namespace)
    except Exception:
        raise PageError(f"{place}: the code fails\n{traceback.format_exc()}") from None
    return out.getvalue()


def _shell(text: str, place: str, status: int) -> str:
    printed = []
    for line in text.replace("\\\n", " ").splitlines():
        words = shlex.split(line, comments=True)
        if not words:
            continue
        if words[0] not in STARTS:
            raise PageError(f"{place}: only gough and python commands are run, not {words[0]}; mark the block: not run")
        start = STARTS[words[0]]
        environment = os.environ | {"PYTHONIOENCODING": "utf-8"}
        done = subprocess.run([*start, *words[1:]], capture_output=True, text=True, timeout=LONGEST, env=environment)
        if done.returncode != status:
            raise PageError(f"{place}: {line}\nends with status {done.returncode}\n{done.stdout}{done.stderr}")
        printed.append(done.stdout + (done.stderr if status else ""))
    return "".join(printed)


def compare(shown: str, printed: str, place: str) -> None:
    """Hold what a page shows against what was printed.

    Raises
    ------
    PageError
        a word differs, or a number by more than 2 %.
    """
    parts = [part.split() for part in re.split(r"^ *\.\.\.\n", shown, flags=re.M)]
    words = printed.split()
    at = 0
    for number, part in enumerate(parts):
        last = number == len(parts) - 1
        if not part:
            at = len(words) if last else at
            continue
        starts = [at] if number == 0 else range(at, len(words) - len(part) + 1)
        if last and number:
            starts = [len(words) - len(part)]
        found = next((i for i in starts if _alike(part, words[i : i + len(part)])), None)
        if found is None:
            raise PageError(f"{place}: the page shows\n{shown}\nbut this is printed\n{printed}")
        at = found + len(part)
    if at != len(words):
        raise PageError(f"{place}: more is printed than the page shows\n{printed}")


def _alike(shown: list[str], printed: list[str]) -> bool:
    return len(shown) == len(printed) and all(map(_same, shown, printed))


def _same(a: str, b: str) -> bool:
    if a == b:
        return True
    try:
        x, y = float(a), float(b)
    except ValueError:
        return False
    return abs(x - y) <= 0.02 * abs(x)


def run_page(path: Path) -> subprocess.CompletedProcess:
    """Carry out a page in a process and an empty folder of its own."""
    with tempfile.TemporaryDirectory(prefix="gough-page-") as folder:
        os.symlink(ROOT / "examples", Path(folder) / "examples")
        command = [sys.executable, str(Path(__file__).resolve()), "--here", str(path.resolve())]
        return subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=LONGEST)


def main(arguments: list[str]) -> int:
    if arguments[:1] == ["--here"]:
        try:
            carry_out(Path(arguments[1]))
        except PageError as error:
            print(error, file=sys.stderr)
            return 1
        return 0
    status = 0
    for name in arguments:
        done = run_page(Path(name))
        print(f"{name}: {'done' if done.returncode == 0 else done.stderr}")
        status = max(status, done.returncode)
    return status


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
