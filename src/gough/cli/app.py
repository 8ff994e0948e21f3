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

import os
import signal
import sys
from pathlib import Path
from typing import Annotated

import typer

from .. import __version__
from .end import Interrupted, Outcome, finish

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


@app.command(rich_help_panel="Simulate")
def run(
    file: Annotated[
        Path, typer.Argument(help="An experiment (.toml), an NC program (.ngc), or one of the library (cone-frustum).")
    ],
    machine: MachineName = None,
    controller: ControllerNames = None,
    out: Out = None,
    force: Force = False,
    json: Json = False,
    seed: Annotated[int | None, typer.Option("--seed", help="Of the noise, instead of the file's.")] = None,
    quiet: Quiet = False,
    strict: Annotated[bool, typer.Option("--strict", help="A warning is an error.")] = False,
    debug: Debug = False,
) -> int:
    """Run an experiment; write its logs, plots and report."""

    def work(outcome: Outcome) -> None:
        from .run import run_file

        run_file(file, machine, controller or (), seed, out, force, quiet or json, strict, outcome)

    return finish("run", work, json, debug)


@app.command(rich_help_panel="Simulate")
def tune(
    file: Annotated[Path, typer.Argument(help="An experiment (.toml) with a tune table.")],
    machine: MachineName = None,
    controller: ControllerNames = None,
    budget: Annotated[int | None, typer.Option("--budget", help="Candidates tried, at most.")] = None,
    out: Out = None,
    force: Force = False,
    json: Json = False,
    seed: Annotated[int | None, typer.Option("--seed", help="Of the search, instead of the file's.")] = None,
    quiet: Quiet = False,
    debug: Debug = False,
) -> int:
    """Find gains that make the contour error small on drawn machines, within limits; write them as a file that runs."""

    def work(outcome: Outcome) -> None:
        from .tune import tune_file

        tune_file(file, machine, controller or (), budget, seed, out, force, quiet or json, outcome)

    return finish("tune", work, json, debug)


@app.command(rich_help_panel="Simulate")
def sweep(
    file: Annotated[Path, typer.Argument(help="An experiment (.toml) with a sweep table, or the folder of a sweep.")],
    runs: Annotated[
        int | None, typer.Option("--runs", "-n", help="Draws of the distributions, instead of the file's.")
    ] = None,
    workers: Annotated[
        int | None, typer.Option("--workers", "-w", help="Processes on this machine.  [default: one for each core]")
    ] = None,
    scheduler: Annotated[
        str | None, typer.Option("--scheduler", help="Address of a dask.distributed scheduler, as tcp://host:8786.")
    ] = None,
    seed: Annotated[int | None, typer.Option("--seed", help="Of the draws, instead of the file's.")] = None,
    rerun: Annotated[
        str | None, typer.Option("--rerun", help="Do the run of this id again, with a full log and a report.")
    ] = None,
    out: Annotated[
        Path | None, typer.Option("--out", "-o", help="Folder of the sweep.  [default: results/NAME-sweep]")
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="With --rerun: write into a folder with other files.")] = False,
    json: Json = False,
    quiet: Quiet = False,
    debug: Debug = False,
) -> int:
    """Do the runs of a sweep table; what has ended is kept, and the same command goes on where it was stopped."""

    def work(outcome: Outcome) -> None:
        from .sweep import Asked, sweep_file
        from .sweep import rerun as rerun_one

        if rerun is not None:
            rerun_one(file, rerun, out, force, quiet or json, outcome)
        else:
            sweep_file(file, Asked(runs, seed, workers, scheduler), out, quiet or json, outcome)

    return finish("sweep", work, json, debug)


@app.command(rich_help_panel="Simulate")
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


@app.command(rich_help_panel="Simulate")
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


@app.command(rich_help_panel="Simulate")
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


@app.command(rich_help_panel="Simulate")
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


@app.command(rich_help_panel="Simulate")
def reproduce(
    paper: Annotated[str, typer.Argument(help="A paper, such as garagic2004; or all.", metavar="PAPER|all")],
    campaign: Annotated[
        bool, typer.Option("--campaign", help="With the long campaigns beyond the paper, minutes each.")
    ] = False,
    out: Out = None,
    force: Force = False,
    json: Annotated[
        bool, typer.Option("--json", help="The rows of the table as a JSON list on stdout; all else to stderr.")
    ] = False,
    quiet: Quiet = False,
    debug: Debug = False,
) -> int:
    """Do published experiments again and hold the paper's numbers against ours.  Exit status 1: one is not met."""

    def work(outcome: Outcome) -> None:
        from .reproduce import reproduce_papers

        reproduce_papers(paper, campaign, out, force, quiet or json, outcome)

    return finish("reproduce", work, json, debug)


@app.command(rich_help_panel="Simulate")
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


linuxcnc = typer.Typer(help="LinuxCNC itself on an exported machine.", no_args_is_help=True)
app.add_typer(linuxcnc, name="linuxcnc", rich_help_panel="Simulate")


@linuxcnc.command("run")
def linuxcnc_run(
    file: Annotated[Path, typer.Argument(help="An NC program (.ngc), or an experiment (.toml) that has one.")],
    machine: MachineName = None,
    controller: ControllerNames = None,
    out: Out = None,
    force: Force = False,
    json: Json = False,
    seed: Annotated[int | None, typer.Option("--seed", help="Of the noise, instead of the file's.")] = None,
    speed: Annotated[int, typer.Option("--speed", help="How many times faster than real time LinuxCNC runs.")] = 10,
    timeout: Annotated[str, typer.Option("--timeout", help="Real time after which LinuxCNC is ended.")] = "10 min",
    quiet: Quiet = False,
    strict: Annotated[bool, typer.Option("--strict", help="A warning is an error.")] = False,
    debug: Debug = False,
) -> int:
    """Run an NC program in LinuxCNC, headless; simulate the motion that it commands, and report as gough run does."""

    def work(outcome: Outcome) -> None:
        from .linuxcnc import Asked, run_in_linuxcnc

        asked = Asked(speed, timeout)
        run_in_linuxcnc(file, machine, controller or (), seed, asked, out, force, quiet or json, strict, outcome)

    return finish("linuxcnc", work, json, debug)


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
