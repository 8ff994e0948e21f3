"""Commands that judge a file, a program or a run: check, preflight, report, view, identify."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from .ask import Debug, Force, Json, MachineName, Out, Quiet, app
from .end import Outcome, finish


@app.command(rich_help_panel="Check and look")
def check(
    file: Annotated[Path, typer.Argument(help="An experiment, a data sheet (.toml) or an NC program (.ngc).")],
    machine: MachineName = None,
    json: Json = False,
    quiet: Quiet = False,
    debug: Debug = False,
) -> int:
    """Find every mistake of a file, without running it."""

    def work(outcome: Outcome) -> None:
        from .check import check_file

        check_file(file, machine, quiet, outcome)

    return finish("check", work, json, debug)


@app.command(rich_help_panel="Check and look")
def preflight(
    file: Annotated[
        Path, typer.Argument(help="An NC program (.ngc), an experiment (.toml), or a program of the library.")
    ],
    machine: MachineName = None,
    planner: Annotated[
        str,
        typer.Option("--planner", help="cartesian: F as written, no limits of joints; joints: kept within them."),
    ] = "cartesian",
    fix_feed: Annotated[
        Path | None,
        typer.Option("--fix-feed", help="Write the program with F words that every joint can follow into this file."),
    ] = None,
    place: Annotated[
        bool, typer.Option("--place", help="Find where to clamp the work: the place with the greatest least margin.")
    ] = False,
    turn: Annotated[bool, typer.Option("--turn", help="With --place: find the angle about Z too.")] = False,
    loop: Annotated[
        bool, typer.Option("--loop", help="Of an experiment: drive it under its laws too, at its sample time.")
    ] = False,
    out: Annotated[
        Path | None, typer.Option("--out", "-o", help="Folder for preflight.json, lines.csv and a figure.")
    ] = None,
    force: Annotated[
        bool, typer.Option("--force", help="Write over files that are there (never the original program).")
    ] = False,
    json: Json = False,
    seed: Annotated[int, typer.Option("--seed", help="Of the search of --place.")] = 0,
    quiet: Quiet = False,
    debug: Debug = False,
) -> int:
    """Before metal is cut: stroke, joint angles, speeds, accelerations and forces along a program, worst line first."""

    def work(outcome: Outcome) -> None:
        from .preflight import Asked, preflight_file

        asked = Asked(planner, fix_feed, place, turn, out, force, seed, loop)
        preflight_file(file, machine, asked, quiet, outcome)

    return finish("preflight", work, json, debug)


@app.command(rich_help_panel="Check and look")
def report(
    logs: Annotated[list[Path], typer.Argument(help="Logs (.nc), or folders of results, to put side by side.")],
    out: Out = None,
    force: Force = False,
    json: Json = False,
    quiet: Quiet = False,
    debug: Debug = False,
) -> int:
    """Write the report of logs that are there."""

    def work(outcome: Outcome) -> None:
        from .run import report_logs

        report_logs(logs, out, force, quiet or json, outcome)

    return finish("report", work, json, debug)


@app.command(rich_help_panel="Check and look")
def view(
    result: Annotated[list[Path], typer.Argument(help="Results folders, or logs (.nc) in them.")],
    export: Annotated[
        Path | None, typer.Option("--export", help="Write a page that plays from disk instead, e.g. scene.html.")
    ] = None,
    magnify: Annotated[
        float | None, typer.Option("--magnify", help="How many times as large deviations are drawn.")
    ] = None,
    port: Annotated[int, typer.Option("--port", min=0, max=65535, help="Of 127.0.0.1; 0 is any.")] = 8080,
    browse: Annotated[bool, typer.Option("--open", help="Open the browser.")] = False,
    force: Annotated[bool, typer.Option("--force", help="Replace the page.")] = False,
    json: Json = False,
    debug: Debug = False,
) -> int:
    """The machine moving along a run, in the browser."""

    def work(outcome: Outcome) -> None:
        from .view import view_files

        view_files(result, export, magnify, port, browse, force, outcome)

    return finish("view", work, json, debug)


@app.command(rich_help_panel="Check and look")
def identify(
    log: Annotated[
        list[Path],
        typer.Argument(help="Logs with q_m and u, or recorded ones: .csv, .parquet, .mat, .nc; taken together."),
    ],
    machine: Annotated[
        str, typer.Option("--machine", "-m", help="The library machine or data sheet (.toml) that was logged.")
    ],
    map_file: Annotated[Path | None, typer.Option("--map", help="A map (.toml) of a recorded log's columns.")] = None,
    free: Annotated[
        list[str] | None,
        typer.Option("--free", help="Parameters sought (platform, friction.coulomb); may be repeated.  [default: all]"),
    ] = None,
    friction: Annotated[
        str | None,
        typer.Option(
            "--friction", help="Kinds estimated; or none; or known.  [default: the map's, or coulomb,viscous]"
        ),
    ] = None,
    cutoff: Annotated[
        str | None,
        typer.Option("--cutoff", help="Of the low-pass filter; none: no filter.  [default: the map's, or 20 Hz]"),
    ] = None,
    compare: Annotated[
        bool, typer.Option("--compare", help="Hold laws of friction against one another, by error held out.")
    ] = False,
    out: Annotated[
        Path | None, typer.Option("--out", "-o", help="A file for the table, or with .json for the object.")
    ] = None,
    plot: Annotated[
        Path | None,
        typer.Option("--plot", help="A figure (.png, .svg, .pdf): errors over time and speed, held out and learned."),
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Replace a file that is there.")] = False,
    json: Json = False,
    quiet: Quiet = False,
    debug: Debug = False,
) -> int:
    """What a log says of a machine's parameters: values, deviations, and what the motion could not show."""

    def work(outcome: Outcome) -> None:
        from .identify import identify_log

        identify_log(log, machine, map_file, free, friction, cutoff, compare, out, plot, force, quiet, outcome)

    return finish("identify", work, json, debug)
