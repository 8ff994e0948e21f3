"""The files that repeat a run: the experiment with nothing left open, its data sheet and its NC program beside it.

Sheet and program are copied as they were read, comments and sources included; defaults and arguments of the command
line stand in the experiment, so that a later version of gough with other defaults runs the same.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import tomli_w

from .. import __version__
from ..files import LARGEST_TOML, read_text
from ..machine import sheet
from ..names import slug
from .experiment import SCHEMA, Experiment

NAME = "experiment.toml"
SUBROUTINES = "subroutines"  # folder of the files that an NC program calls


def resolved(experiment: Experiment, command: str = "gough run") -> dict[str, str]:
    """File name -> text of everything that `gough run experiment.toml` needs in a results folder.

    `command` is told in the experiment as what repeats it.

    Raises
    ------
    InputError
        the sheet or the NC program is no longer there.
    """
    data, folder = experiment.document.data, experiment.document.path.parent
    files: dict[str, str] = {}
    machine = dict(data["machine"])
    machine["use"] = _name(f"{experiment.machine.name}.toml", files)
    files[machine["use"]] = read_text(sheet.find(data["machine"]["use"], folder), LARGEST_TOML)
    program = dict(data["program"])
    if "file" in program:
        nc = experiment.program
        program["file"] = _name(slug(Path(nc.name).stem) + ".ngc", files)  # .nc would be the name of a log
        files[program["file"]] = nc.text
        program.pop("subroutines", None)
        for name, text in nc.subroutines.items():
            program["subroutines"] = SUBROUTINES
            files[f"{SUBROUTINES}/{name}.ngc"] = text
        if "parameters" in program:
            program["parameters"] = _name(slug(Path(program["parameters"]).stem) + ".var", files)
            files[program["parameters"]] = "".join(f"{n} {v!r}\n" for n, v in sorted(nc.parameters.items()))
    tables: dict[str, Any] = {"schema": SCHEMA, "machine": machine}
    if "plant" in data:
        tables["plant"] = data["plant"]
    tables["program"] = program
    if "tools" in data:
        tables["tools"] = experiment.program.tools.to_file()
    tables["controller"] = [{"kind": kind, **law.to_file()} for kind, law in experiment.controllers]
    if experiment.observer is not None:
        tables["observer"] = experiment.observer.to_file()
    if experiment.compensation is not None:
        tables["compensation"] = experiment.compensation.to_file()
    tables["run"] = experiment.run.to_file()
    for name in ("sweep", "tune"):
        if name in data:
            tables[name] = data[name]
    head = (
        f"# Repeats the run of {experiment.document.path.name!a}: {command} {NAME}\n# Written by gough {__version__}.\n"
    )
    return {NAME: head + tomli_w.dumps(tables), **files}


def _name(wanted: str, taken: dict[str, str]) -> str:
    return wanted if wanted not in (NAME, *taken) else f"used-{wanted}"
