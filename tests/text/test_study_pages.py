"""docs/studies: every page says what its paper claims, what came out, what differs and why; and shows the study."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

from gough.study import PAPERS

ROOT = Path(__file__).parents[2]
PARTS = (
    "What the paper claims", "What is taken for what the paper does not print", "What comes out",
    "What differs, and why", "Figures and rows",
)  # fmt: skip


def page(paper: str) -> str:
    return (ROOT / "docs" / "studies" / f"{paper}.md").read_text("utf-8")


@pytest.mark.parametrize("paper", PAPERS)
def test_the_page_has_its_parts_in_order_and_shows_rows_and_figures(paper):
    heads = re.findall(r"^###? (.*)$", page(paper), re.M)
    places = [next((i for i, head in enumerate(heads) if head.startswith(part)), None) for part in PARTS]
    assert None not in places and places == sorted(places), dict(zip(PARTS, places, strict=True))
    assert f":::{{study}} {paper}\n:::" in page(paper)


def um(value: float) -> str:
    return f"{1e6 * value:.0f}"


def mm(digits: int):
    return lambda value: f"{1e3 * value:.{digits}f} mm"


# paper: (claim, how the page writes its number, the words around it)
SHOWN = {
    "garagic2004": [
        ("CCTPID, 4 kHz and 0.1 um: mean of the large glitches", lambda v: f"6 of {1e6 * v:.1f} um, at long"),
        ("CCTPID, 4 kHz and 0.1 um: mean of the small glitches", lambda v: f"6 of {1e6 * v:.1f} um, at short"),
        ("CDAC, 4 kHz and 0.1 um: largest glitch", lambda v: f"| {1e6 * v:.1f} um, 1.3 um"),
        ("FCDAC, 1 kHz and 1 um: contour error with the start", lambda v: f"0.4 um, {1e6 * v:.1f} um, 0.058'"),
        ("corner, CCTPID, 1 kHz and 1 um: largest of the phases", lambda v: f"267 to {um(v)} um"),
        ("corner, CDAC, 4 kHz and 0.1 um: contour error", lambda v: f"| {um(v)} to 180 um: different by design"),
        ("corner, CDAC, 10 kHz, K_D / M = 5000 1/s: contour error", lambda v: f"{1e6 * v:.1f} (on a sample)"),
        ("corner, CDAC, 10 kHz, previewed, at most 300 N m", lambda v: f"| 183 | {um(v)} | 31"),
    ],
    "honegger1998": [
        ("circle, PD, 0.3 m/s: max", lambda v: f"| 33, {um(v)}, 83, 35 |"),
        ("circle, PD, 0.4 m/s: mean", lambda v: f"| 59, 242, {um(v)}, 64 |"),
        ("circle, computed torque, 0.4 m/s: mean", lambda v: f"| 13 | {1e6 * v:.1f} |"),
        ("circle, 0.4 m/s: mean error of PD over computed torque", lambda v: f'"about 10" | {v:.1f} |'),
        ("learned from translation: time until all stay within 5 %", lambda v: f"from {v / 60:.1f} min on"),
        ("learned with turns of +-8 deg: platform.Izz", lambda v: f"7.37, 7.62, {v:.2f} |"),
        ("friction drifts: its farthest estimate from the truth", lambda v: f"| {100 * v:.1f} %, 1.7 % |"),
    ],
    "bouzgarrou2001": [
        ("rigid, low gains, PID: error of s21", lambda v: f"| {mm(2)(v)}, rigid |"),
        ("rigid, high gains, PID: error of s21", lambda v: f"| {mm(3)(v)}, rigid |"),
        ("rigid, low gains, computed torque at 50 us: error", lambda v: f"| {1e6 * v:.1f} um, 1.7 um |"),
        ("flexible, low gains, PID: error of s21", lambda v: f"**{mm(3)(v)}, not met**"),
        ("flexible, high gains, computed torque: error of s21", lambda v: f"**{mm(3)(v)}, not met**"),
        ("static error along y at the end", lambda v: f"| {mm(3)(v)}, alike"),
        ("section 3.3 as printed: what a turn multiplies an error of delta by", lambda v: f"of delta by {v:.0f} and"),
        ("greatest force of a motor in all flexible runs", lambda v: f"| {v / 1e3:.1f}, 6.0, 6.4 kN |"),
    ],
    "okuda2006": [
        ("Fig. 5, tilt 0 deg: worst strut, rms error of the torque over its range", lambda v: f"| {100 * v:.1f} % unt"),
        ("tilting changes the mean torque of a strut by, over its range untilted, most", lambda v: f"| {v:.1f}; two"),
        ("Fig. 6, load in X: largest error of the loaded component", lambda v: f"| {v:.0f} N in X, 75 N in Y |"),
        ("Fig. 6, load in Y: error's share at 3.5 kN over that at 0.5 kN", lambda v: f"| 0.05 in X, {v:.2f} in Y |"),
        ("the same: identified m_S", lambda v: f"10.7 N | {v:.1f}"),
        ("Table 3, 0.6 mm: mean normal force told from the drives", lambda v: f"| 35, {v:.0f}, 90 N |"),
        ("beyond the paper, in the loop: way behind a step until the wall at the tip is within a third",
         lambda v: f"needs {1e3 * v:.0f} mm until"),
    ],
}  # fmt: skip


def assert_shown(paper: str, rows: list[dict]) -> None:
    """The numbers of `gough reproduce --json` stand in the page, in the words around them."""
    text = page(paper)
    assert f"{len(rows)} rows" in text
    measured = {row["claim"]: row["measured"] for row in rows}
    for claim, written in SHOWN[paper]:
        assert written(measured[claim]) in text, f"{claim}: the study has {measured[claim]:.4g}"


@pytest.mark.slow
@pytest.mark.parametrize("paper", SHOWN)  # chen2008: tests/study/test_chen_parts.py reads its whole table
def test_the_numbers_of_the_page_are_those_of_the_study(paper, tmp_path):
    command = [sys.executable, "-m", "gough", "reproduce", paper, "--json", "--quiet", "--out", str(tmp_path / "out")]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode in (0, 1), done.stderr  # 1: a row is not met, and the page says so
    assert_shown(paper, json.loads(done.stdout))
