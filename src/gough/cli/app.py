"""The command line: what can be asked, and how it ends.

    gough run FILE       simulate an experiment or an NC program, write logs and a report
    gough sweep FILE     the runs that its [sweep] table asks for, and what they come to together
    gough check FILE     find every mistake of an experiment, a data sheet or an NC program
    gough preflight P    what a program asks of a machine's joints; feeds they can follow; where to clamp the work
    gough report LOG...  the report of logs that are there
    gough view RESULT    the machine moving along a run, in the browser
    gough monitor LOG    the force on the tool out of a recorded log
    gough compensate P   an NC program again, its tool leaning against the force that a log of it shows
    gough identify LOG   what a log says of a machine's parameters
    gough reproduce P    a published experiment again, and its claims held against ours
    gough map M          what a machine can do over its workspace
    gough envelope M     how far from a pose in every direction
    gough export M       a machine for another program
    gough linuxcnc run P an NC program run by LinuxCNC itself, and simulated as it commands
    gough machines, show, new

Exit status: 0 done, 1 the run failed, 2 the input is wrong, 130 interrupted.  What a command does stands in the module
of its name; it is imported when it is called, so that `gough --help` stays quick.
"""

from __future__ import annotations

import signal
import sys

from . import ask_run, ask_judge, ask_log, ask_machine  # noqa: F401  # isort: skip  (in the order of the help)
from .ask import app
from .end import Interrupted, Outcome, finish


def main(arguments: list[str] | None = None) -> None:
    """What the command `gough` does.  Ends by SystemExit."""
    arguments = sys.argv[1:] if arguments is None else arguments
    signal.signal(signal.SIGTERM, _terminate)
    for stream in (sys.stdout, sys.stderr):
        stream.reconfigure(errors="backslashreplace")  # a terminal without µ gets an escape, not a traceback

    def call(_outcome: Outcome) -> int:
        return app(arguments, prog_name="gough", standalone_mode=False)

    known = {command.callback.__name__.rstrip("_") for command in app.registered_commands if command.callback}
    known |= {group.name for group in app.registered_groups if group.name}
    name = next((word for word in arguments if word in known), "arguments")
    sys.exit(finish(name, call, "--json" in arguments, "--debug" in arguments, inner=True))


def _terminate(_number: int, _frame: object) -> None:
    raise Interrupted("terminated")


if __name__ == "__main__":
    main()
