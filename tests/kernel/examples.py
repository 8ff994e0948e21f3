"""What the tests run: a driven pendulum, a random function."""

import casadi as ca
import numpy as np

from gough.kernel import Schedule, Signal, Task


def pendulum(limit=100.0, every=1, log=("x", "u", "r", "w"), substeps=4, control=None) -> Schedule:
    """x'' = u - sin(x), u by PD with noise every `every` ticks; stops where |angle| exceeds `limit`."""
    x, u, p, r, w = (ca.SX.sym(n, k) for n, k in (("x", 2), ("u", 1), ("p", 2), ("r", 1), ("w", 3)))
    h = 1e-3
    half = x + h / 2 * ca.vertcat(x[1], u - ca.sin(x[0]))
    signals = [
        Signal("x", 2, "state", ("angle", "speed")),
        Signal("u", 1, "wire"),
        Signal("p", 2, "parameter"),
        Signal("r", 1, "input"),
        Signal("w", 3, "noise"),
        Signal("limits", 1, "wire", ("angle within reach",)),
    ]
    law = control or ca.Function("law", [x, r, p, w], [p[0] * (r - x[0]) - p[1] * x[1] + 0.1 * w[2]])
    tasks = [Task("law", law, ("x", "r", "p", "w"), "u", every)]
    step = ca.Function("step", [x, u], [x + h * ca.vertcat(half[1], u - ca.sin(half[0]))])
    reach = ca.Function("reach", [x], [limit - ca.fabs(x[0])])
    return Schedule(
        signals, tasks, Task("step", step, ("x", "u"), "x"), substeps, Task("reach", reach, "x", "limits"), log, 4e-3
    )


def reference(n: int) -> dict:
    return {"r": np.sin(0.01 * np.arange(n))[:, None]}


def random_function(seed: int, inputs: int = 5, operations: int = 150) -> ca.Function:
    """Random smooth operations whose values stay near 1, so that rounding is not magnified."""
    rng = np.random.default_rng(seed)
    x = ca.SX.sym("x", inputs)
    values = [x[i] for i in range(inputs)]
    unary = [
        ca.sin,
        ca.cos,
        ca.tanh,
        ca.atan,
        lambda a: ca.sqrt(1 + a * a),
        lambda a: ca.exp(-a * a),
        lambda a: a / 3,
        lambda a: ca.log(1 + a * a),
        ca.asinh,
        lambda a: 1 / (1 + a * a),
        ca.erf,
        ca.fabs,
    ]
    binary = [
        lambda a, b: (a + b) / 2,
        lambda a, b: a - b / 2,
        lambda a, b: ca.sin(a) * ca.cos(b),
        lambda a, b: a / (2 + b * b),
        lambda a, b: ca.if_else(a < b, a, b * 0.5),
        ca.fmax,
        lambda a, b: ca.atan2(a, 1 + b * b),
        ca.hypot,
    ]
    for _ in range(operations):
        a, b = (values[i] for i in rng.integers(max(0, len(values) - 25), len(values), 2))
        values.append(
            unary[rng.integers(len(unary))](a) if rng.random() < 0.5 else binary[rng.integers(len(binary))](a, b)
        )
    return ca.Function(f"random{seed}", [x], [ca.vertcat(*values[-6:])])
