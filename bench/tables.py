"""docs/performance.md out of the figures."""

from __future__ import annotations

from .rows import COUNT, LIMITS

_LOOPS = (
    ("interpreter", "CasADi's interpreter"), ("one lane", "machine code, one lane"),
    ("lanes", "machine code, {width} lanes"),
    ("simulate", "`gk.simulate()`, one run, with reference, contour error and log"),
    ("batch", "`gk.simulate()`, a batch of {runs}, metrics only"),
    ("one lane / interpreter", "one lane against the interpreter"),
    ("lanes / one lane", "**{width} lanes against one lane** (aim: {aim} without friction, 4.5 with)"),
    ("batch / simulate", "batch against one run, all included"),
    ("operations", "operations a sample"), ("compile_s", "compile time of one lane, s"),
)  # fmt: skip


def page(result: dict) -> str:
    lines = [
        "# Performance", "",
        f"Written by `make bench`, gough {result['version']}; figures in performance.json.  Medians of "
        f"{result['rounds']} interleaved rounds, CPU time of one core; ratios", "are medians within a round.", "",
        f"Processor: {result['processor']}", "",
    ]  # fmt: skip
    for part, write in _PARTS:
        if part in result:
            lines += [*write(result[part]), ""]
    return "\n".join(lines).rstrip() + "\n"


def _loops(found: dict) -> list[str]:
    about = ["Simulated seconds a CPU second; of several runs, all together.  The octahedral hexapod under computed "
             "torque, 1 kHz, RK4 at", "0.25 ms, on a circle."]  # fmt: skip
    return ["## Simulation", "", *about, "", *_rates("friction", found)]


def _laws(found: dict) -> list[str]:
    about = [
        "The same with the friction of the sheet under three laws: computed torque, CDAC (`robust_adaptive`) and FCDAC",
        "(`fuzzy_friction`).  Last: `ccu-3prs` on the circle of Chen and Tsai 2008 under `equivalent_error` at their",
        "gains, no friction.  Aims: FCDAC one run 20, a batch 5 times one run; the 3-PRS one run 20.",
    ]
    return ["## Laws", "", *about, "", *_rates("law", found)]


def _learning(found: dict) -> list[str]:
    from .learning import MOST

    about = ["Ten minutes of learning on line: `eth-hexaglide`, loop of 300 us, model every 900 us, adaptation every "
             "3 ms, a row of the log", "every 100 samples; median of three."]  # fmt: skip
    body = [
        ["samples", f"{found['samples']:_}".replace("_", " ")], ["rows of the log", _cell(found["rows"])],
        ["simulated, s", _cell(found["simulated_s"])], [f"**CPU, s** (aim: below {MOST:g})", _cell(found["cpu_s"])],
        ["simulated seconds a CPU second", _cell(found["rate"])],
    ]  # fmt: skip
    return ["## Learning", "", *about, "", *table(["", ""], body)]


def _rates(head: str, found: dict) -> list[str]:
    from .loops import RUNS

    cases, width = found["cases"], found["width"]
    told = {"width": width, "runs": RUNS, "aim": {8: 4, 4: 3}.get(width, "none")}
    body = [[label.format(**told), *(_cell(case[key]) for case in cases.values())] for key, label in _LOOPS]
    return table([head, *cases], body)


def _rows(found: dict) -> list[str]:
    body = [[name, _cell(seconds), _cell(LIMITS.get(name, ""))] for name, seconds in found.items()]
    return ["## Arrays", "", f"{COUNT:_} rows from Python, CPU seconds.".replace("_", " "), "",
            *table(["", "s", "aim, below"], body)]  # fmt: skip


def _workers(found: dict) -> list[str]:
    body = [
        ["plain arithmetic loop, two processes against one", _cell(found["loop, two / one"])],
        ["batch of one slab, two processes against one", _cell(found["batch, two / one"])],
        ["**the second against the first** (aim: 0.9)", _cell(found["workers"])],
    ]
    return ["## Two workers", "", *table(["", "times"], body)]


def _peers(found: dict) -> list[str]:
    if "missing" in found:
        return ["## Peers", "", f"Not measured: {found['missing']}."]
    return [
        "## Peers", "",
        "The same closed loop in general multibody engines, viscous friction only; an engine's fastest setting whose",
        "pose error over 2 s stays below 0.1 um is bold (bench/peers.py says how it is measured).", "", *found["lines"],
    ]  # fmt: skip


def _campaign(found: dict) -> list[str]:
    from .campaign import MOST_MEMORY, MOST_WALL, RUNS

    aim = f"{RUNS:_}".replace("_", " ")
    about = [
        "Closed-loop circles of `nist-octahedral` at 1 kHz under `robust_adaptive`, each with its own friction (LuGre",
        "that scales with the load), in two processes; all is counted: start, drawing, set-up, contour error, metrics.",
        f"Aim: {aim} runs of 1 s below {MOST_WALL:g} s, below {MOST_MEMORY / 1e9:g} GB.",
    ]
    heads = ["runs", "of, s", "wall, s", "CPU, s", "CPU a run, ms", "memory, MB"]
    body = [
        [f"{one['runs']:_}".replace("_", " "), f"{one['seconds']:.3g}", f"{one['wall_s']:.3g}", f"{one['cpu_s']:.3g}",
         f"{1e3 * one['cpu_s'] / one['runs']:.3g}", f"{one['memory'] / 1e6:.0f}"]
        for part in ("runs", "steps") for one in found[part]
    ]  # fmt: skip
    machines = [[one["machine"], _cell(1e3 * one["cpu_s"] / one["runs"])] for one in found["machines"]]
    lines = ["## Campaigns", "", *about, "", *table(heads, body), "", "By machine, a batch of 64 in one process:", ""]
    return [*lines, *table(["machine", "CPU a run of 1 s, ms"], machines)]


def table(heads: list[str], rows: list[list[str]]) -> list[str]:
    return [f"| {' | '.join(row)} |" for row in ([*heads], ["---"] * len(heads), *rows)]


def _cell(value) -> str:
    return f"{value:.3g}" if isinstance(value, float) else str(value)


_PARTS = (
    ("loops", _loops), ("laws", _laws), ("learning", _learning), ("rows", _rows), ("workers", _workers),
    ("peers", _peers), ("campaign", _campaign),
)  # fmt: skip
