"""The store: files that are whole or not there, damage that is found, disks that are full, others at work beside."""

from __future__ import annotations

import errno
import fcntl
import json
import os
import threading
from pathlib import Path

import pytest

from gough.errors import ExperimentError, LogError, StorageError
from gough.sweep import store as module
from gough.sweep.store import MARKER, Store, sealed, unsealed


def record(number: int, **more):
    return {"id": f"{number:032x}", "controller": 0, "settings": {}, "status": "done", "metrics": {"x": 0.1}, **more}


def test_what_is_put_is_got(tmp_path):
    with Store(tmp_path / "s") as store:
        store.put([record(1), record(2)])
        assert store.get(record(1)["id"])["metrics"] == {"x": 0.1} and store.get(record(3)["id"]) is None
    assert {path.name for path in (tmp_path / "s" / ".partial").iterdir()} == {"door"}


def test_every_flipped_bit_of_a_run_is_found():
    data, id = sealed(record(7)), record(7)["id"]
    assert unsealed(data, id)["id"] == id and unsealed(data, record(8)["id"]) is None
    for place in range(len(data)):
        for bit in range(8):
            broken = data[:place] + bytes([data[place] ^ 1 << bit]) + data[place + 1 :]
            assert unsealed(broken, id) is None, (place, bit)


def test_a_run_that_is_cut_short_anywhere_is_none():
    data = sealed(record(7))
    assert not [n for n in range(len(data)) if unsealed(data[:n], record(7)["id"]) is not None]


def test_a_file_of_a_run_is_json_for_everybody(tmp_path):
    assert json.loads(sealed(record(7)))["schema"] == "gough-sweep-run-2"


@pytest.mark.parametrize("what", ["write_bytes", "sync", "replace"])
def test_a_disk_that_is_full_at_any_write_costs_nothing_that_was_there(tmp_path, monkeypatch, what):
    """The n-th call of each kind fails; then all that was kept is sound, and nothing is left on its way."""
    for n in range(3 if what != "sync" else 5):
        folder, calls = tmp_path / f"{what}-{n}", []
        with Store(folder) as store:
            store.put([record(1)])

            def full(old, n=n, calls=calls):
                def call(*arguments, **options):
                    calls.append(1)
                    if len(calls) > n:
                        raise OSError(errno.ENOSPC, "No space left on device")
                    return old(*arguments, **options)

                return call

            with monkeypatch.context() as patched:
                if what == "write_bytes":
                    patched.setattr(Path, "write_bytes", full(Path.write_bytes))
                elif what == "sync":
                    patched.setattr(module, "sync", full(module.sync))
                else:
                    patched.setattr(os, "replace", full(os.replace))
                with pytest.raises(StorageError, match="cannot be written, got No space left on device") as caught:
                    store.put([record(number) for number in (1, 2, 0x200 << 112, 3)])
            assert str(folder) in str(caught.value) and "free in" in str(caught.value)
            found = [json.loads(path.read_bytes())["id"] for path in (folder / "runs").glob("*/*")]
            assert record(1)["id"] in found and all(store.get(id) is not None for id in found)
            assert [path.name for path in store._own.iterdir()] == ["lock"]


def test_what_a_killed_writer_left_is_removed_and_a_living_one_keeps_its_own(tmp_path):
    with Store(tmp_path) as living:
        dead = tmp_path / ".partial" / "dead"
        dead.mkdir()
        (dead / "lock").touch()
        (dead / "half.json").write_text('{"id')
        with Store(tmp_path) as second:
            assert not dead.exists() and living._own.exists() and second.shared and not living.shared
        living.put([record(1)])


def test_eight_writers_of_one_store_lose_and_tear_nothing(tmp_path):
    errors = []

    def write(start: int):
        try:
            with Store(tmp_path) as store:
                for at in range(start, start + 40, 5):
                    store.put([record(number % 60) for number in range(at, at + 5)])
        except Exception as error:
            errors.append(error)

    threads = [threading.Thread(target=write, args=(8 * i,)) for i in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not errors
    store = Store(tmp_path)
    assert [store.get(record(number)["id"]) is not None for number in range(60)] == [True] * 60


def test_a_folder_with_other_files_is_refused(tmp_path):
    (tmp_path / "mine.txt").write_text("mine")
    with pytest.raises(ExperimentError, match="the folder holds files that are no sweep's"), Store(tmp_path):
        pass
    with pytest.raises(ExperimentError, match="must be a folder"), Store(tmp_path / "mine.txt"):
        pass
    assert [path.name for path in tmp_path.iterdir()] == ["mine.txt"]


def test_a_store_of_another_version_is_refused_by_name(tmp_path):
    (tmp_path / MARKER).write_text('{"schema": "gough-sweep-9"}')
    with pytest.raises(StorageError, match="a store of another version of gough, got gough-sweep-9"), Store(tmp_path):
        pass


def test_a_run_is_found_by_the_first_digits_of_its_id(tmp_path):
    ids = ["ab" + "0" * 30, "ab" + "1" * 30, "cd" + "0" * 30]
    with Store(tmp_path) as store:
        store.put([record(0, id=id) for id in ids])
        assert store.find("c")["id"] == ids[2] and store.find("AB1")["id"] == ids[1]
        for start, rule in (("ab", "several runs"), ("ff", "no run of the sweep"), ("../..", "no run of the sweep")):
            with pytest.raises(LogError, match=rule):
                store.find(start)
        store.place(ids[2]).write_bytes(sealed(record(0, id=ids[2])).replace(b"0.1", b"0.2"))
        with pytest.raises(LogError, match="the file of the run is damaged"):
            store.find("cd")


def test_the_lock_of_a_writer_ends_with_it(tmp_path):
    with Store(tmp_path) as store:
        path = store._own / "lock"
        with open(path, "ab") as lock, pytest.raises(OSError):
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    assert not path.exists()
