"""The live viewer and the exported scene in a real browser, wide and narrow: they move, complain of nothing and load
nothing from elsewhere."""

from __future__ import annotations

import io
import shutil
import threading

import numpy as np
import pytest

viser = pytest.importorskip("viser", reason="viser (extra viewer) is not installed")
playwright = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
pytestmark = [pytest.mark.full, pytest.mark.skipif(CHROMIUM is None, reason="chromium is not installed")]

# three.js tells viser's authors that a class of its is old; no fault of the page
ADVICE = ("THREE.Clock", "GL Driver Message")


@pytest.fixture(scope="module")
def browser():
    with playwright.sync_playwright() as p:
        flags = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
        browser = p.chromium.launch(executable_path=CHROMIUM, args=flags)
        yield browser
        browser.close()


class Watched:
    """A page of the browser, with what it complained of and what it asked other hosts for."""

    def __init__(self, browser, address: str, width: int):
        self.page = browser.new_page(viewport={"width": width, "height": 800})
        self.complaints, self.strangers = [], []
        self.page.on("console", self._said)
        self.page.on("pageerror", lambda error: self.complaints.append(str(error)))
        self.page.on("request", lambda request: self._asked(request.url))
        self.page.goto(address)
        self.page.wait_for_selector("canvas")
        self.page.wait_for_timeout(2500)  # shaders are compiled, without a graphics card

    def _said(self, message):
        if message.type in ("error", "warning") and not any(text in message.text for text in ADVICE):
            self.complaints.append(message.text)

    def _asked(self, url: str):
        if not url.startswith(("file:", "data:", "blob:", "http://127.0.0.1", "ws://127.0.0.1")):
            self.strangers.append(url)

    def picture(self) -> np.ndarray:
        """The canvas's middle, where the machine is and neither panel nor bar."""
        from PIL import Image

        box = self.page.viewport_size
        clip = {"x": 0, "y": 170, "width": min(box["width"], 640), "height": 380}
        return np.asarray(Image.open(io.BytesIO(self.page.screenshot(clip=clip))).convert("RGB"), float)


def apart(a: np.ndarray, b: np.ndarray) -> float:
    """Share of pixels that differ by more than noise of compression."""
    return float((np.abs(a - b).max(-1) > 24).mean())


@pytest.mark.parametrize("width", [pytest.param(1280, marks=pytest.mark.slow), 400])
def test_the_exported_scene_plays_from_disk(browser, run_log, tmp_path, width):
    from gough.view.page import page
    from gough.view.scene import scene_of

    server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
    try:
        (tmp_path / "scene.html").write_text(page(server, scene_of(run_log)))
    finally:
        server.stop()
    seen = Watched(browser, f"file://{tmp_path / 'scene.html'}", width)
    seen.page.locator("button").first.click()  # pause
    field = seen.page.locator("input").first
    pictures = []
    for time in ("0", "0.5"):
        field.fill(time)
        field.press("Enter")
        seen.page.wait_for_timeout(600)
        pictures.append(seen.picture())
    assert pictures[0].std() > 5  # the canvas is not empty
    assert apart(*pictures) > 1e-3  # the machine has moved
    assert seen.page.locator("#gough-legend").is_visible()
    assert not seen.complaints and not seen.strangers
    seen.page.close()


@pytest.mark.parametrize("width", [1280, pytest.param(400, marks=pytest.mark.slow)])
def test_the_live_viewer_moves_with_its_slider_and_plays(browser, run_log, width):
    from gough.view.live import Live
    from gough.view.scene import scene_of

    server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
    live = Live(server, [scene_of(run_log)], ["pid"])
    thread = threading.Thread(target=live.run, daemon=True)
    thread.start()
    try:
        assert server.get_host() == "127.0.0.1"
        seen = Watched(browser, f"http://127.0.0.1:{server.get_port()}", width)
        first = seen.picture()
        assert first.std() > 5
        live.time.value = 0.5
        live.frame()
        seen.page.wait_for_timeout(800)
        second = seen.picture()
        assert apart(first, second) > 1e-3
        seen.page.get_by_role("button", name="Play").click()
        seen.page.wait_for_timeout(800)
        assert live.time.value > 0.5
        assert not seen.complaints and not seen.strangers
        seen.page.close()
    finally:
        live.stop()
        thread.join(5)
        server.stop()
