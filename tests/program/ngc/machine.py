"""What the tests of the machine side share: a program of some lines, its blocks, its error."""

import pytest

from gough.errors import ProgramError
from gough.program.blocks import Arc, Line, Rest
from gough.program.ngc.read import read_program
from gough.program.ngc.tools import tools_of

TOOLS = tools_of({1: {"length": 0.01}, 5: {"x": 0.001, "y": 0.002, "length": 0.05, "diameter": 0.006}})


def read(*lines, **options):
    return list(read_program("\n".join([*lines, "M2"]), "part.ngc", **options))


def refused(*lines, **options):
    """The text of the error, without the file's name."""
    with pytest.raises(ProgramError) as caught:
        read(*lines, **options)
    return str(caught.value).replace("part.ngc:", "")


def end(block):
    """Where the tip is behind a block, m."""
    segment = block.segment
    if type(segment) is Line:
        return segment.end
    if type(segment) is Rest:
        return segment.at
    raise TypeError("an arc")


def ends(blocks):
    """x y z in mm and a b c in degrees behind each block that is no arc."""
    degrees = 57.29577951308232
    return [(*(1e3 * v for v in end(b)), *(degrees * v for v in b.abc1)) for b in blocks if type(b.segment) is not Arc]


def moves(blocks):
    """Without the stops that take no time."""
    return [b for b in blocks if type(b.segment) is not Rest or b.dwell > 0 or b.abc0 != b.abc1]
