"""Commands on recorded logs: monitor, compensate."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from .ask import Debug, Force, Json, Out, Quiet, app
from .end import Outcome, finish


@app.command(rich_help_panel="Logs")
def monitor(
    log: Annotated[Path, typer.Argument(help="A recorded log: .csv, .parquet, .mat, .nc; or a log of gough's.")],
    machine: Annotated[
        str | None, typer.Option("--machine", "-m", help="A library machine or a data sheet (.toml); needed.")
    ] = None,
    map_file: Annotated[
        Path | None, typer.Option("--map", help="A map (.toml) of the log's columns: gough new map writes one.")
    ] = None,
    bandwidth: Annotated[str, typer.Option("--bandwidth", help="Of the force, e.g. 20 Hz.")] = "20 Hz",
    form: Annotated[str, typer.Option("--form", help="momentum, or static: without inertia.")] = "momentum",
    alarm: Annotated[str | None, typer.Option("--alarm", help='Force that is an alarm, as "2 kN".')] = None,
    collision: Annotated[
        str | None, typer.Option("--collision", help="Jump of the force within 10 ms.  [default: from the machine]")
    ] = None,
    breakage: Annotated[
        str | None, typer.Option("--breakage", help="Force whose loss is told.  [default: from the machine]")
    ] = None,
    follow: Annotated[bool, typer.Option("--follow", help="Go on while the file is being written.")] = False,
    until: Annotated[str, typer.Option("--until", help="With --follow: end when so long nothing came.")] = "60 s",
    out: Out = None,
    force: Force = False,
    json: Json = False,
    quiet: Quiet = False,
    debug: Debug = False,
) -> int:
    """The force on the tool over a recorded log: peaks, alarms, collisions, breakage."""

    def work(outcome: Outcome) -> None:
        from .monitor import Asked, monitor_file

        asked = Asked(bandwidth, form, alarm, collision, breakage, until if follow else None)
        monitor_file(log, machine, map_file, asked, out, force, quiet, outcome)

    return finish("monitor", work, json, debug)


@app.command(rich_help_panel="Logs")
def compensate(
    part: Annotated[Path, typer.Argument(help="The NC program that was run; it is never overwritten.")],
    log: Annotated[
        Path,
        typer.Option("--log", help="The log of its run: gough's (.nc), or recorded: .csv, .parquet, .mat, .nc."),
    ],
    height: Annotated[str, typer.Option("--height", help='Height of the wall, as "18 mm".')],
    machine: Annotated[
        str | None, typer.Option("--machine", "-m", help="A library machine or a data sheet.  (default: the log's)")
    ] = None,
    map_file: Annotated[Path | None, typer.Option("--map", help="A map (.toml) of a recorded log's columns.")] = None,
    flexible: Annotated[
        bool, typer.Option("--flexible", help="Add what the machine gives way, by the compliance tables of its sheet.")
    ] = False,
    air: Annotated[
        str | None,
        typer.Option("--air", help='Way through air, to tare on: "5 mm..30 mm" of the path.  (default: no taring)'),
    ] = None,
    least: Annotated[str, typer.Option("--least", help="Force below which nothing is cut.")] = "10 N",
    linear: Annotated[
        str | None, typer.Option("--linear", help='c_1 of the tool\'s law.  (default: "8.93e-4 deg/N")')
    ] = None,
    quadratic: Annotated[
        str | None, typer.Option("--quadratic", help='c_2 of the tool\'s law.  (default: "2.56e-6 deg/N2")')
    ] = None,
    bandwidth: Annotated[
        str, typer.Option("--bandwidth", help="Of the force, where the log has no estimate.")
    ] = "10 Hz",
    fine: Annotated[str, typer.Option("--fine", help="Steps of the tilt that get a line of their own.")] = "0.003 deg",
    out: Annotated[
        Path | None, typer.Option("--out", "-o", help="The corrected program.  (default: PART-compensated.ngc)")
    ] = None,
    force: Annotated[
        bool, typer.Option("--force", help="Replace a file that is there (never the original or the log).")
    ] = False,
    json: Json = False,
    quiet: Quiet = False,
    debug: Debug = False,
) -> int:
    """Write an NC program again, its tool leaning against the force that the log of a run shows."""

    def work(outcome: Outcome) -> None:
        from .compensate import Asked, compensate_file

        asked = Asked(height, air, least, linear, quadratic, bandwidth, fine, flexible)
        compensate_file(part, log, machine, map_file, asked, out, force, quiet or json, outcome)

    return finish("compensate", work, json, debug)
