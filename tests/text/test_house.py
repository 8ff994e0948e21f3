"""The house: who imports whom, what the map says, what a library sheet must tell."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

import gough as gk
from gough.declare import Part

ROOT = Path(__file__).parents[2]
SRC = ROOT / "src" / "gough"
FILES = sorted(SRC.rglob("*.py"))

# floors of the house, from the ground up; nobody imports from a floor above
FLOORS = [
    {
        *("errors", "units", "files", "quantities", "complaints", "declare", "frames"),
        *("names", "results", "toml_lines"),
    },
    {"mechanics", "kernel"},
    {"machine"},
    {"program", "control", "observe", "cutting"},
    {"measure"},
    {"log"},
    {"simulate"},
    {"identify", "plan"},
    {"report", "export"},
    {"monitor", "identify"},
    {"study"},
    {"experiment"},
    {"sweep"},
    {"tune", "linuxcnc", "view"},
    {"cli"},
]
FLOOR = {name: level for level, names in enumerate(FLOORS) for name in names}
# log.plot gives the report's axes: the one look upstairs, taken when it is asked for
ALLOWED = {("log", "report")}


def room(path: Path) -> str:
    return path.relative_to(SRC).parts[0].removesuffix(".py")


def imported(path: Path):
    """Rooms of gough that a file imports, anywhere in it."""
    package = ("gough", *path.relative_to(SRC).parent.parts)
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            targets = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            base = list(package[: len(package) - node.level + 1]) if node.level else []
            stem = ".".join(base + ([node.module] if node.module else []))
            targets = [f"{stem}.{alias.name}" for alias in node.names] if stem == "gough" else [stem]
        else:
            continue
        for target in targets:
            if target.startswith("gough."):
                yield target.split(".")[1]


@pytest.mark.parametrize("path", FILES, ids=lambda p: str(p.relative_to(SRC)))
def test_nobody_imports_upward(path):
    me = room(path)
    if me in ("__init__", "__main__"):
        return
    assert me in FLOOR, f"{me} has no floor: give it one in this test"
    for other in imported(path):
        if other in FLOOR and (me, other) not in ALLOWED:
            assert FLOOR[other] <= FLOOR[me], f"{path.name} imports {other}, which is upstairs"


def test_the_map_names_every_source_file():
    text = (ROOT / "MAP.md").read_text()
    missing = [
        str(p.relative_to(SRC)) for p in FILES if p.name != "__init__.py" and str(p.relative_to(SRC)) not in text
    ]
    assert not missing
    named = set(re.findall(r"`([\w/]+\.py)`", text))
    assert not [name for name in named if not (SRC / name).exists() and not (ROOT / name).exists()]


HEAVY = ("casadi", "xarray", "scipy", "matplotlib", "plotly", "llvmlite", "pandas", "h5py")


@pytest.mark.parametrize("command", [["--help"], ["--version"]])
def test_help_loads_nothing_heavy(command):
    code = (
        "import sys\nfrom gough.cli import main\n"
        f"try:\n    main({command!r})\nexcept SystemExit:\n    pass\n"
        f"print([m for m in {HEAVY} if m in sys.modules], file=sys.stderr)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stderr.strip().endswith("[]"), done.stderr


def test_the_public_names_are_few_and_there():
    assert len(gk.__all__) <= 30
    for name in gk.__all__:
        assert getattr(gk, name) is not None


@pytest.mark.parametrize("sheet", sorted((SRC / "machine" / "library").glob("*.toml")), ids=lambda p: p.stem)
def test_every_number_of_a_library_sheet_has_its_source(sheet):
    data = tomllib.loads(sheet.read_text())
    numbers = [
        key
        for key in _numbers(data)
        if key.split(".")[0] not in ("source", "schema", "name", "kind") and not key.endswith(".kind")
    ]
    missing = [key for key in numbers if not any(key == s or key.startswith(s + ".") for s in data["source"])]
    assert not missing
    assert not [s for s in data["source"] if not any(key == s or key.startswith(s + ".") for key in numbers)], (
        "sources of nothing"
    )
    assert all(len(text) > 12 for text in data["source"].values())


def _numbers(table, prefix=""):
    for key, value in table.items():
        name = prefix + key
        if isinstance(value, dict) and set(value) != {"unit", "value"}:
            yield from _numbers(value, name + ".")
        else:
            yield name


def test_nobody_but_a_sweep_on_a_cluster_opens_a_connection():
    """Nothing is sent out: results.py asks for the name of this computer, the viewer (viser) listens on 127.0.0.1."""
    asked = re.compile(r"^\s*(?:import|from) (socket|urllib|http|ftplib|smtplib|requests|aiohttp)\b", re.M)
    found = {str(path.relative_to(SRC)) for path in FILES if asked.search(path.read_text("utf-8"))}
    assert found == {"sweep/cluster.py", "results.py"}
    opened = re.compile(r"socket\.(?!gethostname)\w+")
    assert not opened.search((SRC / "results.py").read_text("utf-8"))


def _parts():
    import importlib
    import pkgutil

    import gough

    for module in pkgutil.walk_packages(gough.__path__, "gough."):
        if not module.name.endswith("__main__"):
            importlib.import_module(module.name)

    def below(kind):
        for sub in kind.__subclasses__():
            yield sub
            yield from below(sub)

    return sorted({part for part in below(Part) if part.__module__.startswith("gough.")}, key=lambda p: p.__qualname__)


def test_every_number_of_a_part_has_unit_and_meaning():
    from gough import units

    for part in _parts():
        assert part.__doc__, part
        for name, spec in part.specs().items():
            assert len(spec.meaning) > 3, (part, name)
            for unit in spec.unit.split(","):
                units.unit(unit)
