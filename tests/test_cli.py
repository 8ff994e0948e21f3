"""What the command line promises: exit status, JSON, lazy imports, what it prints."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import threading
import tomllib
from importlib import import_module

import numpy as np
import pytest

import gough as gk
from gough.cli import new as cli_new
from gough.errors import KinematicsError, WorkspaceError
from gough.log import Log
from sample_files import CIRCLE, EXPERIMENT, SHEET

NC = "G21 G90\nG1 X10 F3000\nG1 X0\nM2\n"
HEAVY = {"casadi", "xarray", "scipy", "matplotlib", "llvmlite", "plotly", "h5netcdf", "h5py", "numpy"}


def loaded_by(code: str) -> set[str]:
    script = f"import sys\n{code}\nprint(*sys.modules)"
    out = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True, timeout=30).stdout
    return HEAVY & set(out.split())


# -- lazy --------------------------------------------------------------------------------------------------------------


@pytest.mark.full
def test_neither_import_nor_help_loads_anything_heavy():
    assert loaded_by("import gough") == set()
    for arguments in (["--help"], ["run", "--help"], ["--version"], ["new", "machine"]):
        assert loaded_by(f"from gough.cli import main\ntry: main({arguments})\nexcept SystemExit: pass") == set(), (
            arguments
        )


@pytest.mark.full
@pytest.mark.parametrize("told", [{}, {"NO_COLOR": "1"}], ids=["with boxes", "plain"])
def test_the_help_keeps_what_stands_in_brackets(told):
    """A help that takes brackets for styles drops the names of tables: "the runs of a  table"."""
    out = subprocess.run(
        [sys.executable, "-m", "gough", "sweep", "--help"], capture_output=True, text=True, timeout=60,
        env={**{k: v for k, v in os.environ.items() if k != "NO_COLOR"}, "COLUMNS": "200", **told},
    ).stdout  # fmt: skip
    for words in ("the runs of a [sweep] table", "with a [sweep] table", "[default: results/NAME-sweep]"):
        assert words in out, out


def test_the_public_api_is_at_most_thirty_names_and_every_one_is_there():
    assert len(gk.__all__) <= 30
    assert dir(gk) == sorted([*gk.__all__, "__version__"])
    for name in gk.__all__:
        assert callable(getattr(gk, name)), name
    with pytest.raises(AttributeError, match="module 'gough' has no attribute 'simulat'"):
        gk.simulat  # noqa: B018


@pytest.mark.quick("export", "measure")
@pytest.mark.parametrize("verb", ["simulate", "measure", "identify", "report", "export"])
def test_a_verb_can_be_called_whoever_imported_its_package_first(verb):
    script = (
        f"import gough.{verb}\nimport gough as gk, inspect\nprint(callable(gk.{verb}), inspect.signature(gk.{verb}))"
    )
    out = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True, timeout=30).stdout
    assert out.startswith("True (")
    assert "(*args" not in out


def test_the_version_is_that_of_the_package(gough):
    from importlib.metadata import version

    assert gough("--version").out == f"gough {version('gough')}\n"
    assert gk.__version__ == version("gough")


# -- run, with a simulation of no work ---------------------------------------------------------------------------------


def log_of(machine, law, failed=""):
    """A log as `simulate` makes one, of three samples."""
    three = {"max": 2e-6, "rms": 1e-6, "mean": 0.5e-6}
    info = {
        "machine_name": machine.name, "controller_kind": law.kind, "simulated_time": 0.003, "wall_time": 0.1,
        "metrics": {"contour_error": three, "orientation_error": {**three, "max": float("nan")}},
    }  # fmt: skip
    values = {"contour_error": np.array([0, 1e-6, 2e-6])}
    status = "failed" if failed else "done"
    t = np.arange(3) * 1e-3
    return Log.build(t, values, task=machine.task, joints=6, info=info, status=status, reason=failed)


@pytest.fixture
def fake(monkeypatch):
    """Puts a function in the place of `simulate`, and a page of one line in that of the report."""
    import gough.simulate.run as module

    calls = []

    def page(logs, folder, files=None):
        (folder / "report.html").write_text(f"{len(logs)} logs, {sorted(files or ())}")
        return folder / "report.html"

    def put(function=None):
        def simulate(machine, law, program, plant=None, **options):
            calls.append((law.kind, options))
            if options["progress"]:
                options["progress"](0.0015, 0.003)
            return function(machine, law) if function else log_of(machine, law)

        monkeypatch.setattr(module, "simulate", simulate)
        monkeypatch.setattr(import_module("gough.report"), "report", page, raising=False)
        return calls

    return put


def test_a_run_prints_a_table_and_last_where_the_report_is(gough, write, fake, tmp_path):
    calls = fake()
    write("first.toml", EXPERIMENT)
    ended = gough("run", "first.toml", "--seed", 7)
    assert ended.status == 0
    lines = ended.out.splitlines()
    assert lines[0].split() == ["PID", "computed", "torque"] or lines[0].split() == ["pid", "computed", "torque"]
    assert any(line.startswith("contour error, max") and line.count("2.00 µm") == 2 for line in lines)
    assert lines[-1] == "report: results/first/report.html"
    assert ended.err.splitlines()[0] == "running pid, computed_torque"
    assert sorted(ended.err.splitlines()[1:]) == [
        "computed_torque: done, 0.0 s simulated",
        "pid: done, 0.0 s simulated",
    ]
    made = {p.name for p in (tmp_path / "results/first").iterdir()}
    expected = {".gough", "experiment.toml", "nist-octahedral.toml", "pid.nc", "computed_torque.nc", "report.html"}
    assert made == expected
    assert sorted(kind for kind, _ in calls) == ["computed_torque", "pid"]
    assert all(options["seed"] == 7 and options["period"] == 1e-3 for _, options in calls)


def test_json_is_one_object_with_the_promised_fields_and_all_else_goes_to_stderr(gough, write, fake):
    fake()
    write("first.toml", EXPERIMENT)
    told = gough("run", "first.toml", "--json").json
    assert told["schema"] == "gough-run-1"
    assert (told["status"], told["error"]) == ("done", None)
    assert told["report"] == "results/first/report.html"
    first = told["controllers"][0]
    assert first["kind"] == "pid"
    assert first["contour_error"] == {"max": 2e-6, "rms": 1e-6, "mean": 0.5e-6}
    assert first["orientation_error"]["max"] is None, "a number that is not finite is null"
    assert first["log"] == "results/first/pid.nc"


def test_quiet_prints_nothing_but_where_the_report_is(gough, write, fake):
    fake()
    write("first.toml", EXPERIMENT)
    assert gough("run", "first.toml", "--quiet") == (0, "report: results/first/report.html\n", "")


def test_a_failed_run_writes_log_and_page_and_ends_with_one(gough, write, fake, tmp_path):
    def stopped(machine, law):
        """As simulate does with on_fail="raise": the error, with the log of what was run."""
        if law.kind != "pid":
            return log_of(machine, law)
        error = WorkspaceError("strut 3: too short", where="NC line 4", value="1.39 m", limit="1.4 m", time=0.412)
        error.log = log_of(machine, law, failed=str(error))
        raise error

    calls = fake(stopped)
    write("first.toml", EXPERIMENT)
    ended = gough("run", "first.toml")
    assert ended.status == 1
    said = "pid, NC line 4: strut 3: too short, got 1.39 m (limit 1.4 m) at t = 0.412 s"
    assert said in ended.err.splitlines()
    assert all(options["on_fail"] == "raise" for _, options in calls)
    assert Log.load(tmp_path / "results/first/pid.nc").failed
    assert not Log.load(tmp_path / "results/first/computed_torque.nc").failed
    assert (tmp_path / "results/first/report.html").exists()
    told = gough("run", "first.toml", "--json").json
    assert (told["status"], told["error"]["code"]) == ("failed", "WorkspaceError")
    (problem,) = told["error"]["problems"]
    assert (problem["rule"], problem["where"]) == ("strut 3: too short", "pid, NC line 4")
    assert (problem["value"], problem["limit"], problem["time"]) == ("1.39 m", "1.4 m", 0.412)
    assert [c["status"] for c in told["controllers"]] == ["failed", "done"]


def test_a_run_that_leaves_no_log_at_all_ends_with_one_and_leaves_no_folder(gough, write, fake, tmp_path):
    def fail(machine, law):
        raise WorkspaceError("outside the cylinder", where="pose")

    fake(fail)
    write("first.toml", EXPERIMENT)
    ended = gough("run", "first.toml")
    assert (ended.status, ended.out) == (1, "")
    assert ended.err.splitlines()[-1] == "computed_torque, pose: outside the cylinder"
    assert not (tmp_path / "results/first").exists()


def test_one_controller_without_a_log_does_not_take_the_others_logs_away(gough, write, fake, tmp_path):
    def fail(machine, law):
        if law.kind == "pid":
            raise KinematicsError("no convergence")
        return log_of(machine, law)

    fake(fail)
    write("first.toml", EXPERIMENT)
    told = gough("run", "first.toml", "--json").json
    assert told["status"] == "failed"
    assert [c["kind"] for c in told["controllers"]] == ["computed_torque"]
    assert (tmp_path / "results/first/computed_torque.nc").exists()


def test_wrong_input_ends_with_two_and_names_the_place_in_json_too(gough, write):
    write("first.toml", EXPERIMENT, {'"20 mm"': '"20 N"'})
    ended = gough("run", "first.toml", "--json")
    assert ended.status == 2
    assert ended.json == {
        "schema": "gough-run-1",
        "status": "error",
        "error": {
            "code": "ExperimentError",
            "problems": [
                {
                    "rule": "'20 N' is not a quantity in m",
                    "file": "first.toml",
                    "line": 8,
                    "key": "program.radius",
                    "cure": 'write e.g. "20 m"',
                }
            ],
        },
    }
    assert ended.err == "first.toml:8: program.radius: '20 N' is not a quantity in m; write e.g. \"20 m\"\n"


def test_an_interrupted_command_ends_with_130_and_says_so(gough, write, fake, tmp_path):
    def interrupted(machine, law):
        raise KeyboardInterrupt

    fake(interrupted)
    write("first.toml", EXPERIMENT)
    ended = gough("run", "first.toml", "--json")
    assert ended.status == 130
    assert ended.json["status"] == "failed"
    assert ended.json["error"] == {"code": "Interrupted", "problems": [{"rule": "interrupted"}]}
    assert ended.err == "gough: interrupted; nothing was written\n"
    assert list((tmp_path / "results").iterdir()) == []


def test_an_interrupted_command_ends_no_process_for_threads_that_are_not_its_own(gough, write, fake):
    def interrupted(machine, law):
        raise KeyboardInterrupt

    fake(interrupted)
    write("first.toml", EXPERIMENT)
    over = threading.Event()
    threading.Thread(target=over.wait, daemon=True).start()
    try:
        assert gough("run", "first.toml").status == 130
    finally:
        over.set()


def test_a_terminal_without_the_letters_of_the_table_gets_escapes():
    script = "import gough.cli.show as m\nm.list_machines = lambda outcome: print(chr(181))\n"
    script += "from gough.cli import main\nmain(['machines'])"
    out = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, env={**os.environ, "PYTHONIOENCODING": "ascii"}, timeout=30
    )
    assert (out.returncode, out.stdout) == (0, b"\\xb5\n")


def test_a_bug_is_one_line_that_says_so_and_debug_shows_where(gough, write, fake):
    fake(lambda machine, law: 1 / 0)
    write("first.toml", EXPERIMENT)
    ended = gough("run", "first.toml")
    assert ended.status == 1
    expected = "this is a bug in gough: ZeroDivisionError: division by zero; --debug shows where"
    assert ended.err.splitlines()[-1] == expected
    assert "Traceback" in gough("run", "first.toml", "--debug").err
    assert gough("run", "first.toml", "--json").json["error"]["code"] == "Bug"


def test_debug_shows_the_traceback_of_wrong_input_too(gough):
    assert "Traceback" in gough("check", "none.toml", "--debug").err


@pytest.mark.parametrize(
    "arguments, words",
    [
        (["run"], "Missing argument"),
        (["run", "f.toml", "--fo"], "No such option"),
        (["rnu"], "No such command"),
        (["run", "f.toml", "--seed", "x"], "should be a valid integer"),
    ],
)
def test_wrong_arguments_end_with_two(gough, arguments, words):
    ended = gough(*arguments)
    assert ended.status == 2
    assert words in ended.err
    assert ended.out == ""
    ended = gough(*arguments, "--json")
    assert ended.status == 2
    assert words in ended.json["error"]["problems"][0]["rule"]
    assert ended.json["schema"] == ("gough-run-1" if arguments[0] == "run" else "gough-arguments-1")


def test_the_controllers_of_the_command_line_are_run_instead(gough, write, fake):
    calls = fake()
    write("part.ngc", NC)
    assert gough("run", "part.ngc", "-m", "okuma-pm600", "-c", "computed_torque", "-q").status == 0
    assert [kind for kind, _ in calls] == ["computed_torque"]


def test_a_run_into_a_foreign_folder_needs_force(gough, write, fake, tmp_path):
    fake()
    write("first.toml", EXPERIMENT)
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "thesis.tex").write_text("years")
    assert gough("run", "first.toml", "-o", "mine").status == 2
    assert gough("run", "first.toml", "-o", "mine", "--force").status == 0
    assert (tmp_path / "mine" / "thesis.tex").read_text() == "years"
    assert (tmp_path / "mine" / "report.html").exists()


def test_a_report_of_logs_stands_by_itself(gough, write, fake):
    fake()
    write("first.toml", EXPERIMENT)
    gough("run", "first.toml")
    told = gough("report", "results/first/pid.nc", "results/first/computed_torque.nc", "-o", "both", "--json").json
    assert told["schema"] == "gough-report-1"
    assert told["report"] == "both/report.html"
    assert [c["log"] for c in told["controllers"]] == ["results/first/pid.nc", "results/first/computed_torque.nc"]
    ended = gough("report", "none.nc")
    assert ended.status == 2
    assert ended.err.startswith("none.nc: ")


def test_a_report_of_a_results_folder_takes_all_its_logs_and_leaves_them_there(gough, write, fake, tmp_path):
    fake()
    write("first.toml", EXPERIMENT)
    gough("run", "first.toml")
    both = ["results/first/computed_torque.nc", "results/first/pid.nc"]
    told = gough("report", "results/first", "--json").json
    assert [c["log"] for c in told["controllers"]] == both
    assert told["report"] == "results/first-report/report.html"
    assert (tmp_path / "results/first-report/report.html").read_text().startswith("2 logs")
    # its own folder would be replaced, and the logs with it
    ended = gough("report", "results/first", "-o", "results/first", "--force")
    assert ended.status == 2
    assert "the folder holds the logs themselves" in ended.err and "--out" in ended.err
    assert all((tmp_path / log).exists() for log in both)


def test_a_report_of_a_folder_without_logs_is_an_error_that_says_so(gough, tmp_path):
    (tmp_path / "empty").mkdir()
    (tmp_path / "empty" / "notes.txt").write_text("no log")
    ended = gough("report", "empty")
    assert ended.status == 2
    assert ended.err == "empty: the folder holds no log; name a results folder, or logs: files that end in .nc\n"
    assert not (tmp_path / "results").exists()


# -- check, machines, show, new ----------------------------------------------------------------------------------------


def test_check_says_what_a_file_is(gough, write):
    write("mine.toml", SHEET)
    write("part.ngc", NC)
    write("first.toml", EXPERIMENT)
    assert gough("check", "mine.toml").out.startswith(
        "mine.toml: data sheet, no mistakes; machine mine, kind hexapod, "
    )
    assert gough("check", "part.ngc").out.startswith("part.ngc: NC program, no mistakes; length ")
    told = gough("check", "part.ngc", "-m", "mine.toml", "--json").json
    assert (told["schema"], told["kind"], told["machine"]) == ("gough-check-1", "NC program", "mine.toml")
    assert told["duration"] > 0.4, "20 mm at 3 m/min take 0.4 s and some to start and stop"
    told = gough("check", "first.toml", "--json").json
    assert (told["kind"], told["controllers"]) == ("experiment", ["pid", "computed_torque"])
    assert gough("check", "first.doc").status == 2


def test_check_finds_the_mistakes_of_an_nc_program_with_their_lines(gough, write):
    write("part.ngc", "G21\nG1 X10\nG81 X1\nM2\n")
    write("first.toml", EXPERIMENT, {CIRCLE: 'file = "part.ngc"'})
    for name in ("part.ngc", "first.toml"):
        ended = gough("check", name)
        assert ended.status == 2
        lines = [line.split(": ")[0] for line in ended.err.splitlines()]
        assert "part.ngc:2" in lines and "part.ngc:3" in lines


def test_machines_lists_the_library(gough):
    told = gough("machines", "--json").json
    assert {"nist-octahedral", "okuma-pm600"} <= {row["name"] for row in told["machines"]}
    assert "okuma-pm600" in gough("machines").out


def test_show_gives_every_number_with_unit_meaning_and_source(gough):
    told = gough("show", "okuma-pm600", "--json").json
    rows = {row["key"]: row for row in told["numbers"]}
    machine = gk.load_machine("okuma-pm600")
    assert rows["platform.mass"]["value"] == machine.platform.mass
    assert rows["platform.mass"]["unit"] == "kg"
    assert np.array_equal(rows["joints.base"]["value"], machine.joints.base)
    in_theta = {name.partition("[")[0].replace("home", "home.pose") for name in machine.names}
    assert in_theta <= set(rows), "no number of the equations is left out"
    assert all(row["meaning"] for row in rows.values())
    text = gough("show", "okuma-pm600").out
    assert all(key in text for key in rows)


def test_a_library_sheet_says_where_every_number_is_from(gough):
    from gough.machine.sheet import library

    for name in library():
        rows = gough("show", name, "--json").json["numbers"]
        document = tomllib.loads(library()[name].read_text())
        given = {row["key"] for row in rows if has(document, row["key"])}
        assert [row["key"] for row in rows if row["key"] in given and not row["source"]] == [], name


def has(table, key):
    for part in key.split("."):
        if not isinstance(table, dict) or part not in table:
            return False
        table = table[part]
    return True


def test_show_of_an_experiment_gives_the_moves_of_its_program_with_its_tools(gough, write):
    write("part.ngc", "T1 M6 G43\nG0 X10\nM2\n")
    circle = 'kind = "circle"\nradius = "20 mm"\nfeed = "6 m/min"\n'
    write("tooled.toml", EXPERIMENT, {circle: 'file = "part.ngc"\n[tools]\n1 = { length = "50 mm" }\n'})
    bare, tooled = (gough("show", name, "--json").json["moves"] for name in ("part.ngc", "tooled.toml"))
    assert [move["end"][2] for move in bare] == [0, 0]
    assert [move["end"][2] for move in tooled] == [0, -0.05, -0.05]


def test_show_of_an_unknown_machine_says_the_nearest(gough):
    ended = gough("show", "okuma-600")
    assert ended.status == 2
    assert ended.err.endswith("got 'okuma-600'; did you mean okuma-pm600?\n")


@pytest.mark.parametrize("what", ["machine", "experiment"])
def test_check_accepts_a_new_file(gough, what, tmp_path):
    assert gough("new", what, "-o", "new.toml").status == 0
    ended = gough("check", "new.toml")
    assert (ended.status, ended.err) == (0, "")
    assert gough("new", what).out == (tmp_path / "new.toml").read_text()
    ended = gough("new", what, "-o", "new.toml")
    assert (ended.status, ended.err) == (2, "new.toml: there is a file already; choose another name, or add --force\n")
    assert gough("new", what, "-o", "new.toml", "--force").status == 0


def test_the_new_files_name_every_key_there_is():
    """So that a person never has to look for one: each field of the parts stands in the template, set or commented."""
    from gough.control.base import Controller
    from gough.declare import Part
    from gough.machine.hexapod import Hexapod
    from gough.machine.hexapod_parts import Strut, Tool
    from gough.machine.limits import Workspace
    from gough.mechanics.compliance import Compliance
    from gough.mechanics.friction import LuGre, Stribeck
    from gough.mechanics.load_friction import LoadLuGre, LoadStribeck
    from gough.observe.disturbance import DisturbanceObserver
    from gough.simulate.plant import Plant
    from gough.simulate.run import Run

    def names(kind):
        for name, field in kind.model_fields.items():
            yield name
            options = getattr(field.annotation, "__args__", None) or (field.annotation,)
            for inner in options:
                if isinstance(inner, type) and issubclass(inner, Part):
                    yield from names(inner)

    laws = (LuGre, Stribeck, LoadLuGre, LoadStribeck)
    wanted = {n for kind in (Hexapod, Compliance, Strut, Tool, Workspace, *laws) for n in names(kind)}
    assert {name for name in wanted if name not in cli_new.MACHINE} == set()
    wanted = (
        set(names(Run))
        | set(DisturbanceObserver.model_fields) - {"machine"}
        | (set(Plant.model_fields) - {"machine"})
        | (set(Controller.model_fields) - {"machine"})
    )
    assert {name for name in wanted if name not in cli_new.EXPERIMENT} == set()


# -- the real thing ----------------------------------------------------------------------------------------------------


@pytest.mark.full
def test_a_run_repeated_from_its_results_folder_gives_the_same_numbers(tmp_path):
    """The life of a file: run, then run what the results folder holds; same version, same processor, same bits."""
    text = EXPERIMENT.replace("20 mm", "3 mm").replace("[program]", '[plant]\npayload = "5 kg"\n[program]')
    (tmp_path / "first.toml").write_text(text)

    def gough(*arguments):
        command = [sys.executable, "-m", "gough", *arguments]
        ended = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=120)
        assert ended.returncode == 0, ended.stderr
        return json.loads(ended.stdout)

    first = gough("run", "first.toml", "--json")
    again = gough("run", "results/first/experiment.toml", "--json", "-o", "again")
    numbers = [[c["contour_error"], c["orientation_error"]] for c in first["controllers"]]
    assert numbers == [[c["contour_error"], c["orientation_error"]] for c in again["controllers"]]
    assert 0 < first["controllers"][0]["contour_error"]["rms"] < 1e-3
    for name in ("pid", "computed_torque"):
        one, two = (Log.load(tmp_path / folder / f"{name}.nc") for folder in ("results/first", "again"))
        assert np.array_equal(one["x"], two["x"])
    assert (tmp_path / "again" / "report.html").stat().st_size > 100_000


@pytest.mark.full
def test_a_program_named_like_a_log_is_kept_beside_it(gough, write, tmp_path):
    """part.nc is a usual name of an NC program, and pid.nc is that of a log."""
    write("pid.nc", "G21 F600\nG1 X1\nM2\n")
    assert gough("run", "pid.nc", "-m", "nist-octahedral", "-c", "pid", "-o", "out", "--quiet").status == 0
    assert (tmp_path / "out/pid.ngc").read_text().startswith("G21")
    assert not Log.load(tmp_path / "out/pid.nc").failed
    assert gough("check", "out/experiment.toml").status == 0


def test_show_tells_every_move_of_an_nc_program(gough, write):
    write("part.ngc", "G21 G90\nG1 X10 F600\n#1 = 20\no1 repeat [2]\nG91 X#1\no1 endrepeat\nM2\n")
    rows = [row.split() for row in gough("show", "part.ngc").out.splitlines()[1:]]
    assert rows == [["2", "G1", "10", "0", "0", "600"], ["5", "G1", "30", "0", "0", "600"],
                    ["5", "G1", "50", "0", "0", "600"]]  # fmt: skip
    told = gough("show", "part.ngc", "--json").json
    assert [move["end"][0] for move in told["moves"]] == pytest.approx([0.01, 0.03, 0.05], abs=1e-15)
    assert gough("show", "cone-frustum").out.count("\n") > 200, "a program of the library is found by its name"
    assert gough("show", "none.ngc").status == 2
