"""The FMU itself: description, sources and binary in one archive, the same bytes every time."""

from __future__ import annotations

import hashlib
import io
import platform
import shutil
import subprocess
import tempfile
import warnings
import zipfile
from pathlib import Path
from typing import Any
from xml.sax.saxutils import quoteattr

from ...errors import RunError
from .model import Model, model_of
from .source import sources

FLAGS = ("-std=c99", "-O2", "-fPIC", "-shared", "-ffp-contract=off", "-fvisibility=hidden", "-Wl,--build-id=none")
LONGEST = 300  # s, of the compiler
BASE = {
    "m": {"m": 1}, "rad": {"rad": 1}, "m/s": {"m": 1, "s": -1}, "rad/s": {"rad": 1, "s": -1}, "1": {},
    "N": {"kg": 1, "m": 1, "s": -2}, "N.m": {"kg": 1, "m": 2, "s": -2},
}  # fmt: skip


class SourcesOnly(UserWarning):
    """An FMU without a binary: importers that do not compile cannot use it."""


def fmu(what: Any, name: str | None = None) -> bytes:
    """The FMU (FMI 2.0, co-simulation) of a Machine, or of the plant of an Experiment.

    With a C compiler (cc) on a 64-bit Linux of Intel's kind it holds the binary for it (`linux64` means no other); else
    the sources only, with the warning SourcesOnly: some importers compile them.

    Raises
    ------
    ExperimentError
        the plant has what an FMU does not, or the name is no C identifier.
    RunError
        the compiler fails.
    """
    model = model_of(what, name)
    guid = _guid(sources(model, ""))
    files = sources(model, guid)
    entries = {"modelDescription.xml": description(model, guid).encode()}
    entries |= {f"sources/{name}": text.encode() for name, text in files.items()}
    binary = compiled(model.name, files)
    if binary is None:
        reason, cure = (
            ("no C compiler (cc, gcc) is here", "install gcc and export again") if _linux64()
            else ("this is no 64-bit Linux on x86", "export it on such a machine")
        )  # fmt: skip
        text = f"{reason}: the FMU holds its sources only, and few importers compile them; {cure}"
        warnings.warn(text, SourcesOnly, stacklevel=3)
    else:
        entries[f"binaries/linux64/{model.name}.so"] = binary
    data = io.BytesIO()
    with zipfile.ZipFile(data, "w", zipfile.ZIP_DEFLATED) as archive:
        for path, content in entries.items():
            info = zipfile.ZipInfo(path, (1980, 1, 1, 0, 0, 0))
            info.compress_type, info.external_attr = zipfile.ZIP_DEFLATED, 0o644 << 16
            archive.writestr(info, content)
    return data.getvalue()


def compiled(name: str, files: dict[str, str]) -> bytes | None:
    """The shared library, or None where none can be made."""
    compiler = shutil.which("cc") or shutil.which("gcc")
    if compiler is None or not _linux64():
        return None
    with tempfile.TemporaryDirectory(prefix="gough-fmu-") as folder:
        for file, text in files.items():
            Path(folder, file).write_text(text)
        command = [compiler, *FLAGS, "-o", f"{name}.so", f"{name}.c", "-lm"]
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=LONGEST)
        if done.returncode:
            first = (done.stderr.strip().splitlines() or ["no message"])[0]
            raise RunError("the C compiler fails", where=compiler, value=first)
        return Path(folder, f"{name}.so").read_bytes()


def _linux64() -> bool:
    return platform.system() == "Linux" and platform.machine() == "x86_64"


def _guid(files: dict[str, str]) -> str:
    """A name for exactly this content, in the form of a GUID."""
    digest = hashlib.sha256("".join(files.values()).encode()).hexdigest()
    return "{" + "-".join((digest[:8], digest[8:12], digest[12:16], digest[16:20], digest[20:32])) + "}"


def description(model: Model, guid: str) -> str:
    """modelDescription.xml."""
    from ... import __version__

    units, variables = "", ""
    for unit, base in BASE.items():
        powers = "".join(f' {name}="{power}"' for name, power in base.items())
        units += f"    <Unit name={quoteattr(unit)}><BaseUnit{powers}/></Unit>\n"
    for v in model.variables:
        value = "" if v.start is None else f' start="{v.start!r}"'
        variables += (
            f'    <ScalarVariable name={quoteattr(v.name)} valueReference="{v.place}" causality="{v.causality}" '
            f'variability="continuous" description={quoteattr(v.meaning)}>'
            f"<Real unit={quoteattr(v.unit)}{value}/></ScalarVariable>\n"
        )
    outputs = [k for k, v in enumerate(model.variables, 1) if v.causality == "output"]
    unknowns = "".join(f'      <Unknown index="{k}" dependencies=""/>\n' for k in outputs)
    return f"""<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName={quoteattr(model.name)} guid={quoteattr(guid)}
  description={quoteattr(model.about)} generationTool="gough {__version__}" variableNamingConvention="structured">
  <CoSimulation modelIdentifier={quoteattr(model.name)} canHandleVariableCommunicationStepSize="true"
    canGetAndSetFMUstate="true" canNotUseMemoryManagementFunctions="false">
    <SourceFiles>
      <File name={quoteattr(model.name + ".c")}/>
    </SourceFiles>
  </CoSimulation>
  <UnitDefinitions>
{units}  </UnitDefinitions>
  <LogCategories>
    <Category name="logAll"/>
    <Category name="logStatusError"/>
  </LogCategories>
  <DefaultExperiment startTime="0" stepSize="{model.period!r}"/>
  <ModelVariables>
{variables}  </ModelVariables>
  <ModelStructure>
    <Outputs>
{unknowns}    </Outputs>
    <InitialUnknowns>
{unknowns}    </InitialUnknowns>
  </ModelStructure>
</fmiModelDescription>
"""
