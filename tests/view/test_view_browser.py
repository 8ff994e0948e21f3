"""The live viewer and the exported scene in a real browser, wide and narrow: they move, complain of nothing and load
nothing from elsewhere."""

from __future__ import annotations

import threading

import pytest

from browsing import CHROMIUM, WIDTHS, Watched, apart, chromium

viser = pytest.importorskip("viser", reason="viser (extra viewer) is not installed")
pytest.importorskip("playwright", reason="playwright is not installed")
pytestmark = [pytest.mark.full, pytest.mark.skipif(CHROMIUM is None, reason="chromium is not installed")]


@pytest.fixture(scope="module")
def browser():
    with chromium() as found:
        yield found


@pytest.fixture
def server():
    found = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
    yield found
    found.stop()


def test_the_exported_scene_plays_from_disk(browser, server, run_log, tmp_path):
    from gough.view.page import page
    from gough.view.scene import scene_of

    (tmp_path / "scene.html").write_text(page(server, scene_of(run_log)))
    seen = Watched(browser, f"file://{tmp_path / 'scene.html'}")
    seen.drawn()
    seen.page.locator("button").first.click()  # pause
    field = seen.page.locator("input").first
    for width in WIDTHS:
        seen.resize(width)
        pictures = []
        for time in ("0", "0.5"):
            field.fill(time)
            field.press("Enter")
            seen.page.wait_for_timeout(600)
            pictures.append(seen.picture())
        assert pictures[0].std() > 5, f"the canvas is empty, {width} px"
        assert apart(*pictures) > 1e-3, f"the machine has not moved, {width} px"
        assert seen.page.locator("#gough-legend").is_visible()
        assert seen.overflow <= 0
    assert not seen.complaints and not seen.strangers
    seen.page.close()


def test_the_live_viewer_moves_with_its_slider_and_plays(browser, server, run_log):
    from gough.view.live import Live
    from gough.view.scene import scene_of

    live = Live(server, [scene_of(run_log)], ["pid"])
    thread = threading.Thread(target=live.run, daemon=True)
    thread.start()
    try:
        assert server.get_host() == "127.0.0.1"
        seen = Watched(browser, f"http://127.0.0.1:{server.get_port()}")
        seen.drawn()
        for width in WIDTHS:
            seen.resize(width)
            pictures = []
            for key, time in (("End", live.time.max), ("Home", 0.0)):  # in the browser, on the slider of time
                seen.page.locator("[role=slider]").first.focus()
                seen.page.keyboard.press(key)
                seen.page.wait_for_timeout(800)
                assert live.time.value == pytest.approx(time, abs=live.time.step)
                pictures.append(seen.picture())
            live.time.value = 0.5  # the circle's end is its beginning
            live.frame()
            seen.page.wait_for_timeout(800)
            pictures[0] = seen.picture()
            assert seen.overflow <= 0
            assert pictures[0].std() > 5, f"the canvas is empty, {width} px"
            assert apart(*pictures) > 1e-3, f"the machine has not moved, {width} px"
        seen.resize(WIDTHS[0])
        seen.page.get_by_role("button", name="Play").click()
        seen.page.wait_for_timeout(800)
        assert live.time.value > 0.5
        assert not seen.complaints and not seen.strangers
        seen.page.close()
    finally:
        live.stop()
        thread.join(5)
