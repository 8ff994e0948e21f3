"""From a file to checked objects, and back to files that repeat the run."""

from __future__ import annotations

from importlib.metadata import EntryPoint

import numpy as np
import pytest

from gough.errors import ExperimentError, SheetError
from gough.experiment import laws as laws
from gough.experiment import load_experiment
from gough.experiment.resolve import resolved
from gough.machine.sheet import library, load_machine, overridden
from sample_files import CIRCLE, EXPERIMENT, SHEET

NC = "G21 G90\nG1 X10 F3000\nG1 X0\nM2\n"


def test_an_experiment_is_what_its_file_says(write):
    experiment = load_experiment(write("first.toml", EXPERIMENT))
    assert experiment.name == "first"
    assert experiment.machine == load_machine("nist-octahedral")
    assert experiment.plant is None
    assert experiment.program.radius == 0.02 and experiment.program.feed == 0.1
    assert [(c.kind, c.law.bandwidth) for c in experiment.controllers] == [("pid", 10.0), ("computed_torque", 10.0)]
    assert experiment.run.period == 1e-3


def test_a_machine_key_changes_what_is_believed_and_a_plant_key_only_what_is_true(write):
    changes = {
        'use = "nist-octahedral"': 'use = "nist-octahedral"\n"platform.mass" = "310 kg"\n'
        '[machine.friction]\nstatic = "1.5 x"'
    }
    plant = '[plant]\n"friction.coulomb" = "1.2 x"\npayload = "20 kg"\nlimits = { cone = "50 deg" }\n[program]'
    experiment = load_experiment(write("f.toml", EXPERIMENT, changes | {"[program]": plant}))
    known = load_machine("nist-octahedral")
    assert experiment.machine.platform.mass == 310
    assert experiment.machine.friction.static == 1.5 * known.friction.static
    assert experiment.machine.friction.coulomb == known.friction.coulomb
    assert experiment.plant.machine.friction.coulomb == 1.2 * known.friction.coulomb
    assert experiment.plant.machine.platform.mass == 310, "the truth starts from what is believed"
    assert experiment.plant.machine.limits.cone == pytest.approx(np.deg2rad(50), rel=1e-15)
    assert experiment.plant.payload == 20


def test_paths_are_relative_to_the_experiment_and_not_to_the_working_directory(tmp_path, monkeypatch):
    folder = tmp_path / "deep"
    folder.mkdir()
    (folder / "mine.toml").write_text(SHEET)
    (folder / "part.ngc").write_text(NC)
    text = EXPERIMENT.replace('"nist-octahedral"', '"mine.toml"').replace(CIRCLE, 'file = "part.ngc"')
    (folder / "f.toml").write_text(text)
    monkeypatch.chdir(tmp_path)
    experiment = load_experiment("deep/f.toml")
    assert experiment.machine.name == "mine"
    assert experiment.program.text == NC


def test_a_bare_nc_program_runs_with_the_arguments_of_the_command_line(write):
    experiment = load_experiment(
        write("part.ngc", NC), machine="okuma-pm600", controllers=["pid", "computed_torque"], seed=3
    )
    assert experiment.name == "part"
    assert experiment.machine == load_machine("okuma-pm600")
    assert [c.kind for c in experiment.controllers] == ["pid", "computed_torque"]
    assert experiment.run.seed == 3


def test_a_bare_nc_program_says_what_is_missing_by_the_name_of_the_option(write):
    path = write("part.ngc", NC)
    with pytest.raises(ExperimentError) as caught:
        load_experiment(path)
    assert (
        str(caught.value)
        == "--machine: is missing; give one of ccu-3prs, emps, eth-hexaglide, ifma-hsm, nist-octahedral, okuma-pm600, "
        "or a data sheet (.toml)"
    )
    with pytest.raises(ExperimentError) as caught:
        load_experiment(path, machine="okuma", controllers=["pdi"])
    assert str(caught.value).splitlines() == [
        "--machine: no machine of the library has this name, got 'okuma'; did you mean okuma-pm600?",
        "--controller: no such controller, got 'pdi'; did you mean pid?",
    ]


def test_a_mistake_of_a_run_that_no_option_of_the_command_line_can_cure_does_not_blame_one(write):
    path = write("part.ngc", NC)
    document = load_experiment(path, machine="okuma-pm600").document
    told = [str(document.locate(ExperimentError("is wrong", key=key))) for key in ("run.seed", "run.log_every")]
    assert told == ["--seed: is wrong", f"{path}: is wrong"]


def test_arguments_take_the_place_of_what_the_file_says_and_a_law_of_the_file_keeps_its_numbers(write):
    path = write("f.toml", EXPERIMENT, {'kind = "pid"\nbandwidth = "10 Hz"': 'kind = "pid"\nbandwidth = "7 Hz"'})
    experiment = load_experiment(path, machine="okuma-pm600", controllers=["pid"], seed=5)
    assert experiment.machine.name == "okuma-pm600"
    assert [(c.kind, c.law.bandwidth) for c in experiment.controllers] == [("pid", 7.0)]
    assert experiment.run.seed == 5


def test_two_controllers_of_one_kind_have_two_labels(write):
    experiment = load_experiment(write("f.toml", EXPERIMENT, {'"computed_torque"': '"pid"'}))
    assert experiment.labels == ["pid", "pid-2"]


@pytest.mark.parametrize("name, near", [("cone-frustrum", "cone-frustum"), ("zig", "zigzag"), ("s-pice", "s-piece")])
def test_a_name_that_is_nearly_one_of_the_library_s_programs_gets_the_right_one(name, near, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(ExperimentError) as caught:
        load_experiment(name, machine="okuma-pm600")
    rule = "no file, and no NC program of the library, has this name"
    assert str(caught.value) == f"{rule}, got '{name}'; did you mean {near}?"


def test_only_experiments_and_nc_programs_can_be_run(write):
    with pytest.raises(
        ExperimentError, match=r"f\.yaml: cannot be run; give an experiment \(\.toml\) or an NC program"
    ):
        load_experiment(write("f.yaml", EXPERIMENT))
    with pytest.raises(ExperimentError, match="schema: this is a data sheet of a machine, not an experiment"):
        load_experiment(write("f.toml", SHEET))


def test_a_controller_does_not_bring_its_own_machine(write):
    path = write("f.toml", EXPERIMENT, {'kind = "pid"': 'kind = "pid"\nmachine = {}'})
    with pytest.raises(ExperimentError, match="f.toml:13: controller.0.machine: no such key"):
        load_experiment(path)


# -- laws of installed packages ---------------------------------------------------------------------------------------


@pytest.fixture
def installed(monkeypatch):
    """Pretends that a package offers laws by the entry point."""

    def offer(**places):
        points = [EntryPoint(name, place, laws.GROUP) for name, place in places.items()]
        monkeypatch.setattr(laws, "entry_points", lambda group: points)
        laws.laws.cache_clear()

    yield offer
    laws.laws.cache_clear()


def test_a_law_of_an_installed_package_is_found_by_its_name(installed):
    installed(theirs="gough.control.pid:PID")
    assert laws.law_class("theirs").__name__ == "PID"
    assert list(laws.laws()) == sorted([*laws.OWN, "theirs"])


def test_a_package_cannot_take_the_name_of_a_law_of_gough(installed):
    installed(pid="os:system")
    assert laws.law_class("pid").__name__ == "PID"


def test_a_package_that_cannot_be_imported_or_offers_no_law_is_named(installed):
    installed(broken="no_such_package:Law", wrong="os:system")
    with pytest.raises(ExperimentError, match="kind: the controller of package no_such_package:Law cannot be imported"):
        laws.law_class("broken")
    with pytest.raises(ExperimentError, match="kind: os:system is not a law"):
        laws.law_class("wrong")


# -- overriding a machine ---------------------------------------------------------------------------------------------


def test_a_table_of_another_kind_takes_the_place_of_the_old_one():
    machine = overridden(load_machine("nist-octahedral"), {"friction": {"kind": "stribeck", "coulomb": "10 N"}})
    assert (machine.friction.kind, machine.friction.coulomb) == ("stribeck", 10)


def test_a_table_gives_a_machine_what_it_had_not(write):
    machine = load_machine(write("mine.toml", SHEET))
    assert machine.friction is None and machine.limits.workspace is None
    table = {
        "friction": {"kind": "stribeck", "coulomb": "10 N"},
        "limits": {"workspace": {"radius": "1 m", "height": "1 m", "tilt": "1 rad", "c": "1 rad"}},
    }
    changed = overridden(machine, table)
    assert changed.friction.coulomb == 10
    assert changed.limits.workspace.radius == 1
    assert changed.replace(friction=None, limits=machine.limits) == machine, "and nothing else is changed"


def test_the_home_pose_is_changed_as_the_sheet_writes_it(write):
    machine = load_machine(write("mine.toml", SHEET))
    pose = ["1 mm", "0 mm", "0 mm", "0 deg", "0 deg", "0 deg"]
    for table in ({"home": {"pose": pose}}, {"home.pose": pose}):
        assert overridden(machine, table).home[0] == 1e-3


def test_all_mistakes_of_a_change_come_at_once():
    with pytest.raises(SheetError) as caught:
        table = {"platform": {"mas": "1 kg", "mass": "-1 kg"}, "friction.coulmb": "1 N", "tool": {"positon": 1}}
        overridden(load_machine("nist-octahedral"), table)
    assert {p.key for p in caught.value.problems} == {
        "platform.mas",
        "platform.mass",
        "friction.coulmb",
        "tool.positon",
        "tool.position",
    }


def test_every_machine_of_the_library_is_read_and_written_to_an_equal_one():
    for name in library():
        machine = load_machine(name)
        assert machine.name == name
        assert type(machine).from_file(machine.to_file()) == machine


# -- what repeats the run ---------------------------------------------------------------------------------------------


def test_the_resolved_files_give_the_same_experiment_from_another_folder(write, tmp_path):
    write("mine.toml", SHEET)
    write("my part é.ngc", NC)
    changes = {
        'use = "nist-octahedral"': 'use = "./mine.toml"\n"platform.mass" = "1.1 x"',
        CIRCLE: 'file = "my part é.ngc"\norigin = ["1 mm", "0 mm", "0 mm", "0 deg", "0 deg", "0 deg"]',
        "[run]": '[plant]\n"drive.lead" = "1.01 x"\n[run]',
    }
    first = load_experiment(write("f.toml", EXPERIMENT, changes), seed=9)
    again = tmp_path / "again"
    again.mkdir()
    for name, text in resolved(first).items():
        assert name.isascii()
        (again / name).write_text(text)
    second = load_experiment(again / "experiment.toml")
    assert (second.machine, second.plant, second.controllers, second.run) == (
        first.machine,
        first.plant,
        first.controllers,
        first.run,
    )
    assert second.program.replace(name="") == first.program.replace(name="")
    assert (
        resolved(second)["experiment.toml"].partition("schema")[2]
        == resolved(first)["experiment.toml"].partition("schema")[2]
    )


def test_the_resolved_experiment_states_the_defaults_so_that_a_later_version_cannot_change_them(write):
    text = resolved(load_experiment(write("f.toml", EXPERIMENT)))["experiment.toml"]
    assert "speed_ratio = 3.0" in text and "log_every = 1" in text and "seed = 0" in text


def test_a_machine_named_experiment_does_not_overwrite_the_experiment(write):
    write("m.toml", SHEET, {'"mine"': '"experiment"'})
    files = resolved(load_experiment(write("f.toml", EXPERIMENT, {'"nist-octahedral"': '"m.toml"'})))
    assert set(files) == {"experiment.toml", "used-experiment.toml"}


def test_a_wrong_kind_does_not_hide_the_other_mistakes_of_its_table(write):
    text = EXPERIMENT.replace('kind = "pid"\n', 'kind = "pdi"\nbandwith = "9 Hz"\n')
    with pytest.raises(ExperimentError) as caught:
        load_experiment(write("a.toml", text))
    told = [(p.key, p.cure) for p in caught.value.problems]
    assert ("controller.0.kind", "did you mean pid?") in told
    assert ("controller.0.bandwith", "did you mean bandwidth?") in told


def test_another_kind_of_friction_is_another_table(write):
    text = EXPERIMENT + '\n[plant]\n"friction.kind" = "stribeck"\n'
    with pytest.raises(ExperimentError, match="plant.friction.kind: another kind is another table"):
        load_experiment(write("a.toml", text))
    whole = EXPERIMENT + '\n[plant]\nfriction = { kind = "stribeck", coulomb = "200 N" }\n'
    assert load_experiment(write("b.toml", whole)).plant.machine.friction.kind == "stribeck"


def test_a_wrong_kind_of_program_does_not_hide_the_rest_either(write):
    text = EXPERIMENT.replace(CIRCLE, 'kind = "cirle"\nradius = "20"\nfeed = "6 m/min"')
    with pytest.raises(ExperimentError) as caught:
        load_experiment(write("a.toml", text))
    assert [p.key for p in caught.value.problems] == ["program.kind", "program.radius"]


# -- NC programs with tools, parameters and called files ------------------------------------------------------------

CALLING = "T2 M6 G43\nG55 G0 X0 Z5\no<slot> call [3]\nM2\n"
TOOLS = '[tools]\n2 = { length = "80 mm", diameter = "10 mm" }\n'


@pytest.fixture
def with_tools(tmp_path):
    """An experiment whose program needs a tool table, a parameter file and a called file."""
    (tmp_path / "part.ngc").write_text(CALLING)
    (tmp_path / "subs").mkdir()
    (tmp_path / "subs" / "slot.ngc").write_text("o<slot> sub\nG1 Z-#1 F300\nX20\no<slot> endsub\n")
    (tmp_path / "linuxcnc.var").write_text("5241 7.5\n")
    keys = 'file = "part.ngc"\nparameters = "linuxcnc.var"\nsubroutines = "subs"'
    file = tmp_path / "part.toml"
    file.write_text(EXPERIMENT.replace(CIRCLE, keys) + "\n" + TOOLS)
    return file


def test_tools_parameters_and_called_files_come_from_where_the_experiment_says(with_tools):
    program = load_experiment(with_tools).program
    path = program.path()
    np.testing.assert_allclose(
        path.point(np.array([len(path) - 1]), path.length[-1:])[0], [27.5e-3, 0, -3e-3], atol=1e-15
    )
    np.testing.assert_allclose(path.tool[-1], [0, 0, 0.08])


def test_a_run_with_tools_and_called_files_is_repeated_from_its_folder_alone(with_tools, tmp_path):
    first = load_experiment(with_tools)
    folder = tmp_path / "results"
    for name, text in resolved(first).items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text)
    for file in (tmp_path / "subs" / "slot.ngc", tmp_path / "linuxcnc.var", tmp_path / "part.ngc"):
        file.unlink()
    again = load_experiment(folder / "experiment.toml")
    assert again.program == first.program
    assert again.program.tools == first.program.tools


@pytest.mark.parametrize(
    "old, new, message",
    [
        ('"80 mm"', "80", "{}:{}: tools.2.length: has no unit, got 80"),
        ("length =", "lenth =", "{}:{}: tools.2.lenth: no such key; did you mean length?"),
        ("2 = {", "-2 = {", "{}:{}: tools.-2: a tool's number is a whole number above 0, got '-2'"),
        (TOOLS, '[tools]\nfile = "no.tbl"\n', "no.tbl: cannot be read: No such file or directory"),
        (TOOLS, '[tools]\nfile = 3\n', "{}:{}: tools.file: must be the name of a file, got 3"),
        ('"subs"', "3", "{}:{}: program.subroutines: must be the name of a folder, got 3"),
        (
            'file = "part.ngc"\nparameters = "linuxcnc.var"\nsubroutines = "subs"', CIRCLE,
            "{}:{}: tools: only an NC program uses tools; remove the table",
        ),
    ],
)  # fmt: skip
def test_what_is_wrong_with_tools_is_told_with_its_line(with_tools, old, new, message):
    text = with_tools.read_text().replace(old, new)
    with_tools.write_text(text)
    with pytest.raises(ExperimentError) as caught:
        load_experiment(with_tools)
    wanted = new if not new.startswith(("[tools]", "kind")) else new.splitlines()[-1]
    wanted = "[tools]" if ": tools: " in message else wanted
    line = next((n for n, row in enumerate(text.splitlines(), 1) if wanted.splitlines()[0] in row), None)
    assert message.format(with_tools, line) in str(caught.value)


def test_a_law_that_does_not_fit_the_machine_is_told_with_its_line_and_every_one_of_them(tmp_path):
    """What only machine and period together can refuse: `gough check` names the controller, the key and the line."""
    from gough.cli.check import check_file
    from gough.cli.end import Outcome

    file = tmp_path / "e.toml"
    table = '[[controller]]\nkind = "{}"\nslope = "100 1/s"\ndamping = "3700 1/s"\n'
    file.write_text(
        'schema = "gough-experiment-1"\n[machine]\nuse = "nist-octahedral"\n[program]\nkind = "circle"\n'
        'radius = "50 mm"\nfeed = "3 m/min"\n' + table.format("robust_adaptive") + table.format("fuzzy_friction")
    )
    with pytest.raises(ExperimentError, match="sample time is too long") as error:
        check_file(file, None, True, Outcome("check", False))
    assert [(p.line, p.key) for p in error.value.problems] == [
        (11, "controller.0.damping"), (15, "controller.1.damping"),
    ]  # fmt: skip
