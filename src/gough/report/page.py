"""The page of a report: one HTML file that holds all it shows and loads nothing, so it opens anywhere and for years.

Every text from outside is escaped; scripts are named by their hash in the page's content security policy, so that
nothing else can run even if an escape were forgotten, and nothing can be fetched.
"""

from __future__ import annotations

import base64
import hashlib
import json
import re
from collections.abc import Iterable, Mapping
from html import escape
from pathlib import Path

from ..files import write_atomic
from ..log import Log
from . import inputs, sections
from .prepare import as_logs
from .table import failed_at, names, verdict

_HERE = Path(__file__).parent
MOST_WARNINGS = 12  # of a controller; the log holds all


def report(logs: Log | Iterable[Log], folder: str | Path, files: Mapping[str, str] | None = None) -> Path:
    """Write report.html and the figures as PNG into `folder`; the path of the page.

    Parameters
    ----------
    logs : one log, or several to set side by side.
    folder : made if it is not there.
    files : texts to show among the inputs by name, such as the resolved experiment file.

    Raises
    ------
    LogError
        there is no log.
    StorageError
        a file could not be written.
    """
    from .figures import save_all

    logs = as_logs(logs)
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    save_all(logs, folder)
    return write_atomic(folder / "report.html", page(logs, files))


def page(logs: Log | Iterable[Log], files: Mapping[str, str] | None = None) -> str:
    """The text of the page; see `report`."""
    logs = as_logs(logs)
    charts: dict[str, dict] = {}
    parts = [*sections.build(logs, charts), inputs.section(logs, files or {})]
    parts = [part for part in parts if part is not None]
    plotly, js = _script("plotly"), _script("page.js")
    hashes = " ".join(f"'sha256-{_hash(text)}'" for text in (plotly, js))
    policy = f"default-src 'none'; script-src {hashes}; style-src 'unsafe-inline'; img-src data: blob:; font-src data:"
    policy += "; base-uri 'none'; form-action 'none'"
    return _fill(
        (_HERE / "template.html").read_text("utf-8"),
        {
            "policy": policy,
            "title": escape(_title(logs)),
            "kicker": escape(_kicker(logs)),
            "banner": _banner(logs) + _warnings(logs),
            "verdict": escape(verdict(logs)),
            "contents": "".join(f'<a href="#{part.id}">{escape(part.heading)}</a>' for part in parts),
            "sections": "\n".join(part.html() for part in parts),
            "charts": _json(charts),
            "version": escape(str(logs[0].info.get("version") or "")),
            "css": (_HERE / "page.css").read_text("utf-8"),
            "plotly": plotly,
            "js": js,
        },
    )


def _title(logs: list[Log]) -> str:
    names = [str(_table(log, "program").get("name") or "") for log in logs]
    return ", ".join(dict.fromkeys(filter(None, names))) or "Report"


def _kicker(logs: list[Log]) -> str:
    machines = ", ".join(dict.fromkeys(str(log.info.get("machine_name") or "") for log in logs)).strip(", ")
    return " · ".join(filter(None, [machines, " and ".join(names(logs))]))


def _banner(logs: list[Log]) -> str:
    return "".join(
        f'<div class="failed" role="alert"><strong>{escape(failed_at(log))}</strong> {escape(name)}: '
        f"{escape(log.reason or 'no reason given')}</div>\n"
        for name, log in zip(names(logs), logs, strict=True)
        if log.failed
    )


def _warnings(logs: list[Log]) -> str:
    """A box for each controller that the simulation warned of; logs of before it did have none."""
    out = []
    for name, log in zip(names(logs), logs, strict=True):
        found = log.info.get("warnings")
        texts = [str(text) for text in found if text] if isinstance(found, list) else []
        if not texts:
            continue
        if len(texts) > MOST_WARNINGS:
            texts[MOST_WARNINGS:] = [f"{len(texts) - MOST_WARNINGS} more, in the log: log.info"]
        items = "".join(f"<li>{escape(text)}</li>" for text in texts)
        out.append(f'<div class="warned" role="note"><strong>Warned</strong> {escape(name)}<ul>{items}</ul></div>\n')
    return "".join(out)


def _table(log: Log, key: str) -> dict:
    value = log.info.get(key)
    return value if isinstance(value, dict) else {}


def _script(name: str) -> str:
    """The text of a script, with the line ends that a browser makes of any, because its hash is taken of those."""
    if name == "plotly":
        from plotly.offline import get_plotlyjs

        text = get_plotlyjs()
    else:
        text = (_HERE / name).read_text("utf-8")
    text = text.replace("\r\n", "\n").replace("\r", "\n")
    # neither may end the element early; both are the same inside strings of JavaScript
    return text.replace("</script", "<\\/script").replace("<!--", "<\\!--")


def _hash(text: str) -> str:
    return base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()


def _json(data: object) -> str:
    text = json.dumps(data, allow_nan=False, separators=(",", ":"))
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def _fill(template: str, values: Mapping[str, str]) -> str:
    """Every {{name}} of the template by its value, in one pass: braces inside values stay as they are."""
    return re.sub(r"\{\{(\w+)\}\}", lambda match: values[match[1]], template)
