"""docs/gallery.md: every numbered example is shown, carried out, asserts something physical and draws its picture."""

from __future__ import annotations

import importlib.util
import json
import re
from itertools import product
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

from gough.log import Log

ROOT = Path(__file__).parents[2]
_spec = importlib.util.spec_from_file_location("gallery", ROOT / "tools" / "gallery.py")
gallery = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(gallery)
PAGE = gallery.PAGE.read_text("utf-8")
EXAMPLES = gallery.examples()
LAWS = ("pid", "computed_torque")


def test_every_numbered_example_is_shown_once_in_order_under_its_number():
    files = [path for path in (ROOT / "examples").glob("[0-9]*") if path.suffix in (".py", ".toml")]
    assert [one.file for one in EXAMPLES] == sorted(files)
    for number, one in enumerate(EXAMPLES, 1):
        head = rf"^## {number:02} [A-Z].*\n\n([^\n]+\n){{1,3}}\n:::\{{example\}} examples/{one.file.name}$"
        assert re.search(head, PAGE, re.M), f"{one.file.name}: a heading, one to three lines, its picture"


# 01 is the demo of test_readme.py; 04, 07 and 10 to 12 take longer
@pytest.mark.full("0[235689]*", "13*", "14*")
@pytest.mark.parametrize("one", EXAMPLES, ids=lambda one: one.file.stem)
def test_the_example_runs_what_it_asserts_holds_and_its_picture_shows_something(one, tmp_path):
    picture = gallery.run(one, tmp_path)
    if one.file.suffix == ".py":
        assert re.search(r"^ *assert ", one.file.read_text(), re.M), "an example asserts something physical"
    else:
        ASSERTS[one.file.stem](tmp_path / "out")
    if picture.suffix == ".svg":
        assert len(ElementTree.parse(picture).findall(".//{http://www.w3.org/2000/svg}use")) > 50
        return
    from matplotlib.image import imread

    image = imread(picture)[..., :3]
    assert min(image.shape[:2]) >= 500
    inked = (image < 0.97).any(-1)
    assert 0.01 < inked.mean() < 0.9 and inked.any(0).mean() > 0.9 and inked.any(1).mean() > 0.8, "fills its frame"


def asserts_01(out: Path) -> None:
    """What friction leaves at reversals a model makes smaller: three times, where the gains of both are sound."""
    worst = {name: Log.load(out / f"{name}.nc").metrics["contour_error"]["max"] for name in LAWS}
    assert worst["computed_torque"] < worst["pid"] / 3


def asserts_04(out: Path) -> None:
    """G64 P0.02: the tool is nowhere farther from the programmed path than that."""
    log = Log.load(out / "computed_torque.nc")
    assert log.metrics["contour_error"]["max"] < 20e-6 < log["contour_error"].max() + 10e-6, "and it uses some of it"


def asserts_11(out: Path) -> None:
    """At every bandwidth the worst of a hundred machines under computed torque is better than the best under PID."""
    runs = [json.loads(path.read_text()) for path in out.glob("runs/*/*.json")]
    assert len(runs) == 600 and {run["status"] for run in runs} == {"done"}
    error = {}
    for run in runs:
        law = run["controller"]
        of = error.setdefault((law, run["settings"][f"controller.{law}.bandwidth"]), [])
        of.append(run["metrics"]["contour_error.max"])
    widths = ("8 Hz", "10 Hz", "12 Hz")
    assert set(error) == set(product((0, 1), widths)) and {len(values) for values in error.values()} == {100}
    for width in widths:
        assert max(error[1, width]) < min(error[0, width])
    for law in (0, 1):
        assert np.all(np.diff([np.median(error[law, width]) for width in widths]) < 0), "quicker is nearer"


def asserts_12(out: Path) -> None:
    """Ten times better on machines that the search never saw, and no drive is ever at its limit."""
    told = json.loads((out / "tuning.json").read_text())
    tuned, unseen = told["tuned"], told["held_out"]
    assert tuned["saturated"] == 0.0 and tuned["overshoot"] < 50e-6
    assert unseen["tuned"]["goal"] < unseen["before"]["goal"] / 10
    assert unseen["tuned"]["goal"] < 1.2 * tuned["goal"], "what was learned was not these eight machines"


ASSERTS = {
    "01_circle_diamond_square": asserts_01,
    "04_pockets": asserts_04,
    "11_drawn_machines": asserts_11,
    "12_tuned": asserts_12,
}


def test_an_example_that_fails_or_leaves_no_picture_is_told(tmp_path):
    for text, said in (("assert 1 > 2, 'no'", "AssertionError: no"), ("print(1)", "leaves no results/99_x.png")):
        file = tmp_path / "99_x.py"
        file.write_text(text)
        with pytest.raises(gallery.ExampleError, match=said):
            gallery.run(gallery.example(str(file), {}), tmp_path)


def test_a_picture_is_drawn_again_when_its_example_is_another(tmp_path, monkeypatch):
    file = tmp_path / "99_x.py"
    file.write_text("from pathlib import Path\nPath('results').mkdir()\nPath('results/99_x.png').write_bytes(b'one')\n")
    monkeypatch.setattr(gallery, "FOLDER", tmp_path / "kept")
    one = gallery.example(str(file), {})
    assert not gallery.fresh(one)
    gallery.draw(one)
    assert gallery.fresh(one) and one.drawn.read_bytes() == b"one"
    file.write_text(file.read_text().replace("one", "two"))
    assert not gallery.fresh(one)
