"""What exported C promises a controller: no memory of its own, loops with an end, little stack, nothing but libm."""

from __future__ import annotations

import re
import shutil
import subprocess

import pytest

import gough as gk
from gough.export import export_folder

pytestmark = [
    pytest.mark.full,
    pytest.mark.skipif(shutil.which("gcc") is None or shutil.which("nm") is None, reason="gcc is not installed"),
]
LIBM = {"acos", "asin", "atan", "atan2", "cos", "cosh", "exp", "fabs", "fmax", "fmin", "fmod", "log", "pow", "sin",
        "sincos", "sinh", "sqrt", "tan", "tanh"}  # fmt: skip
STACK = 16 * 1024  # bytes, RELIABILITY.md R4
# up to a bound that stands before it begins, or down to zero
LOOP = re.compile(r"for \((\*?\w+) = [^;]+; (?:\1 <=? (\w+); \+\+\1|\1 >= (0); --\1)\)")
EXPERIMENT = """schema = "gough-experiment-1"
[machine]
use = "{machine}"
[program]
kind = "circle"
radius = "3 mm"
feed = "0.2 m/min"
[[controller]]
kind = "{law}"
[observer]
kind = "disturbance"
bandwidth = "20 Hz"
"""


@pytest.mark.parametrize(
    "machine, law",
    [("nist-octahedral", 'robust_adaptive"\nslope = "60 1/s"\ndamping = "120 1/s'),
     ("ccu-3prs", 'pid"\nbandwidth = "8 Hz')],
    ids=["nist-octahedral", "ccu-3prs"],
)  # fmt: skip
def test_exported_code_needs_libm_alone_has_loops_with_an_end_and_little_stack(machine, law, tmp_path):
    (tmp_path / "job.toml").write_text(EXPERIMENT.format(machine=machine, law=law))
    files = export_folder(gk.load_experiment(tmp_path / "job.toml"), "c", tmp_path / "out")
    sources = [name for name in files if name.endswith(".c") and not name.endswith("_test.c")]
    assert len(sources) == 3, "machine, law and observer"
    for name in sources:
        command = ["gcc", "-std=c99", "-O2", "-fstack-usage", "-c", name, "-o", "one.o"]
        subprocess.run(command, cwd=tmp_path / "out", check=True, capture_output=True)
        wanted = subprocess.run(["nm", "-u", "one.o"], cwd=tmp_path / "out", capture_output=True, text=True).stdout
        own = {symbol for symbol in wanted.split()[1::2] if not symbol.startswith(machine.replace("-", "_"))}
        assert own <= LIBM | {"memcpy", "memset"}, own - LIBM
        rows = [line.split("\t") for line in next((tmp_path / "out").glob("*.su")).read_text().splitlines()]
        assert rows and all(kind in ("static", "dynamic,bounded") and int(size) < STACK for _, size, kind in rows)
        code = re.sub(r"/\*.*?\*/|//[^\n]*|\"[^\"\n]*\"", "", files[name], flags=re.S)
        assert not re.search(r"\b(while|do|goto|setjmp|longjmp)\b", code)
        heads = re.findall(r"\bfor\b[^{;]*;[^;]*;[^)]*\)", code)
        assert all(LOOP.fullmatch(" ".join(head.split())) for head in heads), heads
        ends = {LOOP.fullmatch(" ".join(head.split()))[2] for head in heads} - {
            None,
            "count",
        }  # count: of its arguments
        text = "".join(files.values())
        assert all(end.isdigit() or re.search(rf"\b{end}\b\s*=?\s*\d+", text) for end in ends), ends
