"""A results folder is old or new, never half, whatever happens to the run."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time

import pytest

from gough import results
from gough.errors import ExperimentError, StorageError
from gough.results import made_by_gough, results_folder


def build(path, **files):
    with results_folder(path) as folder:
        for name, text in files.items():
            (folder / name).write_text(text)


def content(folder):
    return {p.name: p.read_text() for p in folder.iterdir() if p.name != ".gough"}


def test_a_folder_appears_whole_with_its_marker(tmp_path):
    with results_folder(tmp_path / "deep" / "run") as folder:
        (folder / "log").write_text("1")
        assert not (tmp_path / "deep" / "run").exists()
    assert content(tmp_path / "deep" / "run") == {"log": "1"}
    assert made_by_gough(tmp_path / "deep" / "run")
    assert os.listdir(tmp_path / "deep") == ["run"]


def test_the_next_run_replaces_what_gough_made_and_keeps_what_a_person_added(tmp_path):
    run = tmp_path / "run"
    build(run, log="1", plot="1")
    (run / "notes.txt").write_text("mine")
    (run / "mine").mkdir()
    (run / "mine" / "a").write_text("b")
    build(run, log="2")
    assert (run / "mine" / "a").read_text() == "b"
    assert {p.name for p in run.iterdir()} == {".gough", "log", "notes.txt", "mine"}
    assert (run / "log").read_text() == "2"
    build(run, log="3")
    assert (run / "notes.txt").read_text() == "mine"


def test_a_run_that_ends_with_an_error_leaves_the_old_folder(tmp_path):
    run = tmp_path / "run"
    build(run, log="1")
    with pytest.raises(KeyboardInterrupt), results_folder(run) as folder:
        (folder / "log").write_text("2")
        raise KeyboardInterrupt
    assert content(run) == {"log": "1"}
    assert os.listdir(tmp_path) == ["run"]


def test_a_folder_that_gough_did_not_make_is_refused(tmp_path):
    (tmp_path / "thesis.tex").write_text("years")
    with pytest.raises(ExperimentError) as caught, results_folder(tmp_path):
        pass
    assert str(caught.value) == (
        f"--out: the folder holds files that gough did not make, got {tmp_path}; "
        "choose another with --out, or add --force to write beside them"
    )


def test_with_force_results_stand_beside_foreign_files_and_are_not_taken_for_goughs_folder(tmp_path):
    (tmp_path / "thesis.tex").write_text("years")
    with results_folder(tmp_path, force=True) as folder:
        (folder / "log").write_text("1")
        (folder / "plots").mkdir()
        (folder / "plots" / "a").write_text("p")
    assert (tmp_path / "thesis.tex").read_text() == "years"
    assert (tmp_path / "plots" / "a").read_text() == "p"
    assert not made_by_gough(tmp_path)


def test_an_empty_folder_is_taken_and_a_file_is_not(tmp_path):
    (tmp_path / "empty").mkdir()
    build(tmp_path / "empty", log="1")
    assert content(tmp_path / "empty") == {"log": "1"}
    (tmp_path / "file").write_text("")
    with pytest.raises(ExperimentError, match="must be a folder"), results_folder(tmp_path / "file", force=True):
        pass


def test_a_marker_without_a_finished_run_does_not_open_a_folder(tmp_path):
    (tmp_path / ".gough").write_text('{"schema": "gough-results-1", "finished": false}')
    with pytest.raises(ExperimentError, match="did not make"), results_folder(tmp_path):
        pass


def test_a_place_that_cannot_be_written_is_a_storage_error(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(StorageError, match="Not a directory|File exists"), results_folder(tmp_path / "file" / "run"):
        pass


def test_leftovers_of_a_dead_process_go_and_those_of_a_live_one_stay(tmp_path):
    dead = subprocess.Popen(["true"])
    dead.wait()
    for pid in (dead.pid, os.getppid()):
        (tmp_path / f".run.partial-{pid}").mkdir()
    (tmp_path / f".run.partial-{dead.pid}" / ".gough").write_text('{"schema": "gough-results-1", "finished": false}')
    build(tmp_path / "run", log="1")
    assert sorted(os.listdir(tmp_path)) == [f".run.partial-{os.getppid()}", "run"]


@pytest.mark.parametrize(
    "left", [[], [".gough"], [".gough", "log"]], ids=["new", "its marker half written", "half removed"]
)
def test_what_a_kill_leaves_at_any_stage_is_known_as_goughs_and_removed(tmp_path, left):
    dead = subprocess.Popen(["true"])
    dead.wait()
    partial = tmp_path / f".run.partial-{dead.pid}"
    partial.mkdir()
    for name in left:
        (partial / name).write_text('{"schema": "gough-results-1"}' if len(left) > 1 else "")
    build(tmp_path / "run", log="1")
    assert os.listdir(tmp_path) == ["run"]


def test_a_marker_is_removed_last(tmp_path, monkeypatch):
    """Killed while it removes: what is left still carries the marker."""
    build(tmp_path / "run", a="1", b="1", z="1")
    (tmp_path / "run" / "sub").mkdir()

    def killed(folder):
        if folder.name == "run":
            assert [p.name for p in folder.iterdir()] == [".gough"]
            raise KeyboardInterrupt
        folder.rmdir()

    monkeypatch.setattr(results.shutil, "rmtree", killed)
    with pytest.raises(KeyboardInterrupt):
        results._remove(tmp_path / "run")


def test_a_folder_with_such_a_name_that_gough_did_not_make_stays(tmp_path):
    (tmp_path / ".run.partial-999999999").mkdir()
    (tmp_path / ".run.partial-999999999" / "precious").write_text("")
    build(tmp_path / "run", log="1")
    assert (tmp_path / ".run.partial-999999999" / "precious").exists()


def test_where_folders_cannot_be_exchanged_two_renames_do(tmp_path, monkeypatch):
    monkeypatch.setattr(results.ctypes, "CDLL", lambda *a, **k: object())
    build(tmp_path / "run", log="1")
    build(tmp_path / "run", log="2")
    assert content(tmp_path / "run") == {"log": "2"}
    assert os.listdir(tmp_path) == ["run"]


def test_an_old_folder_whose_successor_never_arrived_is_put_back(tmp_path):
    build(tmp_path / "run", log="1")
    dead = subprocess.Popen(["true"])
    dead.wait()
    os.rename(tmp_path / "run", tmp_path / f".run.old-{dead.pid}")  # killed between the two renames
    with pytest.raises(ZeroDivisionError), results_folder(tmp_path / "run"):
        raise ZeroDivisionError
    assert content(tmp_path / "run") == {"log": "1"}


WRITER = """
import sys
from gough.results import results_folder
print("go", flush=True)
for i in range(1000000):
    with results_folder(sys.argv[1]) as folder:
        for name in "abcd":
            (folder / name).write_text(str(i) * 2000)
"""


@pytest.mark.full
def test_a_process_killed_at_any_time_leaves_a_whole_folder(tmp_path):
    """F2: ten kills at times drawn over a few runs each; the four files are always of one run."""
    run = tmp_path / "run"
    for round_ in range(10):
        process = subprocess.Popen([sys.executable, "-c", WRITER, str(run)], stdout=subprocess.PIPE)
        process.stdout.readline()
        time.sleep(0.013 * (round_ + 1))
        process.send_signal(signal.SIGKILL)
        process.wait()
        process.stdout.close()
        if run.exists():
            assert made_by_gough(run)
            assert len(set(content(run).values())) == 1 and set(content(run)) == set("abcd")
    assert run.exists()
    build(run, log="after")
    assert os.listdir(tmp_path) == ["run"]
