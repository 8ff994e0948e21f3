"""Carries out the numbered examples and keeps the picture of each: results/gallery/NN_name.png, outside git.

    python tools/gallery.py [NN ...]

What is to be done, and which picture it leaves, says docs/gallery.md above each picture:

    :::{example} examples/01_circle_diamond_square.toml
    :command: gough run
    :picture: circle_1.png
    :::

A Python example needs neither: it draws results/NN_name.png in the folder it runs in.  A picture is drawn again when
the example, a file beside it or gough's source is another than the one it was drawn with.
"""

from __future__ import annotations

import hashlib
import json
import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "gallery.md"
FOLDER = ROOT / "results" / "gallery"
LONGEST = 300  # s, of an example
BLOCK = re.compile(r"^:::\{example\} (\S+)\n(.*?)^:::$", re.S | re.M)


class Example(NamedTuple):
    """A numbered example: its file, the command that does it, and the picture among its results."""

    file: Path
    command: tuple[str, ...]
    picture: str

    @property
    def drawn(self) -> Path:
        return FOLDER / (self.file.stem + Path(self.picture).suffix)


class ExampleError(Exception):
    """An example failed, or left no picture."""


def example(file: str, options: dict[str, str]) -> Example:
    """As the page has it: `options` are command and picture."""
    path = ROOT / file
    if path.suffix == ".py":
        return Example(path, ("python",), f"results/{path.stem}.png")
    return Example(path, tuple(options["command"].split()), f"out/{options['picture']}")


def examples() -> list[Example]:
    """Those of the page, in its order."""
    text = PAGE.read_text("utf-8")
    return [example(file, dict(re.findall(r"^:(\w+): (.*)$", told, re.M))) for file, told in BLOCK.findall(text)]


def run(one: Example, folder: Path) -> Path:
    """Do an example in `folder`; its picture there.

    Raises
    ------
    ExampleError
        it failed (what it said is in the text), or left no picture.
    """
    words = [sys.executable, *(["-m", *one.command] if one.command[0] == "gough" else [])]
    out = ["-o", "out", "--quiet"] if one.command[0] == "gough" else []
    environment = os.environ | {"PYTHONIOENCODING": "utf-8"}
    done = subprocess.run(
        [*words, str(one.file), *out], cwd=folder, capture_output=True, text=True, timeout=LONGEST, env=environment
    )
    if done.returncode:
        raise ExampleError(f"{one.file.name} ends with status {done.returncode}\n{done.stdout}{done.stderr}")
    if not (folder / one.picture).is_file():
        raise ExampleError(f"{one.file.name} leaves no {one.picture}")
    return folder / one.picture


def key(one: Example) -> str:
    """Hash of what a picture depends on."""
    digest = hashlib.sha256(repr(one.command + (one.picture,)).encode())
    beside = [path for path in one.file.parent.iterdir() if path == one.file or path.suffix == ".ngc"]
    sources = [path for path in (ROOT / "src" / "gough").rglob("*") if path.suffix in (".py", ".toml", ".mplstyle")]
    for path in sorted([*beside, *sources]):
        digest.update(path.name.encode() + b"\0" + path.read_bytes() + b"\0")
    return digest.hexdigest()


def fresh(one: Example) -> bool:
    """Whether the picture that is there was drawn with what is there now."""
    note = one.drawn.with_suffix(".json")
    return one.drawn.is_file() and note.is_file() and json.loads(note.read_text())["key"] == key(one)


def draw(one: Example) -> None:
    """Do an example and keep its picture.  Raises ExampleError as `run` does."""
    FOLDER.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix="gough-example-") as folder:
        picture = run(one, Path(folder))
        one.drawn.write_bytes(picture.read_bytes())
    one.drawn.with_suffix(".json").write_text(json.dumps({"key": key(one)}) + "\n")


def main(arguments: list[str]) -> int:
    status = 0
    for one in examples():
        if arguments and not one.file.name.startswith(tuple(arguments)):
            continue
        if not fresh(one):
            try:
                draw(one)
            except ExampleError as error:
                print(error, file=sys.stderr)
                status = 1
                continue
        print(one.drawn.relative_to(ROOT))
    return status


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
