"""The cache: code is loaded only when every bit of it is what was written, by us, for exactly this."""

import json
import os
import subprocess
import sys
import warnings

import casadi as ca
import numpy as np
import pytest

from gough.kernel import Schedule, Signal, Task, cache, compile, compile_rows

from .examples import pendulum, reference

KEY = "ab" * 32


def tiny(factor=2.0):
    x = ca.SX.sym("x")
    step = ca.Function("step", [x], [x * factor])
    return Schedule([Signal("x", 1, "state")], Task("step", step, "x", "x"))


def result(kernel):
    simulation = kernel.start(states={"x": [1.0]})
    simulation.advance(3)
    return simulation.state("x")[0, 0]


def test_the_second_compilation_comes_from_the_cache_and_computes_the_same():
    first, second = compile(pendulum()), compile(pendulum())
    assert not first.cached and second.cached
    values = {"p": [10.0, 1.0]}, {"x": [0.1, 0.0]}
    assert np.array_equal(*(k.start(*values).advance(100, reference(100)) for k in (first, second)))


def test_rows_are_cached_too():
    x = ca.SX.sym("x", 3)
    function = ca.Function("f", [x], [ca.sin(x)])
    assert [compile_rows(function)._engine.cached for _ in range(2)] == [False, True]


def test_cached_code_is_found_by_content_not_by_name():
    compile(tiny(2.0))
    assert compile(tiny(2.0)).cached and not compile(tiny(3.0)).cached
    assert not compile(tiny(2.0), lanes=8).cached


def test_without_the_cache_nothing_is_written(cache_folder):
    assert not compile(tiny(), cache=False).cached
    assert not cache_folder.exists()


def test_a_flipped_bit_anywhere_is_noticed():
    data = cache.encode(b"machine code " * 9, KEY, {"symbols": {"a": "sin"}})
    assert cache.decode(data, KEY) == (b"machine code " * 9, {"symbols": {"a": "sin"}})
    for place in range(len(data)):
        for bit in range(8):
            damaged = bytearray(data)
            damaged[place] ^= 1 << bit
            assert cache.decode(bytes(damaged), KEY) is None
    for end in range(len(data)):
        assert cache.decode(data[:end], KEY) is None
    assert cache.decode(data + b"\0", KEY) is None


def test_code_of_another_key_is_not_loaded(cache_folder):
    compile(tiny(2.0)), compile(tiny(3.0))
    one, other = sorted(cache_folder.glob("*.bin"))
    one.write_bytes(other.read_bytes())
    assert {result(compile(tiny(2.0))), result(compile(tiny(3.0)))} == {8.0, 27.0}


@pytest.mark.parametrize(
    "damage",
    [lambda d: d[:-7], lambda d: b"", lambda d: d[:100], lambda d: d[:-200] + bytes(200), lambda d: b"\x7fELF" + d[4:]],
)
def test_a_damaged_file_is_compiled_anew_and_replaced(cache_folder, damage):
    compile(tiny())
    (file,) = cache_folder.glob("*.bin")
    whole = file.read_bytes()
    file.write_bytes(damage(whole))
    again = compile(tiny())
    assert not again.cached and result(again) == 8.0
    assert cache.decode(file.read_bytes(), file.stem) is not None and compile(tiny()).cached


def test_a_truncated_object_with_a_right_checksum_raises_and_is_compiled_anew(cache_folder):
    """Nobody but us could write it; still, it must not crash."""
    compile(tiny())
    (file,) = cache_folder.glob("*.bin")
    image, notes = cache.decode(file.read_bytes(), file.stem)
    for end in (0, 10, 64, len(image) // 2, len(image) - 100):
        cache.store(file.stem, image[:end], notes)
        again = compile(tiny())
        assert not again.cached and result(again) == 8.0


def test_code_that_needs_a_function_this_machine_lacks_is_compiled_anew(cache_folder):
    schedule = pendulum()
    compile(schedule)
    (file,) = cache_folder.glob("*.bin")
    image, notes = cache.decode(file.read_bytes(), file.stem)
    cache.store(file.stem, image, {"symbols": dict.fromkeys(notes["symbols"], "no_such_function")})
    assert not compile(schedule).cached


def test_the_folder_is_ours_alone(cache_folder):
    compile(tiny())
    assert cache_folder.stat().st_mode & 0o777 == 0o700
    assert all(file.stat().st_mode & 0o077 == 0 for file in cache_folder.iterdir())


def test_a_readable_folder_is_closed(cache_folder):
    cache_folder.mkdir(mode=0o755, parents=True)
    compile(tiny())
    assert cache_folder.stat().st_mode & 0o777 == 0o700 and compile(tiny()).cached


def test_a_folder_that_others_may_write_is_not_used(cache_folder):
    compile(tiny())
    cache_folder.chmod(0o777)
    again = compile(tiny())
    assert not again.cached and result(again) == 8.0 and cache_folder.stat().st_mode & 0o777 == 0o777


def test_a_file_that_others_may_write_is_not_loaded(cache_folder):
    compile(tiny())
    (file,) = cache_folder.glob("*.bin")
    file.chmod(0o666)
    assert not compile(tiny()).cached


def test_folder_and_file_of_another_user_are_not_used(cache_folder, monkeypatch):
    compile(tiny())
    mine = os.geteuid()
    monkeypatch.setattr(os, "geteuid", lambda: mine + 1)
    again = compile(tiny())
    assert not again.cached and result(again) == 8.0


def test_a_link_is_not_followed(cache_folder, tmp_path):
    compile(tiny())
    (file,) = cache_folder.glob("*.bin")
    elsewhere = tmp_path / "elsewhere.bin"
    file.rename(elsewhere)
    file.symlink_to(elsewhere)
    assert not compile(tiny()).cached and not file.is_symlink()


def test_what_was_used_longest_ago_goes_first(cache_folder, monkeypatch):
    names = ["aa" * 32, "bb" * 32, "cc" * 32]
    for age, name in enumerate(names):
        assert cache.store(name, bytes(1000), {})
        os.utime(cache_folder / f"{name}.bin", (1e9 + age, 1e9 + age))
    assert cache.load(names[0]) is not None  # used just now
    monkeypatch.setattr(cache, "LIMIT", 3000)
    cache.store("dd" * 32, bytes(1000), {})
    left = {file.stem[:2] for file in cache_folder.iterdir()}
    assert left == {"aa", "dd"}


def test_the_folder_follows_the_environment(monkeypatch, tmp_path):
    assert str(cache.folder()) == os.path.join(os.environ["GOUGH_CACHE"], "kernel")
    monkeypatch.delenv("GOUGH_CACHE")
    monkeypatch.setenv("XDG_CACHE_HOME", "/x/cache")
    assert str(cache.folder()) == "/x/cache/gough/kernel"
    monkeypatch.delenv("XDG_CACHE_HOME")
    monkeypatch.setenv("HOME", "/home/somebody")
    assert str(cache.folder()) == "/home/somebody/.cache/gough/kernel"
    monkeypatch.delenv("HOME")
    assert cache.folder() is None
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert result(compile(tiny())) == 8.0  # uncached, silently


def test_a_cache_that_cannot_be_written_changes_nothing(monkeypatch):
    monkeypatch.setenv("GOUGH_CACHE", "/dev/null/cache")
    assert result(compile(tiny())) == 8.0


SCRIPT = """
import sys, json, casadi as ca
from gough.kernel import Schedule, Signal, Task, compile
x = ca.SX.sym("x")
results = []
for factor in range(2, 14):
    step = Task("step", ca.Function("step", [x], [x * factor + ca.sin(x) * 0]), "x", "x")
    simulation = compile(Schedule([Signal("x", 1, "state")], step)).start(states={"x": [1.0]})
    simulation.advance(3)
    results.append(simulation.state("x")[0, 0])
print(json.dumps(results))
"""


@pytest.mark.full
def test_two_processes_may_race():
    processes = [
        subprocess.Popen([sys.executable, "-c", SCRIPT], stdout=subprocess.PIPE, env=os.environ) for _ in range(2)
    ]
    for process in processes:
        output, _ = process.communicate(timeout=60)
        assert json.loads(output) == [float(f) ** 3 for f in range(2, 14)]
    assert not [file for file in cache.folder().iterdir() if file.suffix != ".bin"]


def test_cached_code_is_found_without_printing_any():
    """Finding code must cost less than making it."""
    from gough.kernel import llvm

    compile(pendulum())
    original, printed = llvm.function, []
    llvm.function = lambda *a: printed.append(a) or original(*a)
    try:
        assert compile(pendulum()).cached and not printed
    finally:
        llvm.function = original


def test_what_else_lies_in_the_folder_is_not_touched(cache_folder, monkeypatch):
    """GOUGH_CACHE may name a folder a person keeps things in."""
    import gough.kernel.cache as module

    cache_folder.mkdir(parents=True)
    beside, inside = cache_folder.parent / "thesis.tex", cache_folder / "notes.txt"
    for path in (beside, inside):
        path.write_text("x" * 1000)
        os.utime(path, (1, 1))
    cache_folder.parent.chmod(0o755)
    monkeypatch.setattr(module, "LIMIT", 1)
    compile(tiny())
    assert beside.exists() and inside.exists()
    assert cache_folder.parent.stat().st_mode & 0o777 == 0o755


def varied(substeps=1, log=("x",), every=1, limited=False):
    x, y = ca.SX.sym("x"), ca.SX.sym("y")
    step = ca.Function("step", [x], [x + 1])
    signals = [Signal("x", 1, "state"), Signal("y", 1, "state"), Signal("limits", 1, "wire")]
    tasks = [Task("copy", ca.Function("copy", [x, y], [x + y]), ("x", "y"), ("y",), every)]
    limits = Task("limits", ca.Function("far", [x], [10 - x]), ("x",), ("limits",)) if limited else None
    return Schedule(signals, tasks, Task("step", step, ("x",), ("x",)), substeps, limits, log)


@pytest.mark.parametrize(
    "change", [{"substeps": 2}, {"log": ("y",)}, {"log": ("y", "x")}, {"every": 2}, {"limited": True}]
)
def test_all_that_changes_the_code_is_in_the_key(change):
    """Compiled one after the other, each its own: nothing of the first answers for the second."""
    assert not compile(varied()).cached and compile(varied()).cached
    assert not compile(varied(**change)).cached
