"""gough export --target linuxcnc: configuration, licences, names, refusals.  LinuxCNC itself: linuxcnc_runs."""

from __future__ import annotations

import configparser
import os
import re
import shutil
import subprocess

import numpy as np
import pytest

import gough as gk
from gough.cli.app import main
from gough.errors import ExperimentError
from gough.export.linuxcnc import config, core, files_of, linuxcnc_files

MACHINES = {"nist-octahedral": "XYZABC", "eth-hexaglide": "XYZABC", "ccu-3prs": "XYZ"}
WORDS = {"NAME": "m", "VERSION": "0"}


def ini_of(machine):
    found = configparser.ConfigParser(strict=False)
    found.optionxform = str
    found.read_string(config.ini(machine, WORDS, 1e-3, 1e-3, 1e-4))
    return found


@pytest.mark.parametrize("name", MACHINES)
def test_home_of_the_joints_is_the_inverse_kinematics_of_the_axes_zero_to_the_last_bit(name):
    machine = gk.load_machine(name)
    ini = ini_of(machine)
    home = [float(ini[f"JOINT_{i}"]["HOME"]) for i in range(machine.joints_count)]
    assert home == (machine.inverse_kinematics(machine.home) * 1e3).tolist()
    assert ini["TRAJ"]["COORDINATES"].replace(" ", "") == MACHINES[name]
    assert set(ini["TRAJ"]["HOME"].split()) == {"0"} and ini["TRAJ"]["LINEAR_UNITS"] == "mm"


def test_limits_are_those_of_the_data_sheet_in_mm_and_degrees():
    machine = gk.load_machine("nist-octahedral")  # 1.40 ... 1.90 m, 18 m/min, 10 m/s2; 12 m/min, 2 m/s2, 20 deg/s
    ini = ini_of(machine)
    joint, x, c = ini["JOINT_3"], ini["AXIS_X"], ini["AXIS_C"]
    assert [float(joint[key]) for key in ("MIN_LIMIT", "MAX_LIMIT")] == [1400.0, 1900.0]
    assert [float(joint[key]) for key in ("MAX_VELOCITY", "MAX_ACCELERATION")] == [300.0, 10_000.0]
    assert [float(x[key]) for key in ("MIN_LIMIT", "MAX_LIMIT")] == [-250.0, 250.0]
    assert [float(x[key]) for key in ("MAX_VELOCITY", "MAX_ACCELERATION")] == [200.0, 2000.0]
    assert [float(c[key]) for key in ("MIN_LIMIT", "MAX_LIMIT", "MAX_VELOCITY")] == [-30.0, 30.0, 20.0]
    assert float(joint["FERROR"]) == 1.0 and float(joint["MIN_FERROR"]) == 0.1


def test_a_turned_home_turns_the_box_of_the_axes():
    machine = gk.load_machine("nist-octahedral")
    machine = machine.replace(**{"limits.workspace.radius": None, "limits.workspace.size": [0.2, 0.1]})
    low, high = config.axis_range(machine)
    assert np.allclose(high[:3], [0.1, 0.05, 0.1]) and np.allclose(low, -high)
    turned = machine.replace(home=[0, 0, 0, 0, 0, 0.3])
    c, s = np.cos(0.3), np.sin(0.3)
    about = [0.1 * c + 0.05 * s, 0.1 * s + 0.05 * c, 0.1]  # what the turned box needs along the axes of the program
    assert np.allclose(config.axis_range(turned)[1][:3], about, atol=1e-15)


@pytest.mark.parametrize("key", ["limits.speed", "limits.acceleration", "limits.workspace"])
def test_a_machine_without_limits_is_refused_with_the_line_to_write(key):
    machine = gk.load_machine("nist-octahedral").replace(**{key: None})
    with pytest.raises(ExperimentError, match=rf"{key}: a machine for LinuxCNC must have its limits; write \w+ = "):
        files_of(machine)


@pytest.mark.parametrize("name", ["emps", "ifma-hsm"])
def test_kinds_without_kinematics_for_linuxcnc_are_refused_by_name(name):
    with pytest.raises(ExperimentError, match=rf"no kinematics for LinuxCNC.*{name}.*hexapod, hexaglide, tripod"):
        files_of(gk.load_machine(name))


@pytest.mark.parametrize("name", ["3prs", "my machine", "a;b", "int", "", "x" * 21, "a__b", "end_", "ä"])
def test_a_name_that_c_or_hal_does_not_take_is_refused(name):
    with pytest.raises(ExperimentError, match="--name"):
        core.identifier(gk.load_machine("nist-octahedral"), name)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"period": 1e-6}, "servo thread"),
        ({"period": float("nan")}, "servo thread"),
        ({"ferror": 1e-4, "min_ferror": 2e-4}, "min_ferror"),
        ({"min_ferror": float("nan")}, "min_ferror"),
    ],
)
def test_numbers_that_linuxcnc_cannot_take_are_refused(options, said):
    with pytest.raises(ExperimentError, match=said):
        files_of(gk.load_machine("nist-octahedral"), **options)


def test_numbers_as_an_argument_are_for_c_alone():
    with pytest.raises(ExperimentError, match=r"--theta: modules of LinuxCNC have the machine's numbers"):
        linuxcnc_files(gk.load_machine("nist-octahedral"), theta="argument")


@pytest.fixture(scope="module")
def files():
    return files_of(gk.load_machine("nist-octahedral"), "hexa")


@pytest.mark.full
def test_glue_is_gpl_and_maths_is_not_and_needs_nothing_of_linuxcnc(files):
    for name, text in files.items():
        if name.endswith((".c", ".h", ".comp")):
            glue = name.endswith(".comp") or "_kins" in name
            licence = re.search(r"SPDX-License-Identifier: ([\w.-]+)", text)[1]
            assert licence == ("GPL-2.0-or-later" if glue else "0BSD"), name
            taken = set(re.findall(r'#include [<"]([^>"]+)[>"]', text))
            assert glue or not taken & {"hal.h", "rtapi.h", "kinematics.h"}, name
    assert not [name for name, text in files.items() if re.search(r"@[A-Z_]+@", text)]  # every word is filled in


@pytest.mark.full
def test_an_export_made_twice_is_the_same_text(files):
    assert files_of(gk.load_machine("nist-octahedral"), "hexa") == files


@pytest.mark.full
@pytest.mark.skipif(shutil.which("halcompile") is None, reason="no halcompile")
@pytest.mark.parametrize("name", [pytest.param("nist-octahedral", marks=pytest.mark.slow), "ccu-3prs"])
def test_an_export_compiles_without_a_word_of_the_compiler(name, tmp_path, capsys):
    with pytest.raises(SystemExit) as ended:
        main(["export", name, "--target", "linuxcnc", "-o", str(tmp_path / "out")])
    assert ended.value.code == 0 and "a simulation for LinuxCNC" in capsys.readouterr().out
    done = subprocess.run(["make", "-C", str(tmp_path / "out")], capture_output=True, text=True)
    assert done.returncode == 0
    assert not [line for line in done.stderr.splitlines() if "warning" in line or "error" in line]
    assert len([one for one in os.listdir(tmp_path / "out") if one.endswith(".so")]) == 4


@pytest.mark.full
def test_a_folder_with_other_files_is_left_alone(tmp_path, capsys):
    (tmp_path / "mine").write_text("x")
    with pytest.raises(SystemExit) as ended:
        main(["export", "nist-octahedral", "--target", "linuxcnc", "-o", str(tmp_path)])
    assert ended.value.code == 2 and "files that gough did not make" in capsys.readouterr().err
    assert os.listdir(tmp_path) == ["mine"]


@pytest.mark.full
def test_observer_and_supervision_of_an_experiment_go_into_its_export(tmp_path):
    from gough.experiment import load_experiment
    from gough.export import export_folder

    file = tmp_path / "e.toml"
    file.write_text(
        'schema = "gough-experiment-1"\n[machine]\nuse = "nist-octahedral"\n'
        '[program]\nkind = "circle"\nradius = "20 mm"\nfeed = "1 m/min"\n'
        '[[controller]]\nkind = "pid"\nbandwidth = "10 Hz"\n[observer]\nkind = "disturbance"\nbandwidth = "50 Hz"\n'
        '[run]\nperiod = "2 ms"\nferror = "0.6 mm"\nmin_ferror = "0.2 mm"\n'
    )
    made = export_folder(load_experiment(file), "linuxcnc")
    following = made["nist_octahedral_following.comp"]
    assert "least = 0.2 " in following and "slope = 0.002 " in following  # 0.6 mm at 300 mm/s
    assert "SERVO_PERIOD = 2000000" in made["nist_octahedral.ini"]
    period = re.search(r"PERIOD (\S+) ", made["nist_octahedral_wrench.h"])[1]
    assert float.fromhex(period) == 2e-3
    assert made["nist_octahedral_wrench.c"] != files_of(gk.load_machine("nist-octahedral"))["nist_octahedral_wrench.c"]
