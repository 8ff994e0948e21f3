"""How every command ends: its JSON object or its error lines, and its exit status."""

from __future__ import annotations

import contextlib
import json
import math
import os
import signal
import sys
import threading
import traceback
from collections.abc import Callable
from pathlib import Path
from typing import Any

from ..errors import ExperimentError, GoughError, Problem
from ..files import write_atomic
from ..names import printable

INTERRUPTED = 130
MOST_LINES = 100
LONGEST_LINE = 1000


class Interrupted(KeyboardInterrupt):
    """SIGTERM, which ends a command as Ctrl-C does."""


class Outcome:
    """What a command has to say: lines for people as it goes, fields of the JSON object, and whether it failed."""

    def __init__(self, command: str, as_json: bool):
        self.as_json = as_json
        self.data: dict[str, Any] = {"schema": f"gough-{command}-1", "status": "done", "error": None}
        self.kept = "nothing was written"  # what an interrupted command leaves
        self.rows: list[dict[str, Any]] | None = None  # printed instead of the object, unless there was an error

    def say(self, *lines: Any) -> None:
        """Print for people, on stdout; with --json on stderr."""
        for line in lines:
            print(line, file=sys.stderr if self.as_json else sys.stdout, flush=True)

    def fail(self, error: GoughError) -> None:
        """The command did what it could, and the run failed."""
        self.data.update(status="failed", error=error.to_json())
        tell(error)


def deliver(text: str, out: Path | None, force: bool, outcome: Outcome) -> bool:
    """Put the text that a command made on stdout, or into the file `out`; whether it went into a file.

    Raises
    ------
    ExperimentError
        there is a file already, and no `force`.
    """
    if out is None:
        outcome.data["text"] = text
        if not outcome.as_json:
            outcome.say(text.rstrip())
        return False
    if out.exists() and not force:
        raise ExperimentError("there is a file already", file=str(out), cure="choose another name, or add --force")
    write_atomic(out, text)
    outcome.data["file"] = str(out)
    return True


def finish(command: str, work: Callable[[Outcome], Any], as_json: bool, debug: bool, inner: bool = False) -> int:
    """Do the work of a command and return the exit status.

    `inner`: the work reads the arguments and calls a command, which has its own end; it returns that one's status.
    """
    outcome, others = Outcome(command, as_json), set(threading.enumerate())
    try:
        status = work(outcome)
        if inner:
            return status if isinstance(status, int) else 0
        status = 0 if outcome.data["status"] == "done" else 1
    except GoughError as error:
        if debug:
            traceback.print_exc()
        tell(error)
        status = error.exit_status
        outcome.data.update(status="error" if status == 2 else "failed", error=error.to_json())
    except KeyboardInterrupt as error:
        with contextlib.suppress(ValueError):  # in a thread; else: a second Ctrl-C must not disturb the end
            signal.signal(signal.SIGINT, signal.SIG_IGN)
        if debug:
            traceback.print_exc()
        text = "terminated" if isinstance(error, Interrupted) else "interrupted"
        print(f"gough: {text}; {outcome.kept}", file=sys.stderr, flush=True)
        status = INTERRUPTED
        outcome.data.update(status="failed", error={"code": "Interrupted", "problems": [{"rule": text}]})
    except BrokenPipeError:  # `gough show ... | head`
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
        return 1
    except Exception as error:
        usage = getattr(error, "format_message", None)
        if usage is not None and hasattr(error, "show"):  # typer: the arguments are wrong
            error.show()
            status = getattr(error, "exit_code", 2)
            outcome.data.update(status="error", error=ExperimentError(usage()).to_json())
        else:
            if debug:
                traceback.print_exc()
            rule = f"this is a bug in gough: {type(error).__name__}: {error}"
            print(printable(rule) + ("" if debug else "; --debug shows where"), file=sys.stderr)
            status = 1
            outcome.data.update(status="failed", error={"code": "Bug", "problems": [{"rule": rule}]})
    if as_json:
        listed = outcome.rows is not None and outcome.data["error"] is None
        print(json.dumps(plain(outcome.rows if listed else outcome.data), allow_nan=False))
        sys.stdout.flush()
    if status == INTERRUPTED and set(threading.enumerate()) - others:
        os._exit(
            status
        )  # a thread of the work, in compiled code, would keep the process for as long as its chunk lasts
    return status


def _place(problem: Problem) -> tuple[str, bool, int]:
    """Where a problem stands, to tell a file's from the top; what has no line stays last, in the order it was found."""
    return problem.file or "", problem.line is None, problem.line or 0


def tell(error: GoughError) -> None:
    """The lines of an error, on stderr; of thousands the first."""
    for problem in sorted(error.problems, key=_place)[:MOST_LINES]:
        print(printable(str(problem)[:LONGEST_LINE]), file=sys.stderr)
    if len(error.problems) > MOST_LINES:
        print(f"and {len(error.problems) - MOST_LINES} more", file=sys.stderr)
    sys.stderr.flush()


def plain(value: Any) -> Any:
    """`value` for JSON: numbers that are not finite are null."""
    if isinstance(value, dict):
        return {str(key): plain(inner) for key, inner in value.items()}
    if isinstance(value, list | tuple):
        return [plain(inner) for inner in value]
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return value if isinstance(value, str | int | bool | None) else str(value)


def show_warning(message: Any, category: Any, *_place: Any) -> None:
    """A warning as one line on stderr; takes the place of warnings.showwarning."""
    print(f"warning: {message}", file=sys.stderr, flush=True)
