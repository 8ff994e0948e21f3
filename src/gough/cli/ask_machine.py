"""Commands on machines, and where to begin: machines, show, map, envelope, export, explain, new."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from .ask import Debug, Force, Json, Out, Quiet, app
from .end import Outcome, finish


@app.command(rich_help_panel="Machines")
def machines(json: Json = False, debug: Debug = False) -> int:
    """List the machines of the library."""

    def work(outcome: Outcome) -> None:
        from .show import list_machines

        list_machines(outcome)

    return finish("machines", work, json, debug)


@app.command(rich_help_panel="Machines")
def show(
    what: Annotated[
        str,
        typer.Argument(help="A machine or NC program (.ngc), by name or file; or an experiment.", metavar="NAME|FILE"),
    ],
    out: Annotated[
        Path | None, typer.Option("--out", "-o", help="Write the drawing of a machine as PNG into this file instead.")
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Replace a file that is there.")] = False,
    json: Json = False,
    debug: Debug = False,
) -> int:
    """Show a machine: its drawing, every number with its unit, meaning and source.  Or a program: all its moves."""

    def work(outcome: Outcome) -> None:
        from .show import show_anything

        show_anything(what, outcome, out, force)

    return finish("show", work, json, debug)


@app.command("map", rich_help_panel="Machines")
def map_(
    machine: Annotated[str, typer.Argument(help="A library machine or a data sheet (.toml).", metavar="MACHINE")],
    what: Annotated[
        list[str] | None,
        typer.Option(
            "--what",
            help="workspace, dexterity, feed, acceleration, force, gravity or stiffness; several by commas.  "
            "[default: workspace]",
        ),
    ] = None,
    over: Annotated[
        str | None,
        typer.Option("--over", help='Coordinates that run, as "x,y" or "a,b" or "x=-50 mm..50 mm,y".  [default: x,y]'),
    ] = None,
    at: Annotated[
        list[str] | None, typer.Option("--at", help='Where the others stand, as "z=50 mm"; may be repeated.')
    ] = None,
    points: Annotated[str, typer.Option("--points", help="Of each coordinate that runs; or one number each.")] = "41",
    out: Out = None,
    force: Force = False,
    json: Json = False,
    quiet: Quiet = False,
    debug: Debug = False,
) -> int:
    """Map a machine over its workspace: NetCDF, figures, and where it is worst."""

    def work(outcome: Outcome) -> None:
        from .map import map_machine

        map_machine(machine, what or ["workspace"], over, at or (), points, out, force, quiet, outcome)

    return finish("map", work, json, debug)


@app.command(rich_help_panel="Machines")
def envelope(
    machine: Annotated[str, typer.Argument(help="A library machine or a data sheet (.toml).", metavar="MACHINE")],
    at: Annotated[
        list[str] | None,
        typer.Option("--at", help='The pose, as "x=50 mm,z=-20 mm,a=5 deg"; what is not said is as at home.'),
    ] = None,
    wrench: Annotated[
        str | None, typer.Option("--wrench", help='On the tool, in W, as "0 N,0 N,-500 N"; the drives hold it, too.')
    ] = None,
    workspace: Annotated[bool, typer.Option("--workspace", help="The declared workspace is a limit, too.")] = False,
    out: Annotated[Path | None, typer.Option("--out", "-o", help="A file for the figure: .png, .svg or .pdf.")] = None,
    force: Annotated[bool, typer.Option("--force", help="Replace a file that is there.")] = False,
    json: Json = False,
    debug: Debug = False,
) -> int:
    """How far from a pose, along each coordinate and in every direction, and what ends it."""

    def work(outcome: Outcome) -> None:
        from .envelope import envelope_of

        envelope_of(machine, at or (), wrench, workspace, out, force, outcome)

    return finish("envelope", work, json, debug)


@app.command(rich_help_panel="Machines")
def export(
    what: Annotated[
        str, typer.Argument(help="A library machine or a data sheet (.toml); c, linuxcnc, fmu: or an experiment.")
    ],
    target: Annotated[
        str, typer.Option("--target", "-t", help="mjcf: for MuJoCo and Pinocchio; fmu; c, linuxcnc: a folder.")
    ],
    out: Annotated[
        Path | None, typer.Option("--out", "-o", help="The file, or for c and linuxcnc the folder.  [default: stdout]")
    ] = None,
    loops: Annotated[
        str, typer.Option("--loops", help="mjcf: default (MuJoCo's soft constraints) or stiff.")
    ] = "default",
    timestep: Annotated[str | None, typer.Option("--timestep", help='mjcf: MuJoCo\'s step, as "0.25 ms".')] = None,
    theta: Annotated[
        str, typer.Option("--theta", help="c: the machine's numbers, constant in the code or an argument.")
    ] = "constant",
    name: Annotated[
        str | None, typer.Option("--name", help="c, linuxcnc, fmu: what names begin with.  [default: machine]")
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Replace a file that is there.")] = False,
    json: Json = False,
    debug: Debug = False,
) -> int:
    """Write a machine as the file of another program, or a machine or experiment as C."""

    def work(outcome: Outcome) -> None:
        from .export import export_file

        export_file(what, target, loops, timestep, name, theta, out, force, outcome)

    return finish("export", work, json, debug)


@app.command(rich_help_panel="Machines")
def explain(
    code: Annotated[
        str | None, typer.Argument(help="The code of an error, as --json gives it; all where left out.", metavar="CODE")
    ] = None,
    json: Json = False,
    debug: Debug = False,
) -> int:
    """What an error means, why it comes, and what to do."""

    def work(outcome: Outcome) -> None:
        from .explain import explain as tell_of

        tell_of(code, outcome)

    return finish("explain", work, json, debug)


@app.command(rich_help_panel="Machines")
def new(
    what: Annotated[
        str,
        typer.Argument(help="machine, controller, experiment or map.", metavar="machine|controller|experiment|map"),
    ],
    out: Annotated[Path | None, typer.Option("--out", "-o", help="The file to write.  [default: stdout]")] = None,
    force: Annotated[bool, typer.Option("--force", help="Replace a file that is there.")] = False,
    json: Json = False,
    debug: Debug = False,
) -> int:
    """Write a commented file to start from."""

    def work(outcome: Outcome) -> None:
        from .new import write_template

        write_template(what, out, force, outcome)

    return finish("new", work, json, debug)
