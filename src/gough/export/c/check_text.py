"""The self-test of an export: a C program that holds what the functions give against values recorded in Python."""

from __future__ import annotations

import numpy as np

from ...kernel.pack import flatten
from ...machine.base import Machine
from ...machine.workspace import random_poses
from .functions import head
from .printer import number, wrapped
from .step_text import Stepped

POSES, TICKS, SEED = 16, 12, 1
_RELATIVE = 1e-12  # of the greatest entry: what the export promises against Python

_HEAD = """
static int failures = 0;

static void hold(const char *what, int row, int status, int wanted, const double *found, const double *expected, int n)
{
    double most = 0.0, error = 0.0;
    int k;
    for (k = 0; k < n; ++k) {
        if (fabs(expected[k]) > most)
            most = fabs(expected[k]);
        if (!(fabs(found[k] - expected[k]) <= error))
            error = fabs(found[k] - expected[k]);
    }
    if (status != wanted || !(error <= $RELATIVE * most + 1e-15)) {
        printf("%s, row %d: status %d, expected %d; off by %g of %g\\n", what, row, status, wanted, error, most);
        ++failures;
    }
}
"""


def machine_rows(m: Machine, count: int = POSES) -> dict[str, np.ndarray]:
    """Poses within the limits, and what Python gives at them: joints, Jacobian, a motion and its forces."""
    rng, d = np.random.default_rng(SEED), len(m.task)
    x = _poses(m, count, rng)
    xd, xdd = rng.normal(size=(2, len(x), d)) * 0.3
    w = rng.normal(size=(len(x), 6)) * 100
    return {
        "pose": x,
        "joints": m.inverse_kinematics(x),
        "jacobian": m.jacobian(x).reshape(len(x), -1),
        "rate": xd,
        "acceleration": xdd,
        "wrench": w,
        "force": m.inverse_dynamics(x, xd, xdd, w),
    }


def _poses(m, count, rng):
    if m.limits.workspace is not None:
        return random_poses(m, count, rng)
    # without a declared workspace: about home, by 1 mm and 1 mrad, and home itself where that is outside
    x = m.home + rng.uniform(-1e-3, 1e-3, (count, len(m.home)))
    inside = (m.arrays.run("margins", m.standing(x))[0] >= 0).all(-1)
    return np.where(inside[:, None], x, m.home)


def step_rows(one: Stepped, row: np.ndarray, joints: np.ndarray, applied: np.ndarray, ticks: int = TICKS):
    """Inputs and outputs of `ticks` steps from the start, about the start, by replay of the tapes: one lane's bits."""
    rng, state = np.random.default_rng(SEED), flatten(one.state)
    numbers = one.part.theta if one.argument else np.zeros(0)
    rows = []
    for k in range(ticks):
        given = {"joints": joints + rng.normal(size=joints.size) * 1e-5, "applied": applied * rng.uniform(0.9, 1.1)}
        if "reference" in one.inputs:
            given["reference"] = row + rng.normal(size=row.size) * 1e-4
        else:
            given["good"] = np.array([float(k % 5 != 3)])
        values = [given[n] for n in one.inputs]
        for _, tape, every in one.tasks:
            if k % every == 0:
                *out, state = tape.replay(numbers, state, *values)
        rows.append((values, np.concatenate(out), state))
    return rows


def check_text(name: str, machine: Machine, stepped: list[tuple[Stepped, list]], argument: bool = False) -> str:
    """<name>_test.c; with `argument` the functions take theta."""
    includes = "".join(f'#include "{n}.h"\n' for n in (name, *(one.name for one, _ in stepped)))
    rows = machine_rows(machine)
    parts = [head(f"{name}: self-test"), includes, "\n#include <math.h>\n#include <stdio.h>\n#include <string.h>\n"]
    parts.append(_HEAD.replace("$RELATIVE", f"{_RELATIVE:g}"))
    parts += [_table(key, value) for key, value in rows.items()]
    parts.append(_machine_check(name, rows, f"{name}_theta, " if argument else ""))
    for one, recorded in stepped:
        parts.append(_step_check(one, recorded))
    calls = "".join(f"    check_{n}();\n" for n in (name, *(one.name for one, _ in stepped)))
    parts.append(
        f"int main(void)\n{{\n{calls}    if (failures == 0)\n"
        f'        printf("{name}: all as recorded\\n");\n    return failures != 0;\n}}\n'
    )
    return "\n".join(part.strip("\n") + "\n" for part in parts)


def _table(name: str, values: np.ndarray) -> str:
    lines = ",\n".join("    {" + wrapped(", ".join(number(v) for v in row), 5) + "}" for row in values)
    return f"static const double {name}[{len(values)}][{values.shape[1]}] = {{\n{lines}}};\n"


def _machine_check(name: str, rows, theta: str) -> str:
    d, n = rows["pose"].shape[1], rows["joints"].shape[1]
    return f"""
static void check_{name}(void)
{{
    double q[{n}], x[{d}], J[{n * d}], u[{n}];
    int k, status;
    for (k = 0; k < {len(rows["pose"])}; ++k) {{
        status = {name}_inverse({theta}pose[k], q);
        hold("{name}_inverse", k, status, 0, q, joints[k], {n});
        memcpy(x, {name}_home, sizeof x);
        status = {name}_forward({theta}joints[k], x, NULL);
        hold("{name}_forward", k, status, 0, x, pose[k], {d});
        status = {name}_jacobian({theta}pose[k], J);
        hold("{name}_jacobian", k, status, 0, J, jacobian[k], {n * d});
        status = {name}_inverse_dynamics({theta}pose[k], rate[k], acceleration[k], wrench[k], u);
        hold("{name}_inverse_dynamics", k, status, 0, u, force[k], {n});
    }}
    memcpy(q, joints[0], sizeof q);
    memcpy(x, pose[0], sizeof x);
    q[0] = NAN;
    status = {name}_forward({theta}q, x, NULL);
    hold("{name}_forward of no number", 0, status, 1, x, pose[0], {d});
}}
"""


def _step_check(one: Stepped, recorded) -> str:
    N, n_out = one.name, sum(one.outputs.values())
    tables = "".join(
        _table(f"{N}_{key}", np.array([values[i] for values, _, _ in recorded])) for i, key in enumerate(one.inputs)
    )
    tables += _table(f"{N}_expected", np.array([out for _, out, _ in recorded]))
    theta = f"{N}_theta, " if one.argument else ""
    given = theta + ", ".join(f"(int){N}_good[k][0]" if n == "good" else f"{N}_{n}[k]" for n in one.inputs)
    return f"""{tables}
static void check_{N}(void)
{{
    static {N}_state state;
    double out[{n_out}];
    int k, status;
    {N}_start(&state);
    for (k = 0; k < {len(recorded)}; ++k) {{
        status = {N}_step(&state, {given}, out);
        hold("{N}_step", k, status, 0, out, {N}_expected[k], {n_out});
    }}
}}
"""
