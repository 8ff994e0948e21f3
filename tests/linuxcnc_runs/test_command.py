"""gough linuxcnc run, end to end: what it writes, what it measures, what it refuses."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

from gough.cli.app import main
from gough.errors import ExperimentError, ProgramError, RunError
from gough.linuxcnc import record, sandbox
from gough.log import Log
from gough.program.nc import NCProgram

from .machines import machine_of, needs_linuxcnc

CORNER = "G21 G90\nG64 P{p}\nG1 F9000 X30\nG1 Y30\nM2\n"


def called(arguments, capsys):
    with pytest.raises(SystemExit) as ended:
        main([str(one) for one in arguments])
    return ended.value.code, capsys.readouterr()


@needs_linuxcnc
@pytest.mark.slow
def test_the_contour_error_has_the_blending_of_linuxcnc_in_it(tmp_path, capsys):
    part = tmp_path / "corner.ngc"
    part.write_text(CORNER.format(p=0.3))
    out = tmp_path / "out"
    given = f"linuxcnc run {part} -m nist-octahedral -c computed_torque -o {out} --json".split()
    status, told = called(given, capsys)
    answer = json.loads(told.out)
    assert status == 0 and answer["schema"] == "gough-linuxcnc-1" and answer["linuxcnc"]["version"] == "2.9"
    log = Log.load(tmp_path / "out" / "computed_torque.nc")
    # the corner is rounded by at most P, and by most of it at this feed; the law errs by less than 0.05 mm
    assert 0.1e-3 < log.metrics["contour_error"]["max"] < 0.35e-3
    assert 0.6 < float(log.t[-1]) < 2.0 and log.info["program"]["planner"].startswith("LinuxCNC")
    assert set(np.unique(log["line"])) == {0, 3, 4}
    kept = tmp_path / "out" / "linuxcnc"
    assert {"commands.npz", "linuxcnc.log", "nist_octahedral.ini", "nist_octahedral.c"} <= set(os.listdir(kept))
    assert "gough linuxcnc run experiment.toml" in (tmp_path / "out" / "experiment.toml").read_text()
    assert (tmp_path / "out" / "report.html").stat().st_size > 10_000


@needs_linuxcnc
@pytest.mark.full("machine")
@pytest.mark.parametrize(
    ("text", "said"),
    [
        (
            "G21 G90\nG1 F600 X5\nG1 X400\nM2\n",
            "part.ngc:3: LinuxCNC refuses it: Linear move on line 3 would exceed X's",
        ),
        ("G21 G90\nG1 F600 X240\nG1 Y240\nM2\n", "part.ngc:3: .* fails kinematicsInverse; gough check says which"),
    ],
    ids=["axis", "machine"],
)
def test_a_program_that_linuxcnc_refuses_is_refused_with_its_words_and_the_line(text, said):
    with pytest.raises(ProgramError, match=said):
        record(NCProgram(text=text, name="part.ngc"), machine_of("nist-octahedral"), timeout=60)


@needs_linuxcnc
@pytest.mark.slow
@pytest.mark.alone
def test_a_program_that_takes_too_long_is_ended_and_nothing_stays_behind():
    program = NCProgram(text="G21 G90\nG1 F60 X100\nM2\n", name="slow.ngc")
    with pytest.raises(RunError, match="did not end the program in time"):
        record(program, machine_of("nist-octahedral"), speed=1, timeout=4)
    assert not _left()


@needs_linuxcnc
@pytest.mark.full
@pytest.mark.alone
def test_ctrl_c_ends_linuxcnc_and_writes_nothing(tmp_path):
    part = tmp_path / "slow.ngc"
    part.write_text("G21 G90\nG1 F60 X100\nM2\n")
    command = [sys.executable, "-m", "gough", "linuxcnc", "run", str(part), "-m", "nist-octahedral", "--speed", "1"]
    process = subprocess.Popen(
        [*command, "-o", str(tmp_path / "out")], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE
    )
    until = time.monotonic() + 60
    while not _left() and time.monotonic() < until:
        time.sleep(0.2)
    time.sleep(1.0)
    process.send_signal(signal.SIGINT)
    _, said = process.communicate(timeout=60)
    assert process.returncode == 130 and b"nothing was written" in said
    assert not _left() and os.listdir(tmp_path) == ["slow.ngc"]


def _left() -> list[str]:
    """Processes of LinuxCNC on this machine that this user can see."""
    found = []
    for pid in filter(str.isdigit, os.listdir("/proc")):
        try:
            with open(f"/proc/{pid}/comm") as file:
                name = file.read().strip()
        except OSError:
            continue
        if name in ("rtapi_app", "milltask", "linuxcncsvr"):
            found.append(pid)
    return found


def test_only_nc_programs_run_in_linuxcnc(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(sandbox, "missing", lambda: None)
    file = tmp_path / "circle.toml"
    file.write_text(
        'schema = "gough-experiment-1"\n[machine]\nuse = "nist-octahedral"\n'
        '[program]\nkind = "circle"\nradius = "20 mm"\nfeed = "1 m/min"\n'
        '[[controller]]\nkind = "pid"\nbandwidth = "10 Hz"\n'
    )
    status, told = called(["linuxcnc", "run", file, "-o", tmp_path / "out"], capsys)
    assert status == 2 and "LinuxCNC runs NC programs" in told.err and not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("reason", "cure"),
    [
        ("not installed: linuxcnc, halcompile", "apt-get install"),
        ("LinuxCNC 2.8.4 is installed, not 2.9", "install LinuxCNC 2.9"),
        ("namespaces are refused: unshare: Operation not permitted", "run as root, or allow user namespaces"),
    ],
)
def test_where_linuxcnc_cannot_run_the_reason_and_the_cure_are_told(reason, cure, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(sandbox, "missing", lambda: reason)
    part = tmp_path / "part.ngc"
    part.write_text("G21 G90\nG1 F600 X1\nM2\n")
    status, told = called(["linuxcnc", "run", part, "-m", "nist-octahedral", "-o", tmp_path / "out"], capsys)
    assert status == 2 and reason in told.err and cure in told.err
    assert os.listdir(tmp_path) == ["part.ngc"]


@pytest.mark.parametrize(
    ("key", "value"),
    [("origin", np.array([0.01, 0, 0, 0, 0, 0])), ("tools", {1: {"length": 0.01}}), ("parameters", {100: 1.0})],
)
def test_options_that_linuxcnc_would_not_know_of_are_refused(key, value, monkeypatch):
    monkeypatch.setattr(sandbox, "missing", lambda: None)
    program = NCProgram(text="G21 G90\nG1 F600 X1\nM2\n", **{key: value})
    with pytest.raises(ExperimentError, match=rf"program\.{key}: LinuxCNC is run without this option"):
        record(program, machine_of("nist-octahedral"))


@needs_linuxcnc
@pytest.mark.slow
@pytest.mark.parametrize("delete", [True, False])
def test_lines_with_a_slash_are_left_out_as_gough_leaves_them_out(delete):
    program = NCProgram(text="G21 G90\nG1 F1200 X1\n/G1 Y2\nM2\n", block_delete=delete)
    found = record(program, machine_of("nist-octahedral"), timeout=60)
    assert abs(found.axis[-1, 1] - (0.0 if delete else 2e-3)) < 1e-12


@pytest.mark.parametrize(
    ("option", "value"), [("speed", 0), ("speed", 51), ("timeout", 0.0), ("timeout", float("nan"))]
)
def test_a_clock_that_cannot_run_is_refused(option, value, monkeypatch):
    monkeypatch.setattr(sandbox, "missing", lambda: None)
    with pytest.raises(ExperimentError, match=f"--{option}"):
        record(NCProgram(text="G0 X1\nM2\n"), machine_of("nist-octahedral"), **{option: value})
