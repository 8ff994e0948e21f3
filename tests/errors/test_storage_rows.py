"""RELIABILITY.md, rows F1 to F4: damaged results, killed and interrupted runs, full disks."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import textwrap
import time

import pytest

from sample_files import CIRCLE, EXPERIMENT

GOUGH = [sys.executable, "-m", "gough"]
# one pid over ten minutes of simulated time: some seconds of computing, long enough to be stopped in the middle
LONG = {
    CIRCLE: 'kind = "circle"\nradius = "200 mm"\nfeed = "0.3 m/min"\nturns = 10',
    '[[controller]]\nkind = "computed_torque"\nbandwidth = "10 Hz"\n': "",
    'period = "1 ms"': 'period = "1 ms"\nlog_every = 1000',
}


def logs_of(gough, write, name="f.toml"):
    write(name, EXPERIMENT, {CIRCLE: CIRCLE.replace("20 mm", "2 mm")})
    assert gough("run", name, "--controller", "pid", "--quiet").status == 0


@pytest.mark.full
def test_f1_a_truncated_or_changed_log_is_refused_and_said_how_to_get_a_whole_one(gough, write, tmp_path):
    logs_of(gough, write)
    whole = (tmp_path / "results/f/pid.nc").read_bytes()
    for data in (whole[:-1], whole[: len(whole) // 2], whole[:100], b"", whole[:5000] + b"\x00\x01" + whole[5002:]):
        (tmp_path / "cut.nc").write_bytes(data)
        ended = gough("report", "cut.nc", "-o", "out")
        assert ended.status == 2
        assert ended.err.startswith("cut.nc: ")
        assert "whole" in ended.err
        assert not (tmp_path / "out").exists()


@pytest.mark.full
def test_f2_a_killed_run_leaves_the_old_results_and_the_next_one_cleans_up(gough, write, tmp_path):
    logs_of(gough, write)
    before = {p.name: p.read_bytes() for p in (tmp_path / "results/f").iterdir()}
    write("f.toml", EXPERIMENT, LONG)
    process = subprocess.Popen([*GOUGH, "run", "f.toml"], cwd=tmp_path, stderr=subprocess.PIPE, text=True)
    process.stderr.readline()  # "running pid"
    time.sleep(1.0)
    process.send_signal(signal.SIGKILL)
    process.wait()
    process.stderr.close()
    assert {p.name: p.read_bytes() for p in (tmp_path / "results/f").iterdir()} == before
    assert len(os.listdir(tmp_path / "results")) == 2, "the partial folder of the killed run"
    logs_of(gough, write)
    assert os.listdir(tmp_path / "results") == ["f"]


@pytest.mark.parametrize("number, word", [(signal.SIGINT, "interrupted"), (signal.SIGTERM, "terminated")])
@pytest.mark.parametrize("wait", [0.0, 0.6, 2.5], ids=["while it prepares", "while it compiles", "while it runs"])
@pytest.mark.full("while it prepares-2-*", "while it runs-2-*", "while it compiles-15-*")
def test_f3_a_signal_ends_a_run_within_two_seconds_and_leaves_nothing(write, tmp_path, number, word, wait):
    write("f.toml", EXPERIMENT, LONG)
    # a job that a shell put into the background would ignore Ctrl-C, and so would all it starts
    listen = {"preexec_fn": lambda: signal.signal(signal.SIGINT, signal.SIG_DFL)}
    process = subprocess.Popen([*GOUGH, "run", "f.toml"], cwd=tmp_path, stdout=-1, stderr=-1, text=True, **listen)
    assert process.stderr.readline() == "running pid\n"
    time.sleep(wait)
    assert process.poll() is None, "the run must be long enough to be interrupted"
    sent = time.monotonic()
    process.send_signal(number)
    out, err = process.communicate(timeout=10)
    assert time.monotonic() - sent < 2  # RELIABILITY.md F3
    assert process.returncode == 130
    assert err.endswith(f"gough: {word}; nothing was written\n")
    assert "Traceback" not in err
    assert os.listdir(tmp_path / "results") == []


@pytest.mark.full
def test_f4_a_full_disk_is_said_with_file_and_space_and_the_old_results_stay(gough, write, tmp_path):
    """A limit of the file size stands for the disk; it strikes in the log, the largest file written by HDF5."""
    logs_of(gough, write)
    before = {p.name: p.read_bytes() for p in (tmp_path / "results/f").iterdir()}
    script = """
        import resource, sys
        from gough.cli import main
        resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, 100_000))
        main(["run", "f.toml", "--controller", "pid", "--quiet"])
    """
    ended = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(script)], cwd=tmp_path, capture_output=True, text=True, timeout=60
    )
    assert ended.returncode == 1, ended.stderr
    assert "results/f/pid.nc: cannot be written, got " in ended.stderr
    assert "B free in " in ended.stderr
    assert "Traceback" not in ended.stderr
    assert {p.name: p.read_bytes() for p in (tmp_path / "results/f").iterdir()} == before
    assert os.listdir(tmp_path / "results") == ["f"]


def test_f4_a_results_folder_that_cannot_be_made_is_said_before_anything_is_computed(gough, write):
    write("f.toml", EXPERIMENT)
    write("file", "")
    ended = gough("run", "f.toml", "-o", "file/out")
    assert ended.status == 1
    assert (
        ended.err.startswith("file/out: cannot be written, got ") or "/file/out: cannot be written, got " in ended.err
    )
    assert "running" not in ended.err


def test_f4_a_foreign_folder_is_refused_before_anything_is_computed(gough, write, tmp_path):
    write("f.toml", EXPERIMENT)
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "thesis.tex").write_text("years")
    ended = gough("run", "f.toml", "-o", "mine")
    assert (ended.status, ended.out) == (2, "")
    assert ended.err == (
        "--out: the folder holds files that gough did not make, got mine; "
        "choose another with --out, or add --force to write beside them\n"
    )
