"""make mutate: plants one sign error at a time in the equations, and says which tests see it.

A mutant is a module of gough with one sign changed: a + b to a - b and back, -a to a, += to -= and back.  Signs that
are not of equations are left alone: in indices, in range(), in texts, in functions that only check or draw.  Each
mutant lives in a process of its own, forked from one that has NumPy, CasADi and pytest loaded but no gough; the
module's tests are run there until the first that fails.  No file is changed.

    python tools/mutate.py                     all; writes docs/mutation.md
    python tools/mutate.py machine/strut.py    some; prints only
    --again                                    those that docs/mutation.md says nothing saw, or does not have (of the
                                               modules that are named, if some are); the page gets their rows
    --workers N --list --minutes M             after M minutes no more are begun; the page says which were not run

Exit status 1 if a sign error was seen by no test, and is not in EQUIVALENT with the reason why it changes nothing.
"""

from __future__ import annotations

import argparse
import ast
import contextlib
import difflib
import importlib
import importlib.abc
import importlib.util
import os
import resource
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).parents[1]
SRC = ROOT / "src" / "gough"
LONGEST = (
    300  # s of processor; a mutant that runs longer hangs, and a test that hangs is seen: no suite needs half of it
)
PAGE = ROOT / "docs" / "mutation.md"

_DYNAMICS = [f"tests/machine/test_{name}.py" for name in ("hexapod_dynamics", "reactions", "signs")]
_MACHINE = [
    *_DYNAMICS,
    "tests/machine/test_kinematics.py",
    "tests/machine/test_arrays.py",
    "tests/machine/test_energy.py",
]

_EVERY = ["tests/contract/test_machine.py"]  # machines whose velocities are not rates of their task, too
_LAWS = ["tests/control/test_equations.py", "tests/contract", "tests/control", "tests/simulate/test_run.py"]
_STOP = [f"tests/simulate/test_{name}.py" for name in ("faults_and_trip", "safe_stop")]
_ERRORS = ["tests/machine/test_faults.py", "tests/errors/test_parts.py"]
_PEERS = ["tests/export", "tests/oracle"]
_LIMITS = ["tests/machine/test_limits.py", "tests/machine/test_hexaglide_limits.py"]
_PASSIVE = "tests/machine/test_passive.py"
_RAILS = [
    "tests/machine/test_hexaglide.py",
    "tests/published/test_honegger_model.py",
    "tests/simulate/test_hexaglide_run.py",
]
_RAILS += [_PASSIVE, *_LIMITS[::-1]]
_ADAPTIVE = [f"tests/control/test_{name}.py" for name in ("adaptation", "sliding", "fuzzy_friction")]
_LINEAR = ["tests/simulate/test_linear.py", "tests/control/test_poles.py"]
_RUN = [f"tests/simulate/test_{name}.py" for name in ("run", "plant", "joint_forces")]

# module -> its tests, the likeliest first, and functions whose signs are of no equation
MODULES: dict[str, tuple[list[str], set[str]]] = {
    "frames.py": (["tests/test_frames.py", "tests/test_series.py", "tests/conventions", *_DYNAMICS], set()),
    "machine/hexapod.py": ([*_MACHINE, _PASSIVE, "tests/machine/test_faults.py"], {"_outline", "drawing", "_sound"}),
    "machine/strut.py": (_MACHINE, set()),
    "machine/strut_bodies.py": (_MACHINE, set()),
    "machine/strut_motion.py": (_MACHINE, set()),
    "machine/joint_forces.py": (_MACHINE[1:] + _MACHINE[:1], {"_check_overlap", "load_count"}),
    "machine/reactions.py": (_MACHINE[1:] + _MACHINE[:1], set()),
    "machine/arrays.py": ([*_MACHINE, *_EVERY], {"column", "run", "_check_finite", "check_determinant"}),
    "mechanics/bodies.py": (["tests/mechanics/test_bodies.py", *_DYNAMICS], set()),
    "mechanics/friction.py": (["tests/mechanics", "tests/test_series.py", *_MACHINE[-1:]], {"_ordered"}),
    "mechanics/load_friction.py": (["tests/machine/test_signs.py", "tests/mechanics", *_MACHINE[-1:]], {"_ordered"}),
    "mechanics/linear.py": (["tests/mechanics/test_linear.py"], set()),
    "simulate/tick.py": ([_DYNAMICS[-1], "tests/oracle/test_pinocchio.py", *_RUN, *_MACHINE[-1:]], {"build"}),
    "simulate/drive.py": (_RUN, set()),
    "simulate/faults.py": (_STOP[:1], set()),
    "simulate/trip.py": (_STOP[:1], {"tripped"}),
    "simulate/safe_stop.py": (_STOP[1:], set()),
    "simulate/supervise.py": (_STOP[1:], {"supervision_of", "states", "_with"}),
    "simulate/stability.py": ([*_RUN[::-1], "tests/simulate/test_set_up.py", "tests/control"], set()),
    "simulate/plant.py": (_RUN[1:2] + _RUN[:1], set()),
    "simulate/linear.py": (_LINEAR, set()),
    "simulate/loop.py": (_LINEAR, set()),
    "simulate/bandwidth.py": (_LINEAR, set()),
    "simulate/drift.py": (["tests/simulate/test_drift.py"], set()),
    "simulate/joints.py": (_RUN[2:], set()),
    "observe/encoders.py": (["tests/observe/test_encoders.py", *_STOP[1:]], set()),
    "observe/forward.py": (["tests/observe", *_LAWS], set()),
    "control/pid.py": (_LAWS, set()),
    "control/computed_torque.py": (_LAWS, set()),
    "control/base.py": ([*_LAWS, *_RUN], set()),
    "control/adaptation.py": (_ADAPTIVE[:2], set()),
    "control/sliding.py": ([*_ADAPTIVE[1:], *_LAWS], {"_check_adapt"}),
    "control/robust_adaptive.py": ([*_ADAPTIVE[1:], *_LAWS], set()),
    "control/fuzzy_friction.py": ([*_ADAPTIVE[2:], *_LAWS], set()),
    "machine/base.py": ([_PASSIVE, _MACHINE[4], *_MACHINE[:4], *_RUN], {"model_post_init"}),
    "machine/platform.py": ([*_MACHINE, *_ERRORS, *_RAILS, *_LINEAR[:1]], {"outline"}),
    "machine/hexaglide.py": (_RAILS, {"drawing"}),
    "machine/hexaglide_parts.py": (_RAILS[::-1], set()),
    "machine/rail_limits.py": (_RAILS[::-1], set()),
    "machine/limits.py": (_LIMITS + _ERRORS, set()),
    "machine/strut_limits.py": ([*_LIMITS[:1], *_ERRORS, *_DYNAMICS[1:2], *_MACHINE[3:5], *_RUN], set()),
    "machine/forward.py": (_DYNAMICS[2:] + _MACHINE[3:5] + _ERRORS, {"_refuse"}),
    "machine/workspace.py": ([*_MACHINE[3:5], *_LIMITS, *_ERRORS, *_RUN, *_DYNAMICS[2:]], set()),
    "export/mjcf.py": (_PEERS, set()),
    "export/mjcf_frames.py": (_PEERS, set()),
    "export/mjcf_parts.py": (_PEERS, set()),
    "export/mjcf_hexapod.py": (_PEERS, set()),
    "export/mjcf_hexaglide.py": (_PEERS, set()),
    "export/mjcf_tripod.py": (_PEERS, set()),
}  # fmt: skip

ROOMS = ("mechanics", "machine", "control", "observe")  # those of equations alone

# functions of arrays whose arguments -1, -2 are axes
AXES = {
    "all",
    "any",
    "reshape",
    "moveaxis",
    "swapaxes",
    "stack",
    "concatenate",
    "norm",
    "sum",
    "argmax",
    "max",
    "min",
    "take_along_axis",
}

# "module: line's text -> changed piece": why it changes nothing that anyone could see
EQUIVALENT: dict[str, str] = {
    "machine/strut_motion.py: P_nud = (self.a_B - axial * n - 2 * self.ld * self.nu) / l [self.a_B - axial * n]": (
        "only n x P nu' is used, which knows nothing of a part along n"
    ),
    "mechanics/linear.py: sign = -1 if (sum(rows) - 3) % 2 else 1  # parity of moving `rows` to the front "
    "[sum(rows) - 3]": "only whether it is odd is asked, and 6 is even",
}


class Mutant:
    """One changed sign of one module."""

    def __init__(self, module: str, node: ast.AST, piece: str, line: str):
        self.module, self.place = module, (node.lineno, node.col_offset, type(node).__name__)
        self.piece, self.line = piece, line

    @property
    def key(self) -> str:
        """What EQUIVALENT calls it."""
        return f"{self.module}: {self.line} [{self.piece}]"

    def code(self):
        """The module with the change, compiled."""
        path = SRC / self.module
        tree = ast.parse(path.read_text())
        for node in ast.walk(tree):
            if type(node).__name__ == self.place[2] and (node.lineno, node.col_offset) == self.place[:2]:
                other = _changed(node)
                if other is not None and ast.unparse(node) == self.piece:
                    for parent in ast.walk(tree):
                        _replace(parent, node, other)
                    break
        return compile(ast.fix_missing_locations(tree), str(path), "exec")


_FLIP = {ast.Add: ast.Sub, ast.Sub: ast.Add}


def _changed(node):
    if isinstance(node, ast.BinOp) and type(node.op) in _FLIP:
        return ast.BinOp(node.left, _FLIP[type(node.op)](), node.right)
    if isinstance(node, ast.AugAssign) and type(node.op) in _FLIP:
        return ast.AugAssign(node.target, _FLIP[type(node.op)](), node.value)
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
        return node.operand
    return None


def _replace(parent, old, new):
    for name, value in ast.iter_fields(parent):
        if value is old:
            setattr(parent, name, new)
        elif isinstance(value, list) and any(item is old for item in value):
            setattr(parent, name, [new if item is old else item for item in value])


def mutants(module: str) -> list[Mutant]:
    """Every sign of the equations of a module, in order."""
    source = (SRC / module).read_text()
    lines, found = source.splitlines(), []
    skipped = MODULES.get(module, ([], set()))[1]

    def visit(node):
        if isinstance(node, ast.JoinedStr | ast.Raise | ast.arguments | ast.AnnAssign):
            return
        if isinstance(node, ast.FunctionDef) and node.name in skipped:
            return
        if isinstance(node, ast.Call) and getattr(node.func, "id", "") in ("range", "quantity", "InputError"):
            return
        texts = [n for n in ast.walk(node) if isinstance(n, ast.Constant) and isinstance(n.value, str)]
        lists = isinstance(node, ast.BinOp | ast.AugAssign) and any(
            isinstance(n, ast.List | ast.Tuple | ast.ListComp) for n in ast.iter_child_nodes(node)
        )
        if _changed(node) is not None and not (
            lists or (texts and isinstance(node, ast.BinOp | ast.AugAssign) and _joins(node))
        ):
            found.append(Mutant(module, node, ast.unparse(node), lines[node.lineno - 1].strip()))
        for child in ast.iter_child_nodes(node):
            if isinstance(node, ast.Subscript) and child is node.slice:
                continue
            if isinstance(node, ast.Call) and getattr(node.func, "attr", "") in AXES and _axis(child):
                continue
            visit(child)

    visit(ast.parse(source))
    return found


def _axis(node) -> bool:
    """-1, or axis=-1: which axis, or how long, of an array."""
    value = node.value if isinstance(node, ast.keyword) else node
    return isinstance(value, ast.UnaryOp) and isinstance(value.operand, ast.Constant)


def _joins(node) -> bool:
    """Whether a sum puts texts, lists or tuples together."""
    sides = (node.left, node.right) if isinstance(node, ast.BinOp) else (node.target, node.value)
    return any(
        isinstance(s, ast.Constant | ast.JoinedStr | ast.IfExp | ast.List | ast.Tuple) and not _number(s) for s in sides
    )


def _number(node) -> bool:
    return isinstance(node, ast.Constant) and isinstance(node.value, int | float)


class _Loader(importlib.abc.MetaPathFinder, importlib.abc.Loader):
    """Gives one module of gough its mutant's code."""

    def __init__(self, mutant: Mutant):
        self.name = "gough." + mutant.module.removesuffix(".py").replace("/", ".")
        self.code, self.path = mutant.code(), SRC / mutant.module

    def find_spec(self, name, path=None, target=None):
        if name != self.name:
            return None
        return importlib.util.spec_from_file_location(name, self.path, loader=self)

    def create_module(self, spec):
        return None

    def exec_module(self, module):
        exec(self.code, module.__dict__)


def _child(mutant: Mutant | None, tests: list[str], log: Path) -> None:
    """In the forked process: run the tests on the mutant (None: on gough as it is); ends the process."""
    out = os.open(log, os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
    os.dup2(out, 1)
    os.dup2(out, 2)
    os.environ["GOUGH_CACHE"] = str(log.parent / "cache")
    if mutant is not None:
        resource.setrlimit(resource.RLIMIT_CPU, (LONGEST, LONGEST))
    sys.path[:0] = [str(ROOT / "src"), str(ROOT / "tests")]
    os.chdir(ROOT)
    if mutant is not None:
        sys.meta_path.insert(0, _Loader(mutant))
    import pytest

    status = 3
    with contextlib.suppress(BaseException):
        status = pytest.main([*tests, "-x", "-q", "-p", "no:cacheprovider", "-m", "not slow", "--no-header"])
    os._exit(int(status))


def run(jobs, workers: int, folder: Path, tell, until: float = float("inf")):
    """Exit status of each job (mutant or None, tests), in processes of their own, `workers` at a time; "hangs" after
    LONGEST s of processor or an hour.  None is begun after `until`, and its status is None."""
    results: dict[int, tuple[object, Path]] = {}
    running: dict[int, tuple[int, float, Path]] = {}
    todo = list(enumerate(jobs))
    while todo or running:
        if time.monotonic() > until:
            todo = []
        while todo and len(running) < workers:
            number, (mutant, tests) = todo.pop(0)
            log = folder / f"{number}.log"
            pid = os.fork()
            if pid == 0:
                _child(mutant, tests, log)
            running[pid] = (number, time.monotonic(), log)
        time.sleep(0.05)
        for pid, (number, start, log) in list(running.items()):
            done, status = os.waitpid(pid, os.WNOHANG)
            late = not done and time.monotonic() - start > 3600
            if late:
                os.kill(pid, signal.SIGKILL)
                done, status = os.waitpid(pid, 0)
            if done:
                code = os.waitstatus_to_exitcode(status)
                results[number] = ("hangs" if late or code in (-signal.SIGXCPU, -signal.SIGKILL) else code, log)
                del running[pid]
                tell(number, *results[number])
    return [results.get(k, (None, folder)) for k in range(len(jobs))]


def first_failure(log: Path) -> str:
    """The test that saw a mutant, from what pytest printed."""
    for line in log.read_text(errors="replace").splitlines():
        if line.startswith(("FAILED ", "ERROR ")):
            return line.split(" ", 1)[1].partition(" - ")[0]
    return "gough did not even import"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("modules", nargs="*", help="modules below src/gough; all if none is given")
    parser.add_argument("--workers", type=int, default=os.cpu_count())
    parser.add_argument("--minutes", type=float, default=float("inf"))
    parser.add_argument("--list", action="store_true", help="only list the mutants")
    parser.add_argument("--again", action="store_true", help="on top of the page, which gets the new rows")
    given = parser.parse_args()
    planted = [
        m for module in (MODULES if given.again or not given.modules else given.modules) for m in mutants(module)
    ]
    rows, history = kept(planted) if given.again else ({}, [])
    stood = len(rows)
    planting = [
        number
        for number, mutant in enumerate(planted)
        if number not in rows and not (given.again and given.modules and mutant.module not in given.modules)
    ]
    chosen = list(dict.fromkeys(planted[number].module for number in planting))
    if given.list:
        for number in planting:
            print(planted[number].key)
        return 0
    for name in ("casadi", "h5py", "llvmlite.binding", "pydantic", "pytest", "scipy.linalg", "xarray"):
        importlib.import_module(name)  # once, before the forks

    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        suites = {module: MODULES[module][0] for module in chosen}
        every = sorted({test for tests in suites.values() for test in tests})
        every = [test for test in every if not any(test.startswith(f"{other}/") for other in every)]
        # once without a mutant: must be right, and fills the cache of compiled code
        ((status, log),) = run([(None, every)], 1, folder, lambda *_: None)
        if status != 0:
            print(f"the tests fail without any mutant: {first_failure(log)}", flush=True)
            return 2

        def tell(k, status, log):
            number = planting[k]
            mutant = planted[number]
            by = "" if status == 0 else ("a test that no longer ends" if status == "hangs" else first_failure(log))
            said = f"caught by {by}" if by else ("equivalent" if mutant.key in EQUIVALENT else "NOT CAUGHT")
            rows[number] = (said, by)
            print(f"{mutant.module}:{mutant.place[0]}: {mutant.piece}   {said}", flush=True)

        until = time.monotonic() + 60 * given.minutes
        jobs = [(planted[k], suites[planted[k].module]) for k in planting]
        run(jobs, given.workers, folder, tell, until=until)
    missed = [planted[k] for k in sorted(rows) if rows[k][0] == "NOT CAUGHT"]
    print(f"{len(rows)} of {len(planted)} sign errors planted, {len(missed)} not caught")
    for mutant in missed:
        print("NOT CAUGHT", mutant.key)
    if given.again or not given.modules:
        where = "all modules" if not given.again else "again, of " + ", ".join(chosen)
        said = f"- {len(rows) - stood} signs on {time.strftime('%Y-%m-%d')}, commit {_commit()}: {where}"
        write(planted, rows, [*history, said])
    return 1 if missed else 0


def _commit() -> str:
    """What was run: the commit, and whether files differ from it."""
    command = ["git", "-C", str(ROOT), "describe", "--always", "--exclude=*", "--dirty= with changes"]
    return subprocess.run(command, capture_output=True, text=True, check=False).stdout.strip() or "unknown"


def _cells(mutant: Mutant) -> tuple[str, str]:
    """Line and changed piece, as the page shows them."""
    piece = mutant.piece if len(mutant.piece) < 70 else mutant.piece[:67] + "..."
    return str(mutant.place[0]), f"`{piece}`".replace("|", "\\|")


NOTHING, NOT_RUN = "**nothing**", "not run in this campaign"


def kept(planted) -> tuple[dict, list[str]]:
    """Rows of the page that stand, by number, and its runs.

    A row stands as long as its sign does: in the same module, with the same signs before and after it, on any line.
    """
    found, history, module = {}, [], ""
    for line in PAGE.read_text().splitlines():
        if line.startswith("## "):
            module = line[3:]
        elif line.startswith("- "):
            history.append(line)
        elif line.startswith("| ") and not line.startswith("| line"):
            piece, by = line[2:-2].split(" | ", 1)[1].rsplit(" | ", 1)
            found.setdefault(module, []).append((piece, by))
    rows = {}
    for module, old in found.items():
        now = [number for number, mutant in enumerate(planted) if mutant.module == module]
        pieces = [_cells(planted[number])[1] for number in now], [piece for piece, _ in old]
        for i, j, length in difflib.SequenceMatcher(None, *pieces, autojunk=False).get_matching_blocks():
            for number, (_, by) in zip(now[i : i + length], old[j : j + length], strict=True):
                if planted[number].key in EQUIVALENT:
                    if by == EQUIVALENT[planted[number].key]:
                        rows[number] = ("equivalent", "")
                elif by not in (NOTHING, NOT_RUN):
                    rows[number] = (f"caught by {by}", by.replace("\\|", "|"))
    return rows, history


def left_out() -> list[str]:
    """Files of machines, mechanics, laws and observers that have signs, and no line in MODULES."""
    files = (str(path.relative_to(SRC)) for room in ROOMS for path in sorted((SRC / room).glob("*.py")))
    return [name for name in files if name not in MODULES and mutants(name)]


def write(planted, rows, history) -> None:
    """docs/mutation.md: what was planted, and which test saw it."""
    caught = sum(bool(by) for _, by in rows.values())
    unseen = sum(said == "NOT CAUGHT" for said, _ in rows.values())
    text = [
        "# Planted sign errors",
        "",
        "Written by `make mutate`: every sign in the equations changed, one at a time: of machines, mechanics, laws,",
        "observers, the plant and the export.  Not planted: the geometry of programs, the measures and the kernel; nor",
        f"yet in {', '.join(left_out())}.",
        "",
        f"{len(planted)} signs; {len(rows)} planted, {caught} caught, {len(rows) - caught - unseen} change nothing, "
        f"{unseen} not caught, {len(planted) - len(rows)} not run.",
        "The runs; a later one is in place of an earlier one, and a row stands while its sign does, on whatever line:",
        "",
        *history,
        "",
    ]
    for module in MODULES:
        text += [f"## {module}", ""]
        signs = [number for number, mutant in enumerate(planted) if mutant.module == module]
        text += ["| line | changed | seen by |", "|---|---|---|"] if signs else ["No sign."]
        for number in signs:
            said, by = rows.get(number, ("", NOT_RUN))
            by = by or (EQUIVALENT[planted[number].key] if said == "equivalent" else NOTHING)
            text.append("| " + " | ".join((*_cells(planted[number]), by.replace("|", "\\|"))) + " |")
        text.append("")
    PAGE.write_text("\n".join(text))


if __name__ == "__main__":
    sys.exit(main())
