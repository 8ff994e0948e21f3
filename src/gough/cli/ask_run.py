"""Commands that simulate: run, tune, sweep, reproduce, linuxcnc."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from .ask import ControllerNames, Debug, Force, Json, MachineName, Out, Quiet, app
from .end import Outcome, finish


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
    file: Annotated[Path, typer.Argument(help="An experiment (.toml) with a [tune] table.")],
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
    file: Annotated[Path, typer.Argument(help="An experiment (.toml) with a [sweep] table, or the folder of a sweep.")],
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
    """Do the runs of a [sweep] table; what has ended is kept, and the same command goes on where it was stopped."""

    def work(outcome: Outcome) -> None:
        from .sweep import Asked, sweep_file
        from .sweep import rerun as rerun_one

        if rerun is not None:
            rerun_one(file, rerun, out, force, quiet or json, outcome)
        else:
            sweep_file(file, Asked(runs, seed, workers, scheduler), out, quiet or json, outcome)

    return finish("sweep", work, json, debug)


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
