"""Comments of NC programs: where they stand, and what they ask for."""

from __future__ import annotations

import re

from ...errors import ProgramError
from .expressions import show

# comments that would run something; LinuxCNC takes ";py,..." too
_RUNS = re.compile(r";?\s*(PY\s*,|PYRUN\s*,|PYRELOAD\s*$)", re.I)
_ABORT = re.compile(r"ABORT,(.*)", re.I | re.S)
_MESSAGE = re.compile(r"MSG,(.*)", re.I | re.S)


def without_comments(text: str) -> tuple[str, str | None]:
    """The line with "()" for each comment in brackets, and the text of the last one."""
    if "(" not in text:
        code, semicolon, comment = text.partition(";")
        return code, (";" + comment) if semicolon else None
    out, at, last = [], 0, None
    while True:
        begin, semicolon = text.find("(", at), text.find(";", at)
        if semicolon >= 0 and (begin < 0 or semicolon < begin):
            out.append(text[at:semicolon])
            return "".join(out), last or text[semicolon:]
        if begin < 0:
            out.append(text[at:])
            return "".join(out), last
        end = text.find(")", begin)
        if end < 0:
            raise ProgramError("a comment is not closed", value=show(text[begin:]), cure='write ")" at its end')
        last = text[begin + 1 : end]
        if "(" in last:
            written = show(text[begin : end + 1])
            raise ProgramError("a comment inside a comment", value=written, cure='remove the second "("')
        out += (text[at:begin], "()")
        at = end + 1


def asked(last: str | None) -> dict[str, str | None]:
    """What the last comment of a line asks for; LinuxCNC looks at no other."""
    last = (last or "").strip()
    if _RUNS.match(last):
        raise ProgramError("a comment that runs a script is not supported", value=show(f"({last})"), cure="remove it")
    if last.startswith(";"):
        return {}
    stop, message = _ABORT.match(last), _MESSAGE.match(last)
    return {"comment": message and message[1].strip(), "stop": stop and stop[1].strip()}
