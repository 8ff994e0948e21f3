"""Laws and observers in C: a state of the caller's, `start`, and `step`, with tasks at several rates inside."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from ...control.base import Controller
from ...errors import ExperimentError
from ...kernel.pack import fields, flatten
from ...kernel.tape import trace
from ...observe.base import Observer
from ...observe.tasks import fields_of, function_of
from ...simulate import law_tasks
from . import printer
from .fold import baked
from .functions import CONTRACT, guarded, head
from .machine_text import FINITE, INCLUDES
from .names import distinct
from .printer import number
from .theta_text import check_way, declaration, table


class Stepped(NamedTuple):
    """What there is to print of a law or an observer."""

    name: str  # of its functions, a C identifier
    what: str  # in words
    period: float  # s, of the step
    state: Any  # at the start, a NamedTuple of NumPy
    inputs: dict[str, int]  # of the step, and their sizes
    outputs: dict[str, int]
    layout: list[tuple[str, dict[str, slice], str]]  # what entries of arrays are: title, where each lies, meaning
    tasks: list[tuple[str, Any, int]]  # name, tape of (state, *inputs) -> (*outputs, state), every so many steps
    steady: bool  # a sample that is no number is answered too: `good` is 0
    part: Any  # the law or the observer
    argument: bool  # whether its numbers are an argument


def law_stepped(name: str, law: Controller, reference: Any, u0, theta: str = "constant") -> Stepped:
    """A law, bound by `on`, that starts at rest at the Reference row `reference` under joint forces u0 (n,) N.

    Raises
    ------
    ExperimentError
        the law's step is plain Python.
    """
    if not law.symbolic:
        raise ExperimentError(
            "a law whose step is plain Python cannot be exported", key="controller", value=type(law).__name__,
            cure="write it in CasADi's operations (symbolic = True)",
        )  # fmt: skip
    state, n = law.init(reference, u0), law.machine.joints_count
    every = law_tasks.rates(law, law.period)
    found = law_tasks.tasks(law, state, reference, n, every)
    tasks = [(task.name, _traced(task.function, law, check_way(theta)), task.every) for task in found]
    size = len(flatten(reference))
    layout = [("reference", fields(reference), "what tool and joints should do now"), ("state", fields(state), "")]
    inputs = {"reference": size, "joints": n, "applied": n}
    return Stepped(
        name, f"{law.kind} on {law.machine.name}", law.period, state, inputs, {"command": n}, layout, tasks, False, law,
        check_way(theta),
    )  # fmt: skip


def observer_stepped(name: str, observer: Observer, x0, theta: str = "constant") -> Stepped:
    """An observer, bound by `on`, of a machine that stands at the pose x0 (d,)."""
    state, n = observer.init(x0), observer.machine.joints_count
    where = fields_of(observer)
    size = max(part.stop for part in where.values())
    tape = _traced(function_of(observer), observer, check_way(theta))
    layout = [("found", where, "what is found"), ("state", fields(state), "")]
    return Stepped(
        name, f"{observer.kind} on {observer.machine.name}", observer.period, state,
        {"joints": n, "applied": n, "good": 1}, {"found": size}, layout, [("observe", tape, 1)], True,
        observer, check_way(theta),
    )  # fmt: skip


def _traced(function, part, argument):
    return trace(function) if argument else baked(trace(function), {0: part.theta})


def step_text(one: Stepped) -> tuple[str, str]:
    """C and header text of a law or an observer."""
    N, U = one.name, one.name.upper()
    size = max(1, len(flatten(one.state)))
    work = max(printer.spilled(tape) for _, tape, _ in one.tasks)
    cycle = math.lcm(*(every for _, _, every in one.tasks))
    printed, calls = [], []
    labels = distinct(task for task, _, _ in one.tasks)
    for k, (label, (_, tape, every)) in enumerate(zip(labels, one.tasks, strict=True)):
        last = k == len(one.tasks) - 1
        outputs = [*one.outputs, "after"] if last else ["after"]
        printed.append(
            printer.function(tape, f"{N}_{label}_of", ["theta", "state", *one.inputs], outputs, work=work > 0)
        )
        given = [
            "theta" if one.argument else "",
            "s->next" if tape.inputs[1] else "",
            *("good_" if n == "good" else n for n in one.inputs),
        ]
        given += [*(f"out_{n}" for n in one.outputs), "s->next"] if last else ["s->next"]
        if not tape.outputs[-1]:
            given.pop()
        given += ["s->work"] if work else []
        call = f"{N}_{label}_of({', '.join(word for word in given if word)});"
        calls.append(call if every == 1 else f"if (s->tick % {every} == 0) /* every {every} steps */\n        {call}")
    values = ", ".join(number(v) for v in flatten(one.state)) or "0.0"
    first = printer.wrapped(values, 4)
    arguments = _arguments(one)
    locals_ = "".join(f"    double out_{n}[{size_}];\n" for n, size_ in one.outputs.items())
    written = "".join(f"    memcpy({n}, out_{n}, sizeof out_{n});\n" for n in one.outputs)
    checked = "".join(
        f"    if (!{N}_finite(out_{n}, {k}))\n        return {U}_NO_NUMBER;\n" for n, k in one.outputs.items()
    )
    body = f"""
static const double {N}_first[{size}] = {{
    {first}}};

void {N}_start({N}_state *s)
{{
    memset(s, 0, sizeof *s);
    memcpy(s->now, {N}_first, sizeof {N}_first);
}}

int {N}_step({N}_state *s, {arguments})
{{
{locals_}{_guard(one)}    memcpy(s->next, s->now, sizeof s->now);
    {chr(10).join("    " + call for call in calls).strip()}
{checked}    if (!{N}_finite(s->next, {size}))
        return {U}_NO_NUMBER;
    memcpy(s->now, s->next, sizeof s->now);
    s->tick = (s->tick + 1) % {cycle};
{written}    return {"status" if one.steady else U + "_OK"};
}}
"""
    c = (
        head(one.what)
        + f'#include "{N}.h"\n\n{INCLUDES}\n{CONTRACT}\n'
        + (table(N, one.part) if one.argument else "")
        + FINITE.replace("$N", N).strip("\n")
    )
    c += "\n\n" + "\n".join(printed) + body
    return c, head(one.what) + guarded(N, _header(one, size, work, arguments))


def _arguments(one: Stepped) -> str:
    given = [f"const double theta[{len(one.part.theta)}]"] if one.argument else []
    given += ["int good" if n == "good" else f"const double {n}[{k}]" for n, k in one.inputs.items()]
    return ", ".join(given + [f"double {n}[{k}]" for n, k in one.outputs.items()])


def _guard(one: Stepped) -> str:
    """The check of what comes in."""
    N, U = one.name, one.name.upper()
    arrays = {n: k for n, k in one.inputs.items() if n != "good"}
    test = " || ".join(f"!{N}_finite({n}, {k})" for n, k in arrays.items())
    if not one.steady:
        return f"    if ({test})\n        return {U}_NOT_FINITE;\n"
    zeros = max(arrays.values())
    return (
        f"    static const double none[{zeros}] = {{0.0}};\n    double good_[1];\n    int status = {U}_OK;\n"
        f"    if ({test}) {{ /* a sample that is not there */\n"
        + "".join(f"        {n} = none;\n" for n in arrays)
        + f"        good = 0;\n        status = {U}_NOT_FINITE;\n    }}\n    good_[0] = good ? 1.0 : 0.0;\n"
    )


def _header(one: Stepped, size: int, work: int, arguments: str) -> str:
    N, U = one.name, one.name.upper()
    meaning = "the sample counted as missing, the step was taken" if one.steady else "nothing was done"
    lines = [
        f"enum {N}_status {{\n    {U}_OK = 0,\n"
        f"    {U}_NOT_FINITE = 1, /* an argument has NaN or infinity: {meaning} */\n"
        f"    {U}_NO_NUMBER = 2   /* the result would be no number: state and outputs are those before */\n}};\n",
        f"#define {U}_PERIOD {number(one.period)} /* s: {one.period:g}; step() is called once in it */\n",
    ]
    if one.argument:
        lines.append(declaration(N, one.part).rstrip("\n") + "\n")
    for title, where, meaning in one.layout:
        lines.append(f"/* Entries of `{title}`{': ' + meaning if meaning else ''}, SI: */\n")
        for label, (key, part) in zip(distinct(where), where.items(), strict=True):
            lines.append(
                f"#define {U}_{title.upper()}_{label.upper()} {part.start} /* {part.stop - part.start}: {key} */\n"
            )
    inner = f"    double now[{size}];\n    double next[{size}];\n" + (f"    double work[{work}];\n" if work else "")
    lines.append(f"typedef struct {{\n{inner}    int tick;\n}} {N}_state;\n")
    lines.append(
        f"/* At rest where the export was made.  Call it before the first step. */\nvoid {N}_start({N}_state *s);\n"
    )
    lines.append(_contract(one) + f"int {N}_step({N}_state *s, {arguments});\n")
    return "\n".join(lines)


def _contract(one: Stepped) -> str:
    told = {
        "reference": "what tool and joints should do at this sample, entries as above",
        "joints": "readings of the joints, m",
        "applied": "the forces the drives really applied in the last sample, N",
        "good": "0 where there is no such sample",
        "command": "joint forces asked for, N",
        "found": "what is found, entries as above",
    }
    return "/* One sample.\n" + "".join(f"   {n}: {told[n]}\n" for n in (*one.inputs, *one.outputs)) + "*/\n"
