"""The C of an FMU: the printed tasks of the plant, and FMI 2.0 for co-simulation around them.

All numbers of an instance lie in one array, so a state is kept, copied and given back by one memcpy, and a value
reference is a place in it.  A step that leaves the machine's limits, or gives what is no number, is undone: the
instance stands where it stood, and the master is told why.
"""

from __future__ import annotations

from pathlib import Path

from ...kernel.schedule import Task
from ..c import printer
from ..c.functions import CONTRACT
from ..c.printer import number
from .model import Model

GLUE = Path(__file__).with_name("fmi2.c")
HEADER = Path(__file__).with_name("fmi2.h")


def sources(model: Model, guid: str) -> dict[str, str]:
    """The C files: {name: text}.  The first is compiled, it includes the others."""
    return {
        f"{model.name}.c": _model_text(model, guid),
        "fmi2.h": HEADER.read_text("utf-8"),
        "fmi2.c": GLUE.read_text("utf-8"),
    }


def _model_text(model: Model, guid: str) -> str:
    tasks = {t.name: t for t in (model.drive, *model.substep, *model.sense, model.limits)}
    functions, names, by_tape, work = [], {}, {}, 1
    for task in tasks.values():
        tape = model.tapes[task.name]
        if tape.digest in by_tape:  # the four rates are one function
            names[task.name] = by_tape[tape.digest]
            continue
        label = f"task_{len(by_tape)}_{task.function.name()}"
        spilled = printer.spilled(tape)
        work = max(work, spilled)
        ins, outs = [f"a{i}" for i in range(len(tape.inputs))], [f"b{j}" for j in range(len(tape.outputs))]
        functions.append(printer.function(tape, label, ins, outs, work=spilled > 0))
        names[task.name] = by_tape[tape.digest] = label
    total = len(model.first)
    values = printer.wrapped(", ".join(number(v) for v in model.first), 4)
    kinds = ["0"] * total
    for variable in model.variables:
        kinds[variable.place] = "1" if variable.causality == "input" else "2"
    limits = ",\n    ".join(f'"{name}"' for name in model.limit_names) or '""'

    def calls(group: tuple[Task, ...], indent: int) -> str:
        return "".join(f"{' ' * indent}{_call(model, task, names[task.name])}\n" for task in group)

    count, step = len(model.limit_names), model.period / model.substeps
    return f"""/* {model.about}.
   SI units.  {model.substeps} sub-steps of {step:g} s a sample.  Only an instance is allocated. */
#include "fmi2.h"

#include <math.h>
#include <string.h>

{CONTRACT}
#define GUID "{guid}"
#define PERIOD {number(model.period)} /* s */
#define TOTAL {total}
#define LIMITS {count}

static const double first[TOTAL] = {{
    {values}}};

static const unsigned char kind[TOTAL] = {{ /* 1: input, 2: output */
    {printer.wrapped(", ".join(kinds), 4)}}};

static const char *const limit_names[] = {{
    {limits}}};

{chr(10).join(functions)}
/* Outputs and limits of the state that v holds.  0, or 1 + the limit that is left. */
static int sense(double *v, double *work)
{{
    double margin[{max(count, 1)}];
    int i;
    (void)work;
{calls(model.sense, 4)}    {_call(model, model.limits, names["limits"], {"limits": "margin"})}
    for (i = 0; i < LIMITS; i++)
        if (!(margin[i] >= 0.0))
            return 1 + i;
    return 0;
}}

static void advance(double *v, double *work)
{{
    int i;
    (void)work;
    {_call(model, model.drive, names["drive"])}
    for (i = 0; i < {model.substeps}; i++) {{
{calls(model.substep, 8)}    }}
}}

/* Whether all numbers are finite. */
static int sound(const double *v)
{{
    int i;
    for (i = 0; i < TOTAL; i++)
        if (!isfinite(v[i]))
            return 0;
    return 1;
}}

#define WORK {work}
#include "fmi2.c"
"""


def _call(model: Model, task: Task, label: str, elsewhere: dict[str, str] | None = None) -> str:
    tape, elsewhere = model.tapes[task.name], elsewhere or {}
    given = []
    for names, sizes in ((task.reads, tape.inputs), (task.writes, tape.outputs)):
        given += [elsewhere.get(n) or f"v + {model.places[n][0]}" for n, size in zip(names, sizes, strict=True) if size]
    if printer.spilled(tape):
        given.append("work")
    return f"{label}({', '.join(given)});"
