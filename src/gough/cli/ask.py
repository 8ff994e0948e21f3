"""The command line as a whole, and the options that many commands have.  The commands: ask_*.py."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated

import typer

from .. import __version__

app = typer.Typer(
    name="gough",
    help="Parallel kinematic machine tools: simulate hexapods under their controllers, and see the error they cut.",
    epilog="\n\n".join(
        (
            "Examples:",
            "gough new experiment -o part.toml              a file to start from",
            "gough run part.toml                            simulate it; logs and a report",
            "gough run part.ngc -m nist-octahedral -c pid   your program under a law",
            "gough preflight part.ngc -m mine.toml          can every strut follow it?",
            "gough sweep part.toml --runs 1000              a thousand drawn machines",
            "gough view results/part                        the machine, moving",
        )
    ),
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode=None if os.environ.get("NO_COLOR") else "markdown",
    context_settings={"help_option_names": ["-h", "--help"]},
)

Json = Annotated[bool, typer.Option("--json", help="One JSON object on stdout; everything else goes to stderr.")]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="No progress, no table.")]
Debug = Annotated[bool, typer.Option("--debug", help="Show the traceback of an error.")]
Out = Annotated[Path | None, typer.Option("--out", "-o", help="Results folder.  [default: results/NAME]")]
Force = Annotated[bool, typer.Option("--force", help="Write into a folder that holds other files.")]
MachineName = Annotated[
    str | None,
    typer.Option("--machine", "-m", help="A library machine or a data sheet (.toml), instead of the file's."),
]
ControllerNames = Annotated[
    list[str] | None,
    typer.Option("--controller", "-c", help="Controllers to run, instead of the file's; may be repeated."),
]


def _version(asked: bool) -> None:
    if asked:
        print(f"gough {__version__}")
        raise typer.Exit


@app.callback()
def gough(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Show the version.")
    ] = False,
) -> None:
    pass
