"""LinuxCNC and we read the same motion out of generated programs and out of every program we ship.

`gcode`, LinuxCNC's interpreter as a library, tells places to the last bit; `rs274 -g` prints four decimals and also
tells feed, path control, dwell, stops and spindle.  How many programs: GOUGH_NC (20 000 with --slow), from seed
GOUGH_NC_SEED on.
"""

import os
import re
from pathlib import Path

import pytest

from gough.errors import ProgramError
from gough.program.ngc.read import read_program

from .canon import Refused
from .compare import differences, of_blocks
from .expressions import FUNCTIONS, OPERATORS
from .generate import TOOLS, Writer, with_inch_parameters
from .linuxcnc import missing, read_full, read_printed

ROOT = Path(__file__).parents[3]
SHIPPED = sorted([*ROOT.glob("examples/**/*.ngc"), *ROOT.glob("src/gough/program/**/*.ngc")])
QUICK, MANY = 200, int(os.environ.get("GOUGH_NC", 20_000))
SEED = int(os.environ.get("GOUGH_NC_SEED", 0))
TABLE = {n: {"x": x / 1e3, "y": y / 1e3, "length": z / 1e3} for n, x, y, z in TOOLS}
# 1e-6 mm and 1e-6 deg are what was promised.  LinuxCNC counts in inch, 17 digits: some 1e-13 mm for each of a few
# hundred relative moves, and arcs tell centres of 12 decimals
FULL = {"length": 1e-6, "degrees": 1e-6}
CODES = """
    G0 G1 G2 G3 G4 G10 G17 G18 G19 G20 G21 G28 G28.1 G30 G30.1 G40 G43 G43.1 G43.2 G49 G53 G54 G55 G56 G57 G58 G59 G59.1
    G59.2 G59.3 G61 G61.1 G64 G80 G90 G90.1 G91 G91.1 G92 G92.1 G92.2 G92.3 G93 G94 G97 G98 G99
    M0 M1 M2 M3 M4 M5 M6 M7 M8 M9 M30 M48 M49 M50 M51 M52 M53 M60 M61 M70 M72 M73
    """
KEYWORDS = "sub endsub call return if elseif else endif while endwhile do repeat endrepeat break continue"


def printed_limits(printed):
    """Four numbers of four decimals make a place: the word, G92, G5x, and the tool; turned, X and Y count twice."""
    return {"length": 8 * printed.half, "degrees": 4 * 0.5e-4}


def compare(texts, folder):
    """(number, differences) of each program where there are any; a program that LinuxCNC refuses compares nothing."""
    full = read_full(texts, folder, TOOLS)
    for k, (text, theirs) in enumerate(zip(texts, full, strict=True)):
        printed = read_printed(with_inch_parameters(text), folder, TOOLS)
        if printed.error or isinstance(theirs, Refused):
            yield k, [f"LinuxCNC refuses it: {printed.error or theirs.text}"]
            continue
        try:
            ours = of_blocks(read_program(text, tools=TABLE, block_delete=False))
        except ProgramError as error:
            yield k, [f"we refuse it: {error}"]
            continue
        found = [f"gcode: {text}" for text in differences(ours, theirs, **FULL, full=True)]
        limits = printed_limits(printed)
        found += [f"rs274: {text}" for text in differences(ours, printed.moves, **limits, full=False)]
        if found:
            yield k, found


def told(seeds, found):
    return "\n".join(
        f"Writer({seeds[k]}).text:\n    " + "\n    ".join(lines[:4]) for k, lines in found[:5]
    ) + f"\n{len(found)} of {len(seeds)} programs differ"  # fmt: skip


@pytest.fixture(autouse=True)
def linuxcnc():
    if missing():
        pytest.skip(missing())


@pytest.mark.quick("circle-diamond-square", "s-piece", "04_pockets")
@pytest.mark.parametrize("file", SHIPPED, ids=lambda file: file.stem)
def test_a_shipped_program_moves_as_linuxcnc_moves_it(file, tmp_path):
    found = list(compare([file.read_text()], tmp_path))
    assert not found, "\n".join(found[0][1])


@pytest.mark.full
def test_generated_programs_move_as_linuxcnc_moves_them(tmp_path):
    seeds = range(SEED, SEED + QUICK)
    found = list(compare([Writer(seed).text for seed in seeds], tmp_path))
    assert not found, told(seeds, found)


def test_block_delete_leaves_out_what_linuxcnc_leaves_out(tmp_path):
    seeds = [seed for seed in range(QUICK) if "\n/" in Writer(seed).text]
    assert len(seeds) > 5
    for seed in seeds:
        text = Writer(seed).text
        printed = read_printed(with_inch_parameters(text), tmp_path, TOOLS, more=("-b",))
        ours = of_blocks(read_program(text, tools=TABLE, block_delete=True))
        assert len(ours) < len(read_program(text, tools=TABLE, block_delete=False))
        assert not differences(ours, printed.moves, **printed_limits(printed), full=False), f"Writer({seed}).text"


@pytest.mark.slow
def test_many_generated_programs_move_as_linuxcnc_moves_them(tmp_path):
    found = []
    for first in range(SEED, SEED + MANY, 500):
        seeds = range(first, min(first + 500, SEED + MANY))
        found += [(seeds[k], lines) for k, lines in compare([Writer(seed).text for seed in seeds], tmp_path)]
    assert not found, told(range(SEED + MANY), found)


def test_the_comparison_finds_a_planted_difference(tmp_path):
    text = "G21 F100 M3 S100\nG1 X10 Y5\nG2 I5 J1\nG61\nG1 A3\nM2\n"
    (theirs,) = read_full([text], tmp_path)
    printed = read_printed(text, tmp_path)
    for wrong, what in {
        text.replace("X10", "X10.00001"): "end",
        text.replace("I5", "I5.0001"): "center",
        text.replace("A3", "A3.00001"): "angles",
        text.replace("F100", "F100.001"): "feed",
        text.replace("G2 I", "G3 I"): "normal",
        text.replace("S100\n", "S100\n\n"): "line",
        text.replace("G1 A3", "G0 A3"): "rapid",
        text.replace("G1 A3\n", ""): "no move",
    }.items():
        ours = of_blocks(read_program(wrong, tools=TABLE))
        found = "\n".join(differences(ours, theirs, **FULL, full=True))
        assert what in found, f"{what} in {found}"
    for wrong, what in {
        text.replace("G61", "G64 P0.01"): "tolerance",
        text.replace("S100", "S101"): "spindle",
        text.replace("G61", "M0"): "stop",
        text.replace("G61", "G4 P1"): "dwell",
    }.items():
        ours = of_blocks(read_program(wrong, tools=TABLE))
        found = "\n".join(differences(ours, printed.moves, **printed_limits(printed), full=False))
        assert what in found, f"{what} in {found}"


def test_the_generated_programs_use_what_they_are_to_compare():
    text = "\n".join(Writer(seed).text for seed in range(QUICK))
    plain = re.sub(r"\([^)]*\)|;.*|<[^>]*>", "", text).upper().replace(" ", "")
    codes = {
        f"{letter}{int(number)}{rest}"
        for letter, number, rest in re.findall(r"(?<![A-Z])([GM])(\d+)((?:\.\d)?)", plain)
    }
    assert codes >= set(CODES.split())
    assert set(re.findall(r"(?<![A-Z<_])[A-Z](?=[-+.\d\[#])", plain)) >= set("ABCFGHIJKLMNPQRSTXYZO")
    for name in FUNCTIONS:
        assert f"{name}[" in plain, name
    for operator in OPERATORS:
        assert re.search(rf"[\d\]]{re.escape(operator)}[-+\d\[#A-Z]", plain), operator
    for word in KEYWORDS.split():
        assert re.search(rf"^\s*o.*\b{word}\b", text, re.M), word
    for written in [
        "##",
        "#[",
        "#<",
        "#<_",
        "\n/",
        "(MSG,",
        "; ",
        "%",
        "G10 L2 ",
        "G10 L20",
        "<_value>",
        "g1",
        " P",
        "R-",
    ]:
        assert written in text or written.lower() in text, written
    assert re.search(r"^\d+.*M98", text) is None
