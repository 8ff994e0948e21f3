"""gough export --target c: the folder, its self-test under both compilers and their sanitizers, and what is refused."""

from __future__ import annotations

import os
import shutil
import subprocess

import pytest
from compiled import COMPILERS, GENHEX, needs_gcc

import gough as gk
from gough.errors import ExperimentError
from gough.export import export, export_folder
from gough.export.c.folder import c_files

EXPERIMENT = """
schema = "gough-experiment-1"
[machine]
use = "ifma-hsm"
[program]
kind = "circle"
radius = "10 mm"
feed = "1 m/min"
[[controller]]
kind = "pid"
bandwidth = "10 Hz"
[[controller]]
kind = "desired_torque_adaptive"
pole = "100 1/s"
[observer]
kind = "disturbance"
bandwidth = "20 Hz"
[run]
period = "0.5 ms"
"""
LIBRARY = ("okuma-pm600", "nist-octahedral", "eth-hexaglide", "ccu-3prs", "ifma-hsm", "emps")
needs_make = pytest.mark.skipif(shutil.which("make") is None, reason="make is not installed")


SANITIZE = ["-fsanitize=address,undefined", "-fno-sanitize-recover=all"]


def sanitizes(compiler, folder):
    """Whether a compiler has its sanitizers at hand."""
    (folder / "none.c").write_text("int main(void) { return 0; }\n")
    command = [compiler, *SANITIZE, "none.c", "-o", "none"]
    return subprocess.run(command, cwd=folder, capture_output=True, timeout=60, check=False).returncode == 0


def made(folder, *options, **environment):
    """What `make test` in a folder says, and its exit status."""
    known = {key: value for key, value in os.environ.items() if key not in ("CC", "CFLAGS", "MAKEFLAGS")}
    command = ["make", "-s", *options, "test"]
    done = subprocess.run(
        command, cwd=folder, capture_output=True, text=True, timeout=300, check=False, env=known | environment
    )
    return done.returncode, done.stdout + done.stderr


@needs_gcc
@needs_make
@pytest.mark.full
def test_an_exported_machine_passes_its_own_test_without_a_word_of_the_compiler(gough, tmp_path):
    told = gough("export", str(GENHEX), "--target", "c", "--name", "hexapod", "-o", str(tmp_path / "out"))
    assert told.status == 0
    files = sorted(path.name for path in (tmp_path / "out").iterdir() if path.name != ".gough")
    assert files == ["Makefile", "README.md", "hexapod.c", "hexapod.h", "hexapod_test.c"]
    assert made(tmp_path / "out") == (0, "hexapod: all as recorded\n")


@needs_make
@pytest.mark.full
@pytest.mark.parametrize("compiler", COMPILERS)
def test_an_experiment_passes_its_own_test_under_address_and_undefined_behaviour_sanitizers(compiler, tmp_path):
    if not sanitizes(compiler, tmp_path):
        pytest.skip(f"{compiler} has no sanitizers: install libclang-rt-14-dev, or libasan and libubsan")
    path = tmp_path / "part.toml"
    path.write_text(EXPERIMENT)
    files = export_folder(gk.load_experiment(path), "c", tmp_path / "out")
    for one in ("", "_pid", "_desired_torque_adaptive", "_observer"):
        assert {f"ifma_hsm{one}.c", f"ifma_hsm{one}.h"} <= set(files)
    export_folder(gk.load_machine(GENHEX), "c", tmp_path / "search")  # the hybrid machine has none
    flags = f"CC={compiler}", f"CFLAGS=-O0 -g {' '.join(SANITIZE)}"
    assert made(tmp_path / "out", *flags) == (0, "ifma_hsm: all as recorded\n")
    assert made(tmp_path / "search", *flags) == (0, "genhex: all as recorded\n")


@needs_gcc
@needs_make
@pytest.mark.full("nist-octahedral-constant", "ifma-hsm-argument", "ccu-3prs-constant", "emps-*")
@pytest.mark.parametrize("theta", ["constant", "argument"])
@pytest.mark.parametrize("machine", LIBRARY)
def test_every_machine_passes_its_own_test(machine, theta, tmp_path):
    export_folder(gk.load_machine(machine), "c", tmp_path / "out", theta=theta)
    assert made(tmp_path / "out", "CFLAGS=-O0")[0] == 0


@needs_gcc
@needs_make
@pytest.mark.full
def test_the_self_test_fails_where_a_number_of_the_machine_is_another(tmp_path):
    export_folder(gk.load_machine("ifma-hsm"), "c", tmp_path / "out")
    source = tmp_path / "out" / "ifma_hsm.c"
    others = c_files(gk.load_machine("ifma-hsm").replace(**{"ram.mass": 160.000001}))
    source.write_text(others["ifma_hsm.c"])
    status, told = made(tmp_path / "out")
    assert status != 0
    assert "ifma_hsm_inverse_dynamics, row 0: status 0, expected 0; off by" in told
    assert "ifma_hsm_inverse," not in told


@needs_make
def test_without_a_compiler_the_self_test_says_so(tmp_path):
    export_folder(gk.load_machine("emps"), "c", tmp_path / "out")
    status, told = made(tmp_path / "out", "CC=no-such-cc")
    assert status != 0
    assert "no C compiler no-such-cc: install gcc, or make CC=..." in told


def test_two_exports_of_one_machine_are_the_same_to_the_last_byte():
    assert c_files(gk.load_machine("emps")) == c_files(gk.load_machine("emps"))


def test_the_header_says_unit_and_frame_of_what_goes_in_and_out():
    header = c_files(gk.load_machine(GENHEX))["genhex.h"]
    for words in (
        "x y z of the tool tip in W, m, and a b c, rad",
        "R_WT = Rz(c) Ry(b) Rx(a)",
        "m, strut 1, strut 2",
        "[f; m] N, N m on the tool at its tip, in W",
        "Bounded: at most 120 evaluations",
        "genhex_inverse(const double pose[6], double joints[6])",
    ):
        assert words in header
    assert "$" not in header


@pytest.mark.parametrize(
    ("arguments", "rule"),
    [
        (["emps", "--target", "c"], "--out: this target writes a folder; add -o FOLDER"),
        (["emps", "--target", "c", "--name", "3x", "-o", "{out}"], "name: a name in C has letters, digits and _ only"),
        (["emps", "--target", "d", "-o", "{out}"], "no such target of an export"),
        (["nothing-here", "--target", "c", "-o", "{out}"], "nothing-here"),
    ],
)
def test_what_cannot_be_exported_is_refused_and_leaves_nothing(gough, tmp_path, arguments, rule):
    told = gough("export", *(word.format(out=tmp_path / "out") for word in arguments))
    assert told.status == 2
    assert rule in told.err
    assert list(tmp_path.iterdir()) == []


def test_a_folder_of_a_stranger_is_left_as_it_is_and_one_of_gough_is_replaced(gough, tmp_path):
    own = tmp_path / "mine"
    own.mkdir()
    (own / "notes.txt").write_text("mine")
    told = gough("export", "emps", "--target", "c", "-o", str(own))
    assert told.status == 2
    assert "the folder holds files that gough did not make" in told.err
    assert [path.name for path in own.iterdir()] == ["notes.txt"]
    out = tmp_path / "out"
    for name in ("first", "second"):
        assert gough("export", "emps", "--target", "c", "--name", name, "-o", str(out)).status == 0
    assert sorted(path.name for path in out.glob("*.c")) == ["second.c", "second_test.c"]


def test_a_machine_whose_sheet_has_no_limits_is_refused_before_anything_is_written(gough, tmp_path):
    text = GENHEX.read_text()
    sheet = tmp_path / "open.toml"
    sheet.write_text(text[: text.index("[limits]")] + text[text.index("[home]") :].replace('"limits" ', '"other" '))
    told = gough("export", str(sheet), "--target", "c", "-o", str(tmp_path / "out"))
    assert told.status == 2
    assert "limits" in told.err
    assert not (tmp_path / "out").exists()


@pytest.mark.full
def test_a_machine_without_a_declared_workspace_is_exported_with_poses_about_home():
    machine = gk.load_machine(GENHEX).replace(**{"limits.workspace": None})
    files = c_files(machine, "open")
    assert "beyond the radius of the workspace" not in files["open.c"]
    assert "open_limit_names[" in files["open.h"]


def test_targets_of_a_file_and_of_a_folder_are_not_mistaken():
    with pytest.raises(ExperimentError, match="use export_folder"):
        export(gk.load_machine("emps"), "c")
    with pytest.raises(ExperimentError, match="use export$"):
        export_folder(gk.load_machine("emps"), "mjcf")


def test_the_numbers_of_a_machine_are_a_constant_or_an_argument():
    header = c_files(gk.load_machine("emps"), theta="argument")["emps.h"]
    assert "int emps_inverse(const double theta[" in header
    assert "extern const double emps_theta[" in header
    with pytest.raises(ExperimentError, match=r"theta: theta is a constant or an argument, got 'struct'"):
        c_files(gk.load_machine("emps"), theta="struct")
