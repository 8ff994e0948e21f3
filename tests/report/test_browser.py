"""The page in a real browser, wide and narrow: every chart is drawn, nothing is complained of, nothing is loaded."""

from __future__ import annotations

import numpy as np
import pytest

import gough as gk
from browsing import CHROMIUM, WIDTHS, Watched, chromium

pytest.importorskip("playwright", reason="playwright is not installed")
pytestmark = [pytest.mark.full, pytest.mark.skipif(CHROMIUM is None, reason="chromium is not installed")]

CHARTS = 7  # two paths, one circle, one error over time, two forces, the machine
SCROLL = "window.scrollTo(0, {} * document.documentElement.scrollHeight)"
DRAWN = "[...document.querySelectorAll('.js-plotly-plot')].filter(e => e.querySelector('.main-svg')).length"
WIDEST = "Math.max(...[...document.querySelectorAll('.js-plotly-plot')].map(e => e.getBoundingClientRect().right))"


def test_the_page_draws_every_chart_and_complains_of_nothing(tmp_path):
    machine = gk.load_machine("nist-octahedral")
    program = gk.Circle(radius=0.02, feed=0.1)
    logs = [gk.simulate(machine, law, program) for law in (gk.PID(bandwidth=12.0), gk.ComputedTorque(bandwidth=16.0))]
    page = gk.report(logs, tmp_path)
    with chromium() as browser:
        seen = Watched(browser, f"file://{page}")
        for share in np.linspace(0, 1, 9):  # charts are drawn when they come into view
            seen.page.evaluate(SCROLL.format(share))
            seen.page.wait_for_timeout(150)
        seen.page.wait_for_function(f"{DRAWN} === {CHARTS}", timeout=60_000)
        for width in WIDTHS:
            seen.resize(width)
            assert seen.overflow <= 0, f"{width} px: the page is wider than its window"
            assert seen.page.evaluate(WIDEST) <= width
        dom = seen.page.content()
        assert not seen.complaints and not seen.strangers
    assert f"{1e6 * logs[0].metrics['contour_error']['max']:.3g}"[:3] in dom
    assert np.isfinite(logs[1].metrics["contour_error"]["rms"])
