"""gough view: the machine moving along a run, in a browser of this computer or as a page that plays from disk."""

from __future__ import annotations

import contextlib
import io
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from ..errors import ExperimentError
from ..files import write_atomic
from .end import Outcome
from .run import _logs_in


def view_files(
    paths: Sequence[Path], export: Path | None, magnify: float | None, port: int, browse: bool, force: bool,
    outcome: Outcome,
) -> None:  # fmt: skip
    """Serve the scenes of logs on 127.0.0.1 until Ctrl-C, or write the first as a page.

    Raises
    ------
    LogError
        a file is no log that can be drawn.
    ExperimentError
        viser is not installed; the page is there already; several logs for one page.
    """
    from ..log import Log

    _check_installed()
    files = [log for path in paths for log in _logs_in(path)]
    if export is not None:
        if export.exists() and not force:
            raise ExperimentError(
                "there is a file already", file=str(export), cure="choose another name, or add --force"
            )
        if len(files) > 1:
            names = ", ".join(str(file) for file in files)
            raise ExperimentError("a page holds one run", key="RESULT", value=names, cure=f"name one: {files[0]}")
    if magnify is not None and not 1 <= magnify <= 1e9:
        raise ExperimentError("must be from 1 to 1e9", key="--magnify", value=f"{magnify:g}")
    from ..view.scene import scene_of

    scenes = [scene_of(Log.load(file)) for file in files]
    if export is not None:
        _export(scenes[0], export, magnify, outcome)
    else:
        _serve(scenes, [file.stem for file in files], port, browse, magnify, outcome)


def _export(scene, export: Path, magnify: float | None, outcome: Outcome) -> None:
    from ..view.page import page

    with _server(0) as server:
        text = page(server, scene, magnify)
    write_atomic(export, text)
    outcome.data["file"] = str(export)
    if not outcome.as_json:
        outcome.say(f"scene: {export}")
    report = export.parent / "report.html"
    if report.is_file():
        _link(report, export.name, outcome)


def _link(report: Path, name: str, outcome: Outcome) -> None:
    """Link the scene in the report beside it."""
    from html import escape

    from ..report.sections import SCENE as MARK

    text = report.read_text("utf-8")
    if MARK in text and "/" not in name:
        link = f'<p class="note"><a href="{escape(name, quote=True)}">The machine moving along this run</a></p>'
        write_atomic(report, text.replace(MARK, MARK + link, 1) if link not in text else text)
        if not outcome.as_json:
            outcome.say(f"linked in: {report}")


def _serve(scenes, names, port: int, browse: bool, magnify: float | None, outcome: Outcome) -> None:
    from ..view.live import Live

    with _server(port) as server:
        live = Live(server, scenes, names, magnify)
        address = f"http://127.0.0.1:{server.get_port()}"
        outcome.data["address"] = address
        outcome.say(f"{scenes[0].title}: {address}   (Ctrl-C ends it)")
        if browse:
            import webbrowser

            webbrowser.open(address)
        live.run()


@contextlib.contextmanager
def _server(port: int) -> Iterator[Any]:
    """A viser server on 127.0.0.1 that keeps quiet; port 0 is any."""
    import viser

    with contextlib.redirect_stdout(io.StringIO()):  # its banner: commands say themselves what they did
        server = viser.ViserServer(host="127.0.0.1", port=port, label="gough", verbose=False)
    try:
        yield server
    finally:
        with contextlib.redirect_stdout(io.StringIO()):
            server.stop()
        sys.stdout.flush()


def _check_installed() -> None:
    from importlib.util import find_spec

    if find_spec("viser") is None:
        raise ExperimentError("the viewer is not installed", key="gough view", cure="pip install 'gough[viewer]'")
