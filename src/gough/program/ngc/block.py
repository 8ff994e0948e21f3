"""What a block holds, before anything of it is carried out: codes by group, who takes which word, what moves."""

from __future__ import annotations

from ...errors import Problem, ProgramError
from . import codes
from .codes import name_of
from .modes import Modes

LARGEST = 1e6  # of any word; a kilometre in mm is no machine tool's business
LARGEST_RADIUS = 1e9  # of R; arcs.py has more to say
AXES = "XYZABC"
ARC = (20, 30)
_KNOWN = frozenset("ABCFHIJKLPQRSTXYZ")
_TAKES_AXES = (100, 280, 300, 520, 920)  # besides G0 to G3, and G43.1
_APART = "write them in two blocks"

Groups = dict[str, int]


def sort(words) -> tuple[Groups, Groups]:
    """The G codes and the M codes of a block by their groups.

    Raises
    ------
    ProgramError
        with every code and letter that is not supported, and every two codes of one group.  Of the letters beside a
        code that is not supported nothing is said: what to write instead of it may need them.
    """
    problems: list[Problem] = []
    strange: list[str] = []
    g = _grouped("G", words.g, codes.G, words.texts, strange, problems)
    m = _grouped("M", words.m, codes.M, words.texts, strange, problems)
    if g.get(codes.AXES) in (520, 920) and codes.UNSHIFT in g:
        both = f"{name_of('G', g[codes.AXES])} {name_of('G', g[codes.UNSHIFT])}"
        problems.append(Problem("two words of one kind in a block", value=both, cure=_APART))
    for letter in words.values if not strange else ():  # the letters beside a strange code are that code's
        if letter not in _KNOWN:
            text = words.texts.get(letter, letter)
            problems.append(Problem("not supported", value=text, cure=codes.cure_of(letter)))
    if problems:
        raise ProgramError(problems=problems)
    return g, m


def _grouped(letter, found, groups, texts, strange, problems):
    kinds: Groups = {}
    for code in found:
        name, group = name_of(letter, code), groups.get(code)
        if group is not None and group in kinds:
            both = f"{name_of(letter, kinds[group])} {name}"
            problems.append(Problem("two words of one kind in a block", value=both, cure=_APART))
        elif group is not None:
            kinds[group] = code
        elif (letter, code) != ("G", codes.CANCEL):
            strange.append(name)
            problems.append(Problem("not supported", value=texts.get(name, name), cure=codes.cure_of(name)))
    return kinds


def moving(words, g: Groups, axes: dict[int, float], modes: Modes) -> int | None:
    """The code by which the block moves: 0, 10, 20, 30, or 280, 300; None: it does not.

    Raises
    ------
    ProgramError
        the axis words belong to no code or to two, or G53 to none.
    """
    explicit, special = g.get(codes.MOTION), g.get(codes.AXES)
    cancelled = codes.CANCEL in words.g
    taken_by = [code for code in (explicit, special if special in _TAKES_AXES else None) if code is not None]
    if g.get(codes.TOOL) == 431 and axes:
        taken_by += [431, 530] if special == 530 else [431]
    if len(taken_by) > 1:
        names = " ".join(name_of("G", code) for code in taken_by)
        raise ProgramError("two codes of a block that both take its axis words", value=names, cure=_APART)
    code = explicit
    if special in (280, 300):
        code = special
    elif axes and not taken_by:
        word = words.texts.get(AXES[min(axes)], AXES[min(axes)])
        if cancelled:
            raise ProgramError("an axis word beside G80", value=word, cure="write G0 or G1 for a move")
        code = modes.motion
        if code is None:
            raise ProgramError("an axis word with no G0, G1, G2 or G3 in force", value=word, cure="write e.g. G0 or G1")
    elif not taken_by and not cancelled and modes.motion in ARC and not {"I", "J", "K"}.isdisjoint(words.values):
        code = modes.motion  # a full circle needs no axis word
    if special == 530:
        if code not in (0, 10):
            value = None if code is None else name_of("G", code)
            raise ProgramError("G53 goes with G0 or G1", value=value, cure="write e.g. G53 G0 X0")
        if g.get(codes.DISTANCE, 900 if modes.absolute else 910) == 910:
            raise ProgramError("G53 with G91", cure="write G90: the place is counted from the machine's zero")
    return code


def takers(letter: str, g: Groups, m: Groups, code: int | None) -> int:
    """How many codes of a block that moves by `code` take a letter of codes.TAKERS."""
    special, arc, tuning = g.get(codes.AXES), code in ARC, g.get(codes.CORNER) == 640
    if letter in "IJK":
        return arc
    if letter == "R":
        return arc + (special == 100)
    if letter == "H":
        return g.get(codes.TOOL) in (430, 432)
    if letter == "L":
        return special == 100
    if letter == "P":
        return arc + (special in (40, 100)) + tuning + (m.get(codes.OVERRIDE) in (50, 51, 52, 53))
    return tuning + (m.get(codes.CHANGE) == 61)  # Q


def check_letters(words, g: Groups, m: Groups, code: int | None) -> None:
    """Every letter is taken by one code, and its number is not too large.

    Raises
    ------
    ProgramError
        with every letter where that is not so.
    """
    problems: list[Problem] = []
    for letter, value in words.values.items():
        text = words.texts.get(letter, letter)
        if letter in codes.TAKERS:
            count = takers(letter, g, m, code)
            if not count and letter in "IJKR":
                problems.append(Problem(f"{letter} belongs to an arc", value=text, cure="write G2 or G3"))
            elif not count:
                rule = f"{letter} without a code that takes it"
                problems.append(Problem(rule, value=text, cure=codes.cure_of_unused(letter)))
            elif count > 1:
                problems.append(Problem(f"two codes of a block that both take {letter}", value=text, cure=_APART))
        most = LARGEST_RADIUS if letter == "R" else LARGEST
        counts_turns = letter == "P" and code in ARC  # checked with the arc
        if not abs(value) <= most and not counts_turns:
            cure = "F is mm/min: write at most" if letter == "F" else "write at most"
            problems.append(Problem(f"{letter} is beyond {most:.0f}", value=text, cure=f"{cure} {most:.0f}"))
    if problems:
        raise ProgramError(problems=problems)
