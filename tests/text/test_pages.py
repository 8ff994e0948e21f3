"""Every page of docs is carried out as a reader would, and the documentation builds without a warning."""

from __future__ import annotations

import importlib.util
import os
import subprocess
import sys
from contextlib import nullcontext
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
_spec = importlib.util.spec_from_file_location("pages", ROOT / "tools" / "pages.py")
pages = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(pages)
PAGES = sorted(p for p in (ROOT / "docs").rglob("*.md") if "_build" not in p.parts)


# howto/cluster and howto/linuxcnc start one and the other, as tests/sweep/test_cluster.py and tests/linuxcnc_runs do
@pytest.mark.full("[!h]*.md", "howto/law.md", "howto/log.md", "howto/machine.md", "howto/program.md")
@pytest.mark.parametrize(
    "path", [p for p in PAGES if pages.runs(p.read_text("utf-8"))], ids=lambda p: str(p.relative_to(ROOT / "docs"))
)
def test_the_page_does_what_it_says(path):
    with _turn(path):
        done = pages.run_page(path)
    assert done.returncode == 0, done.stderr


def _turn(path):
    """A page that runs LinuxCNC does not do so beside a test that looks for what LinuxCNC leaves running."""
    if "needs: linuxcnc" not in path.read_text("utf-8"):
        return nullcontext()
    from linuxcnc_runs.machines import turn

    return turn()


def test_every_page_is_in_the_contents():
    index = (ROOT / "docs" / "index.md").read_text("utf-8")
    listed = {line.strip() for line in index.splitlines()}
    for path in PAGES:
        name = str(path.relative_to(ROOT / "docs").with_suffix(""))
        assert name == "index" or name.startswith("theory/") or name in listed, f"docs/index.md does not list {name}"


@pytest.mark.full
def test_the_documentation_builds_without_a_warning(tmp_path):
    pytest.importorskip("sphinx", reason="sphinx (extra docs) is not installed")
    command = [sys.executable, "-m", "sphinx", "-q", "-W", "--keep-going", "-b", "html", "docs", str(tmp_path / "out")]
    done = subprocess.run(
        [*command, "-d", str(tmp_path / "trees")], cwd=ROOT, capture_output=True, text=True,
        env=os.environ | {"GOUGH_DOCS": "quick"},
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "out" / "tutorial.html").is_file()


def carried_out(tmp_path, text: str) -> str:
    page = tmp_path / "page.md"
    page.write_text(text)
    return pages.run_page(page).stderr


@pytest.mark.parametrize(
    "text, said",
    [
        ("```python\nprint(1 / 0)\n```\n", "ZeroDivisionError"),
        ("```python\nprint('a 1.00')\n```\n```text\na 1.05\n```\n", "but this is printed"),
        ("```python\nprint('a')\nprint('b')\n```\n```text\na\n```\n", "more is printed"),
        ("```sh\nls\n```\n", "only gough and python"),
        ("```sh\ngough explain Nothing\n```\n", "ends with status 2"),
    ],
)
def test_a_page_that_is_wrong_is_found(tmp_path, text, said):
    assert said in carried_out(tmp_path, text)


@pytest.mark.parametrize(
    "text",
    [
        "<!-- needs: no-such-program -->\n```sh\nmake nothing\n```\n```text\nnothing\n```\n",
        "```python\nprint('a 1.00 b')\n```\n```text\na 1.01 b\n```\n",
        "```python\nprint('a\\nx\\ny\\nb')\n```\n```text\na\n...\nb\n```\n",
        "<!-- status: 2 -->\n```sh\ngough explain Nothing\n```\n",
        "<!-- not run: why -->\n```sh\nrm nothing\n```\n",
        "<!-- file: a.txt -->\n```\nhello\n```\n\n```python\nprint(open('a.txt').read())\n```\n```text\nhello\n```\n",
    ],
)
def test_a_page_that_is_right_is_not(tmp_path, text):
    assert carried_out(tmp_path, text) == ""
