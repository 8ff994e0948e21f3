"""Random damage to NC programs: whatever the text, either blocks that are a path, or a ProgramError, soon and small.

python -m tests.program.fuzz COUNT SEED [ONLY]      status 0: nothing found; ONLY: this case alone, with its text
"""

from __future__ import annotations

import re
import signal
import sys
import time
from pathlib import Path

import numpy as np

from gough.errors import ProgramError
from gough.program.ngc.read import read_program
from gough.program.path import Path as ToolPath

from .oracle.cases import cases
from .oracle.generate import TOOLS, Writer

SECONDS, MEGABYTES, STEPS = 1.0, 300, 20_000
LONGEST = 300  # characters of a message
ROOT = Path(__file__).parents[2]
_TOKENS = re.findall(
    r"\S+",
    """
    G0 G1 G2 G3 G4 G10 G17 G18 G19 G20 G21 G28 G28.1 G30 G40 G43 G43.1 G49 G53 G54 G59.3 G61 G61.1 G64 G80 G90
    G91 G90.1 G91.1 G92 G92.1 G93 G94 M0 M2 M3 M5 M6 M30 M61 M70 M72 M73 X Y Z A B C F I J K L P Q R S T H D N
    E U O o1 o<x> sub endsub call return if elseif else endif while endwhile do repeat endrepeat break
    continue [ ] [[ ]] ( ) ; % / # #1 #<x> #<_y> #5220 = + - * ** / MOD AND OR XOR EQ NE GT GE LT LE SIN COS
    TAN ASIN ACOS ATAN EXP LN SQRT ABS FIX FUP ROUND EXISTS 0 1 -1 .5 1e9 999999999999 0.0000000001 -0 1000000
    1e308 nan inf 0x10 (MSG,x) (py,1) (debug,#1)
    """,
)
_TOKENS += [
    "\N{ARABIC-INDIC DIGIT ONE}",
    "\N{SUPERSCRIPT TWO}",
    "\xe9",
    "\0",
    "\x7f",
    "\t",
    "\r",
    "\ufeff",
    "\u2028",
    "\x0b",
]


def peak_memory() -> float:
    """The most memory this process has had, MB.  Not ru_maxrss: that begins with what its parent had."""
    with open("/proc/self/status", encoding="ascii") as file:
        return next(int(line.split()[1]) for line in file if line.startswith("VmHWM")) / 1024


def corpus() -> list[str]:
    """What is damaged: shipped programs, generated ones, bad ones."""
    shipped = sorted([*ROOT.glob("examples/**/*.ngc"), *ROOT.glob("src/gough/program/**/*.ngc")])
    texts = [text for file in shipped if len(text := file.read_text()) < 20_000]
    return texts + [Writer(seed).text for seed in range(60)] + [case.text for case in cases()]


def damaged(rng, texts) -> str:
    """One text with a few wounds."""
    text = texts[rng.integers(len(texts))]
    for _ in range(rng.choice([1, 1, 1, 2, 3, 6])):
        text = _wound(rng, text, texts)
    return text


def _wound(rng, text, texts):
    # mostly what leaves a program that runs: digits, whole lines
    kind = rng.choice(9, p=[0.06, 0.08, 0.06, 0.35, 0.12, 0.12, 0.08, 0.08, 0.05])
    at = int(rng.integers(len(text) + 1))
    token = _TOKENS[rng.integers(len(_TOKENS))]
    lines = text.split("\n")
    row = int(rng.integers(len(lines)))
    if kind == 0:
        return text[:at] + text[at + int(rng.integers(1, 9)) :]
    if kind == 1:
        return text[:at] + token + text[at:]
    if kind == 2:
        return text[:at] + chr(int(rng.choice([rng.integers(128), rng.integers(0x3000)]))) + text[at + 1 :]
    if kind == 3:  # a digit for a digit
        places = [k for k, letter in enumerate(text) if letter.isdigit()]
        if places:
            k = places[rng.integers(len(places))]
            return text[:k] + str(rng.integers(10)) * int(rng.integers(1, 4)) + text[k + 1 :]
        return text
    if kind == 4:
        lines.insert(int(rng.integers(len(lines))), lines[row])
    elif kind == 5:
        del lines[row]
    elif kind == 6:
        other = texts[rng.integers(len(texts))].split("\n")
        k = int(rng.integers(len(other)))
        lines[row:row] = other[k : k + int(rng.integers(1, 12))]
    elif kind == 7:
        lines[row] += " " + token
    else:
        lines[row] = lines[row] * int(rng.integers(2, 50))
    return "\n".join(lines)


ACCEPTED, REFUSED = "accepted", "refused"


class Slow(Exception):
    """A program took longer than it may."""


def trouble(text: str) -> str:
    """What is wrong with how we read this text; ACCEPTED or REFUSED if nothing is."""
    try:
        signal.setitimer(signal.ITIMER_PROF, SECONDS)
        blocks = read_program(text, "part.ngc", tools=TABLE, steps=STEPS)
        if len(blocks):
            path = ToolPath(blocks)
            every = np.arange(len(path))
            ends = path.point(every, path.length)
            if not (np.isfinite(ends).all() and np.isfinite(path.s0).all() and np.isfinite(path.turn).all()):
                return "a number that is not finite"
    except ProgramError as error:
        return _told_badly(error.at(file="part.ngc")) or REFUSED
    except Slow:
        return f"longer than {SECONDS} s"
    except BaseException as error:
        return repr(error)
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
    return ACCEPTED


def _told_badly(error) -> str | None:
    """A problem names its line, in one line of a length that one can read."""
    for one in map(str, error.problems):
        if not re.match(r"part\.ngc:\d+: [\w\"]", one) or len(one) > LONGEST or not one.isprintable():
            return f"told badly: {one[:400]!r}"
    return None


TABLE = {n: {"x": x / 1e3, "y": y / 1e3, "length": z / 1e3} for n, x, y, z in TOOLS}


def main(count: int, seed: int, only: int | None = None) -> int:
    """Runs the cases; prints what was found, and how to repeat it."""

    def stop(*_):
        raise Slow

    signal.signal(signal.SIGPROF, stop)
    texts = corpus()
    found, accepted, began = 0, 0, time.perf_counter()
    for case in range(count) if only is None else [only]:
        text = damaged(np.random.default_rng([seed, case]), texts)
        if only is not None:
            print(text)
        wrong = trouble(text)
        accepted += wrong == ACCEPTED
        if wrong not in (ACCEPTED, REFUSED):
            found += 1
            print(f"{wrong}\n    repeat: python -m tests.program.fuzz {count} {seed} {case}")
    if count >= 1000 and not 0.03 < accepted / count < 0.9:
        found += 1
        print("the damage is too great, or too small, to find anything")
    # KiB on Linux; with what Python and NumPy need themselves
    most = peak_memory()
    if most > MEGABYTES:
        found += 1
        print(f"{most:.0f} MB of memory, at most {MEGABYTES}")
    print(
        f"{count} programs, {accepted} accepted, {found} troubles, {most:.0f} MB, {time.perf_counter() - began:.1f} s"
    )
    return min(found, 1)


if __name__ == "__main__":
    sys.exit(main(*map(int, sys.argv[1:])))
