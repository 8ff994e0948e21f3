"""Sweeps: the same bits whatever the workers, the batches and the times they were ended; no finished run is lost."""

from __future__ import annotations

import contextlib
import json
import os
import random
import resource
import shlex
import shutil
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
from sweep_files import FILE, runs_of

import gough as gk
from gough.errors import RunError
from gough.experiment import load_experiment
from gough.kernel.lanes import native_width
from gough.sweep import jobs, pool, summary, work
from gough.sweep.jobs import Job
from gough.sweep.run import sweep
from gough.sweep.settings import Setter
from gough.sweep.table import lines_of, write_index

VARY = '"plant.payload" = "uniform(1, 40) kg", "controller.bandwidth" = ["8 Hz", "10 Hz"]'


def command(*words, **options):
    return subprocess.Popen(
        [sys.executable, "-m", "gough", "sweep", *map(str, words)], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        text=True, **options,
    )  # fmt: skip


def ended(process, seconds=120):
    out, err = process.communicate(timeout=seconds)
    return process.returncode, out, err


def index(folder):
    return (folder / "index.parquet").read_bytes()


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    """A sweep of 24 runs that nobody disturbs: its file and its folder."""
    place = tmp_path_factory.mktemp("sweep")
    (place / "part.toml").write_text(FILE.format(vary=VARY, more="runs = 6"))
    swept = sweep(load_experiment(place / "part.toml"), place / "whole", workers=2)
    write_index(swept, lines_of(swept), place / "whole" / "index.parquet")
    assert swept.progress.failed == 0 and len(swept.records) == 24
    return place / "part.toml", place / "whole"


@pytest.fixture
def whole(undisturbed, tmp_path):
    """A copy of it."""
    path, folder = undisturbed
    shutil.copytree(folder, tmp_path / "whole")
    return path, tmp_path / "whole"


@pytest.mark.full
def test_bits_hang_neither_on_workers_nor_on_batches_nor_on_resuming(whole, tmp_path, monkeypatch):
    path, folder = whole
    base = load_experiment(path)
    monkeypatch.setattr(jobs, "SLAB", 3)
    monkeypatch.setattr(jobs, "MOST", 3)
    sweep(base, tmp_path / "one", workers=1, runs=2)
    assert len(runs_of(tmp_path / "one")) == 8
    for _ in range(2):
        swept = sweep(base, tmp_path / "one", workers=1)
    write_index(swept, lines_of(swept), tmp_path / "one" / "index.parquet")
    assert runs_of(tmp_path / "one") == runs_of(folder) and index(tmp_path / "one") == index(folder)
    assert swept.progress.found == 24


@pytest.mark.full
def test_a_run_of_a_sweep_is_the_run_that_its_experiment_describes(whole, tmp_path, gough):
    path, folder = whole
    swept = sweep(load_experiment(path), folder)
    lines = lines_of(swept)
    worst = int(np.argmax(lines.metric("contour_error.max")))
    printed = shlex.split(summary.worst_runs(swept, lines, folder)[0].command)
    assert printed[0] == "gough"
    done = gough(*printed[1:], "--json", "-o", tmp_path / "again")
    assert done.status == 0 and done.json["run"] == lines.ids[worst]
    # one run alone is rounded otherwise than in the lanes of a batch: 1 ulp in some thousand samples, through a loop
    assert done.json["controllers"][0]["contour_error"]["max"] == pytest.approx(
        lines.metric("contour_error.max")[worst], rel=1e-6
    )
    log = gk.Log.load(tmp_path / "again" / f"{done.json['controllers'][0]['kind']}.nc")
    settings = swept.records[lines.ids[worst]]["settings"]
    assert log.info["plant"]["payload"] == settings["plant.payload"] and "contour_error" in log
    assert log.info["run"]["seed"] == settings["run.seed"]


@pytest.mark.slow
def test_what_batches_cannot_share_runs_in_groups_of_its_own(experiment, tmp_path):
    """Programs, sample times and machines in one sweep: all run, and one of them gives the bits that it gives alone."""
    vary = (
        '"program.radius" = ["20 mm", "15 mm"], "run.period" = ["1 ms", "2 ms"], "machine.use" = ["nist-octahedral", '
        '"okuma-pm600"], "plant.joints.friction" = ["none"]'
    )
    base = experiment(vary, plant=('"friction.coulomb" = "0.9 x"', ""))
    swept = sweep(base, tmp_path / "s", workers=2)
    assert swept.progress.failed == 0 and len(swept.records) == 16, [r["reason"] for r in swept.records.values()]
    alone = work.work(work.task_of(Setter(base), native_width(), [swept.rows[3].job]))
    assert alone.records[0]["metrics"] == swept.records[swept.rows[3].job.id]["metrics"]


@pytest.mark.full
def test_a_run_that_fails_is_a_line_with_its_reason_and_disturbs_no_other(experiment, tmp_path):
    """Friction of which Coulomb's is above the static one cannot be; a circle of 0.4 m leaves the workspace."""
    vary = '"plant.friction.coulomb" = "normal(0.95, 0.3) x", "program.radius" = ["20 mm", "400 mm"]'
    swept = sweep(experiment(vary, "runs = 12"), tmp_path / "s", workers=1)
    lines = lines_of(swept)
    friction = swept.experiment.machine.friction
    too_much = lines.values[0] > friction.static / friction.coulomb
    assert too_much.any() and not too_much.all()
    wide = lines.point == 1
    assert (lines.status[too_much | wide] == "failed").all() and (lines.status[~too_much & ~wide] == "done").all()
    told = {reason for reason, bad in zip(lines.reason, too_much, strict=True) if bad}
    assert told and all("static coefficient must be at least the Coulomb coefficient" in reason for reason in told)
    assert (
        all(lines.reason[k] for k in np.flatnonzero(wide)) and np.isnan(lines.metric("contour_error.max")[wide]).all()
    )
    again = sweep(experiment(vary, "runs = 12"), tmp_path / "s", workers=1)
    assert again.progress.found == again.progress.total  # a reason is a result: it is not sought again


def test_a_bug_in_one_run_is_told_and_not_kept(experiment, monkeypatch):
    base = experiment(VARY)
    found = []

    def simulated(group, lanes):
        found.append(len(group))
        if any(job.id == "2" for job, _ in group):
            raise ZeroDivisionError("a bug")
        return [{"id": job.id} for job, _ in group]

    monkeypatch.setattr(work, "_simulated", simulated)
    done = work.work(
        work.task_of(Setter(base), 8, [Job(str(i), 0, {"plant.payload": f"{i + 1} kg"}) for i in range(5)])
    )
    assert {one["id"] for one in done.records} == {"0", "1", "3", "4"}
    assert done.broken == {"2": "ZeroDivisionError: a bug"} and sum(found) <= 5 + 5 + 3 + 2


@pytest.mark.full
def test_a_flipped_bit_in_a_run_is_found_and_the_run_done_again(whole):
    path, folder = whole
    good, kept = runs_of(folder), index(folder)
    victims = random.Random(0).sample(sorted((folder / "runs").glob("*/*.json")), 3)
    for victim in victims:
        data = bytearray(victim.read_bytes())
        data[len(data) // 2] ^= 4
        victim.write_bytes(data)
    swept = sweep(load_experiment(path), folder, workers=1)
    assert swept.progress.found == 21 and runs_of(folder) == good
    write_index(swept, lines_of(swept), folder / "index.parquet")
    assert index(folder) == kept


@pytest.mark.full
def test_the_index_is_made_again_of_the_files(whole, gough):
    path, folder = whole
    kept = index(folder)
    (folder / "index.parquet").unlink()
    assert gough("sweep", path, "-o", folder, "--quiet").status == 0
    assert index(folder) == kept


def killed(path, folder, at: int, delay: float):
    """Start a sweep, and kill it `delay` s after it has kept `at` runs: its parent alone; what it left."""
    process = command(path, "-o", folder, "-w", 2, "--quiet", start_new_session=True)
    while process.poll() is None and (at and len(list((folder / "runs").glob("*/*.json"))) < at):
        time.sleep(0.002)
    time.sleep(delay)
    process.send_signal(signal.SIGKILL)  # its workers have to see to themselves
    process.communicate()
    return process


def survivors(session: int) -> list[str]:
    """Processes of a session that still run."""
    found = []
    for pid in filter(str.isdecimal, os.listdir("/proc")):
        with contextlib.suppress(OSError), open(f"/proc/{pid}/stat") as file:
            fields = file.read().rpartition(")")[2].split()
            if int(fields[3]) == session and fields[0] != "Z":
                found.append(pid)
    return found


def disturbed(path, whole, tmp_path, sweeps: int, kills: int, seed: int) -> None:
    """SIGKILL at random moments, `kills` times a sweep, then to the end: nothing lost, nothing else than in `whole`."""
    good, rng = runs_of(whole), random.Random(seed)
    runs = len(good)
    for number in range(sweeps):
        folder, known = tmp_path / f"killed-{number}", {}
        for _ in range(kills):
            # anywhere: while it starts, or just before, while or after the runs of a batch are kept
            at = 0 if rng.random() < 0.1 else rng.randrange(len(known) + 1, runs) if len(known) < runs - 1 else 0
            process = killed(path, folder, at, rng.uniform(0, 3) if at == 0 else rng.uniform(0, 0.05))
            left = runs_of(folder) if (folder / "runs").exists() else {}
            assert known.items() <= left.items(), "a finished run was lost"
            assert left.items() <= good.items(), "a file is not whole"
            known = left
        status, _, err = ended(command(path, "-o", folder, "-w", 2, "--quiet"))
        assert status == 0, err
        assert runs_of(folder) == good and index(folder) == index(whole)
        assert {entry.name for entry in (folder / ".partial").iterdir()} == {"door"}
        until = time.monotonic() + 20
        while survivors(process.pid) and time.monotonic() < until:
            time.sleep(0.1)
        assert not survivors(process.pid), "workers outlive the sweep that started them"


@pytest.mark.full
def test_a_sweep_killed_at_a_random_moment_loses_nothing_and_ends_as_if_it_had_not_been(undisturbed, tmp_path):
    disturbed(*undisturbed, tmp_path, sweeps=1, kills=1, seed=1)


@pytest.mark.slow
def test_fifty_kills_of_a_sweep_of_two_hundred_runs_lose_nothing(written, tmp_path):
    path = written(VARY, "runs = 50")
    assert ended(command(path, "-o", tmp_path / "whole", "-w", 2, "--quiet"))[0] == 0
    assert len(runs_of(tmp_path / "whole")) == 200
    disturbed(path, tmp_path / "whole", tmp_path, sweeps=25, kills=2, seed=2)


@pytest.mark.slow
def test_two_sweeps_on_one_store_share_the_work_and_end_alike(whole, tmp_path):
    path, folder = whole
    both = [command(path, "-o", tmp_path / "both", "-w", 1, "--quiet") for _ in range(2)]
    assert [ended(one)[0] for one in both] == [0, 0]
    assert runs_of(tmp_path / "both") == runs_of(folder) and index(tmp_path / "both") == index(folder)


@pytest.mark.full
@pytest.mark.parametrize(
    "most", [5000, *(pytest.param(most, marks=pytest.mark.slow) for most in (0, 400, 15_000, 60_000))]
)
def test_a_disk_that_takes_no_more_ends_the_sweep_with_its_place_and_leaves_what_is_sound(whole, tmp_path, most):
    """RLIMIT_FSIZE cuts files at `most` bytes: marker, experiment, sheet, index, page in turn; runs: test_store.py."""
    path, folder = whole
    if most > 5000:  # the runs are there, so that what comes after them is quick to reach
        shutil.copytree(folder / "runs", tmp_path / "full" / "runs")
        shutil.copy(folder / ".gough", tmp_path / "full")

    def limit():
        resource.setrlimit(resource.RLIMIT_FSIZE, (most, most))
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)

    process = command(path, "-o", tmp_path / "full", "-w", 1, "--quiet", preexec_fn=limit)
    status, _, err = ended(process)
    assert status == 1 and "cannot be written, got " in err and "File too large" in err and "Traceback" not in err, err
    assert str(tmp_path / "full") in err and "free in" in err
    left = runs_of(tmp_path / "full") if (tmp_path / "full").exists() else {}
    assert left.items() <= runs_of(folder).items()
    if most > 5000:
        assert ended(command(path, "-o", tmp_path / "full", "-w", 1, "--quiet"))[0] == 0
        assert runs_of(tmp_path / "full") == runs_of(folder) and index(tmp_path / "full") == index(folder)
    assert not [p for p in (tmp_path / "full").rglob("*") if ".partial-" in p.name]


@pytest.mark.slow
def test_ctrl_c_ends_with_130_and_what_has_finished_stays(written, tmp_path):
    path = written(VARY, "runs = 100")
    process = command(path, "-o", tmp_path / "s", "-w", 2, "--json")
    until = time.monotonic() + 60
    while len(runs_of(tmp_path / "s")) < 16 and time.monotonic() < until:
        time.sleep(0.05)
    process.send_signal(signal.SIGINT)
    began = time.monotonic()
    status, out, err = ended(process)
    assert status == 130 and time.monotonic() - began < 5
    assert json.loads(out)["error"]["code"] == "Interrupted"
    assert f"interrupted; what has ended is kept in {tmp_path / 's'}: the same command goes on" in err
    assert "Traceback" not in err and len(runs_of(tmp_path / "s")) >= 16


@pytest.mark.full
def test_a_worker_that_is_lost_is_replaced_and_its_runs_are_done_again(whole, tmp_path):
    path, folder = whole
    killed_one = []

    def tell(progress):
        if not killed_one and progress.done:
            (victim, *_) = _children()
            os.kill(victim, signal.SIGKILL)
            killed_one.append(victim)

    swept = sweep(load_experiment(path), tmp_path / "lost", workers=2, tell=tell)
    assert killed_one and swept.progress.failed == 0
    assert runs_of(tmp_path / "lost") == runs_of(folder)


def _children() -> list[int]:
    """Worker processes of this one."""
    found = []
    for pid in filter(str.isdecimal, os.listdir("/proc")):
        with contextlib.suppress(OSError), open(f"/proc/{pid}/stat") as stat, open(f"/proc/{pid}/cmdline") as line:
            ours = int(stat.read().rpartition(")")[2].split()[1]) == os.getpid()
            if ours and "spawn_main" in line.read():
                found.append(int(pid))
    return found


@pytest.mark.full
def test_a_batch_that_ends_three_workers_is_told_and_does_not_go_on_for_ever(experiment):
    task = work.task_of(Setter(experiment(VARY)), 8, [Job("0" * 32, 0, {})])
    task = task._replace(setter=_Deadly())
    with pool.Pool(1) as one, pytest.raises(RunError, match="a batch of 1 runs has ended 3 workers, got exit status 9"):
        list(one.each([task], 1))


class _Deadly:
    """Ends the process that reads it."""

    def __reduce__(self):
        return os._exit, (9,)


def test_a_wrong_number_is_told_by_its_option(written, gough):
    path = written(VARY)
    for option in ("--runs", "--workers"):
        done = gough("sweep", path, option, "0")
        assert done.status == 2 and f"{option}: must be at least 1, got 0" in done.err


def test_an_experiment_without_a_sweep_says_what_to_write(written, gough):
    path = written(VARY)
    path.write_text(path.read_text().partition("[sweep]")[0])
    done = gough("sweep", path)
    assert done.status == 2 and "sweep: the table is missing; write [sweep] and vary = {" in done.err


def test_gough_check_reads_the_sweep_and_counts_its_runs(written, gough):
    done = gough("check", written(VARY, "runs = 6"), "--json")
    assert done.status == 0 and done.json["sweep"] == 24
    done = gough("check", written('"plant.payloud" = ["1 kg"]'))
    assert done.status == 2 and "did you mean plant.payload?" in done.err


def test_a_folder_that_is_no_sweep_cannot_go_on(tmp_path, gough):
    done = gough("sweep", tmp_path)
    assert done.status == 2 and "is no folder of a sweep" in done.err
