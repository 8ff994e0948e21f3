"""A real browser for the tests of pages: what a page complains of, and what it asks other hosts for."""

from __future__ import annotations

import contextlib
import io
import shutil

import numpy as np

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
FLAGS = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
WIDTHS = (1280, 400)  # a screen and a telephone
# no fault of a page: three.js tells viser's authors that a class of its is old, and what is slow without graphics card
ADVICE = ("THREE.Clock", "GL Driver Message", "Canvas2D: Multiple readback")
OURS = ("file:", "data:", "blob:", "http://127.0.0.1", "ws://127.0.0.1")


@contextlib.contextmanager
def chromium():
    """Chromium without a window."""
    from playwright.sync_api import sync_playwright

    with sync_playwright() as p:
        browser = p.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        yield browser
        browser.close()


class Watched:
    """A page of a browser, with what it complained of and what it asked other hosts for."""

    def __init__(self, browser, address: str, width: int = WIDTHS[0]):
        self.page = browser.new_page(viewport={"width": width, "height": 560})
        self.complaints, self.strangers = [], []
        self.page.on("console", self._said)
        self.page.on("pageerror", lambda error: self.complaints.append(str(error)))
        self.page.on("request", lambda request: self._asked(request.url))
        self.page.goto(address)

    def drawn(self) -> None:
        """Wait for the first picture of a canvas; shaders are compiled, without a graphics card."""
        self.page.wait_for_selector("canvas")
        self.page.wait_for_timeout(2500)

    def resize(self, width: int) -> None:
        self.page.set_viewport_size({"width": width, "height": 560})
        self.page.wait_for_timeout(600)

    def _said(self, message) -> None:
        if message.type in ("error", "warning") and not any(text in message.text for text in ADVICE):
            self.complaints.append(message.text)

    def _asked(self, url: str) -> None:
        if not url.startswith(OURS):
            self.strangers.append(url)

    @property
    def overflow(self) -> float:
        """How far the page is wider than the window, px."""
        return self.page.evaluate("document.documentElement.scrollWidth - window.innerWidth")

    def picture(self) -> np.ndarray:
        """The canvas's middle, where the machine is and neither panel nor bar."""
        from PIL import Image

        box = self.page.viewport_size
        clip = {"x": 0, "y": 170, "width": min(box["width"], 640), "height": 380}
        return np.asarray(Image.open(io.BytesIO(self.page.screenshot(clip=clip))).convert("RGB"), float)


def apart(a: np.ndarray, b: np.ndarray) -> float:
    """Share of pixels that differ by more than noise of compression."""
    return float((np.abs(a - b).max(-1) > 24).mean())
