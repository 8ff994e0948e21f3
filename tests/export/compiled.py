"""Exports compiled and called from Python, rows at a time."""

from __future__ import annotations

import ctypes
import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from gough.export.c.machine_text import limit_names, machine_text

GENHEX = Path(__file__).with_name("genhex.toml")  # LinuxCNC's default hexapod
STRICT = ["-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wshadow", "-Wstrict-prototypes", "-Werror"]
COMPILERS = [
    pytest.param(one, marks=pytest.mark.skipif(shutil.which(one) is None, reason=f"{one} is not installed"))
    for one in ("gcc", "clang")
]
needs_gcc = pytest.mark.skipif(shutil.which("gcc") is None, reason="gcc is not installed")

_LOOPS = """
void {name}_rows(long n, const double *joints, double *poses, int *status, {name}_report *reports)
{{
    long k;
    for (k = 0; k < n; ++k)
        status[k] = {name}_forward(joints + {j} * k, poses + {d} * k, reports + k);
}}
void {name}_inverse_rows(long n, int *status, double *out, const double *x)
{{
    long k;
    for (k = 0; k < n; ++k)
        status[k] = {name}_inverse(x + {d} * k, out + {j} * k);
}}
void {name}_jacobian_rows(long n, int *status, double *out, const double *x)
{{
    long k;
    for (k = 0; k < n; ++k)
        status[k] = {name}_jacobian(x + {d} * k, out + {jd} * k);
}}
void {name}_limits_rows(long n, int *status, double *out, const double *x)
{{
    long k;
    for (k = 0; k < n; ++k)
        status[k] = {name}_limits(x + {d} * k, out + {l} * k);
}}
void {name}_inverse_dynamics_rows(long n, int *status, double *out, const double *x, const double *xd,
    const double *xdd, const double *w)
{{
    long k;
    for (k = 0; k < n; ++k)
        status[k] = {name}_inverse_dynamics(x + {d} * k, xd + {d} * k, xdd + {d} * k, w + 6 * k, out + {j} * k);
}}
"""
UNTOUCHED = -7.0  # what an output holds before a call


def build(folder: Path, files: dict[str, str], compiler: str = "gcc", options=("-O1",)) -> ctypes.CDLL:
    """A library of the C files among `files`, compiled without a warning."""
    for name, text in files.items():
        (folder / name).write_text(text)
    sources = [name for name in files if name.endswith(".c") and not name.endswith("_test.c")]
    library = folder / "export.so"
    command = [compiler, "-shared", "-fPIC", "-ffp-contract=off", *STRICT, *options, *sources, "-o", library, "-lm"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=300, check=False)
    assert done.returncode == 0, done.stderr[:2000]
    return ctypes.CDLL(str(library))


def pointer(array: np.ndarray):
    """A row of doubles, or of ints, for C."""
    assert array.flags.c_contiguous
    return array.ctypes.data_as(ctypes.POINTER(ctypes.c_int if array.dtype == np.int32 else ctypes.c_double))


class Report(ctypes.Structure):
    """<name>_report of an export."""

    _fields_ = (
        *((name, ctypes.c_double) for name in ("residual", "determinant", "margin")),
        ("limit", ctypes.c_int),
        ("evaluations", ctypes.c_int),
    )


class InC:
    """A machine in C; its functions take rows."""

    def __init__(self, folder: Path, machine, name: str = "m", **build_options):
        self.machine, self.name = machine, name
        c, h = machine_text(name, machine)
        self.sizes = {"d": len(machine.task), "j": machine.joints_count, "l": len(limit_names(machine))}
        loops = _LOOPS.format(name=name, jd=self.sizes["d"] * self.sizes["j"], **self.sizes)
        headers = "".join(line + ";\n" for line in _prototypes(loops))
        self.library = build(folder, {f"{name}.c": c + headers + loops, f"{name}.h": h}, **build_options)

    def call(self, function: str, *inputs: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Status (N,) and output (N, k) of <name>_<function> on rows; UNTOUCHED where nothing was written."""
        d, j = self.sizes["d"], self.sizes["j"]
        size = {"inverse": j, "jacobian": j * d, "limits": self.sizes["l"], "inverse_dynamics": j}[function]
        n = len(inputs[0])
        status, out = np.zeros(n, np.int32), np.full((n, size), UNTOUCHED)
        given = [pointer(np.ascontiguousarray(one, float)) for one in inputs]
        getattr(self.library, f"{self.name}_{function}_rows")(ctypes.c_long(n), pointer(status), pointer(out), *given)
        return status, out

    def forward(self, joints: np.ndarray, near: np.ndarray):
        """Status (N,), poses (N, d) and reports (N,) of the forward kinematics, each from its own last good pose."""
        n = len(joints)
        poses = np.ascontiguousarray(np.broadcast_to(near, (n, len(self.machine.task)))).copy()
        status, reports = np.zeros(n, np.int32), (Report * n)()
        rows = getattr(self.library, f"{self.name}_rows")
        rows(ctypes.c_long(n), pointer(np.ascontiguousarray(joints)), pointer(poses), pointer(status), reports)
        return status, poses, np.frombuffer(reports, _REPORT)


_REPORT = np.dtype(
    [("residual", "f8"), ("determinant", "f8"), ("margin", "f8"), ("limit", "i4"), ("evaluations", "i4")]
)


def _prototypes(text: str) -> list[str]:
    return [head.strip() for head in re.findall(r"^void[^{]*", text, re.M)]
