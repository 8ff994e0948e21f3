"""docs/linuxcnc.md: the parts and pins it names are those that are exported."""

from __future__ import annotations

from pathlib import Path

from gough.export.linuxcnc import KINDS, core

PAGE = (Path(__file__).parents[2] / "docs" / "linuxcnc.md").read_text()


def test_the_page_names_every_component_and_its_pins():
    for part in ("observer", "feedforward", "following"):
        assert f"`NAME_{part}`" in PAGE
    text = "".join(map(core.template, ("kins.c", "observer.comp", "feedforward.comp", "following.comp")))
    for pin in ("position-", "drive-", "wrench-", "force-", "tripped", "held", "gain", "kins.status", "kins.limit"):
        assert pin in PAGE and pin in text, pin
    assert len(KINDS) == 3 and all(word in PAGE for word in ("Hexapods", "hexaglides", "3-PRS"))
