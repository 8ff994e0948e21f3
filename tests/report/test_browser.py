"""The page in a real browser: every chart is drawn, nothing is complained of, nothing is loaded."""

from __future__ import annotations

import re
import shutil
import subprocess

import numpy as np
import pytest

import gough as gk

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
FLAGS = [
    *(
        "--headless=new",
        "--no-sandbox",
        "--disable-gpu",
        "--disable-background-networking",
        "--disable-component-update",
    ),
    *("--disable-sync", "--no-first-run", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"),
    *("--virtual-time-budget=15000", "--enable-logging=stderr", "--v=0", "--dump-dom"),
    "--window-size=1280,6000",  # charts are drawn when they come into view
]

# on the speed of plotly's 3-D canvas without a graphics card; no complaint of the page
ADVICE = ("Canvas2D: Multiple readback", "GL Driver Message (OpenGL, Performance")

pytestmark = [pytest.mark.full, pytest.mark.skipif(CHROMIUM is None, reason="chromium is not installed")]


def test_the_page_draws_every_chart_and_complains_of_nothing(tmp_path):
    machine = gk.load_machine("nist-octahedral")
    program = gk.Circle(radius=0.02, feed=0.1)
    logs = [gk.simulate(machine, law, program) for law in (gk.PID(bandwidth=12.0), gk.ComputedTorque(bandwidth=16.0))]
    page = gk.report(logs, tmp_path)
    done = subprocess.run(
        [CHROMIUM, *FLAGS, f"--user-data-dir={tmp_path / 'profile'}", f"file://{page}"],
        capture_output=True, text=True, timeout=120,
    )  # fmt: skip
    dom = done.stdout
    # two paths, one circle, one error over time, two forces, the machine
    assert len(re.findall(r'class="[^"]*js-plotly-plot', dom)) == 7
    assert dom.count("main-svg") >= 7
    said = [line for line in done.stderr.splitlines() if "CONSOLE" in line]
    complaints = [line for line in said if not any(advice in line for advice in ADVICE)]
    assert not complaints, complaints
    assert f"{1e6 * logs[0].metrics['contour_error']['max']:.3g}"[:3] in dom
    assert np.isfinite(logs[1].metrics["contour_error"]["rms"])
