"""How far the ends of an arc may be off before it is refused: the same for LinuxCNC, at every size, in mm and inch."""

import itertools

import numpy as np
import pytest

from gough.errors import ProgramError
from gough.program.ngc.read import read_program

from .canon import Refused
from .linuxcnc import missing, read_full

SIZES = (0.05, 1, 40, 2000, 50_000)
OFF = (3e-5, 9e-5, 4e-4, 1.1e-3, 2.4e-3, 2.7e-3, 6e-3, 0.1, 0.4, 0.6)


def arcs():
    """Programs: by centre with one end off, by radius with the radius short; size and error in the program's unit."""
    for unit, size, off in itertools.product(("G21", "G20"), SIZES, OFF):
        if off < 3 * size and not (unit == "G20" and size > 9999):  # places end at 10^6 mm
            yield f"{unit}\nF100\nG2 X{2 * size + off:.9f} I{size:.9f}\nM2\n"
            yield f"{unit}\nF100\nG3 Y{size:.9f} X{size + off:.9f} I0 J{size:.9f}\nM2\n"
            yield f"{unit}\nG18 F100\nG2 X{2 * size:.9f} I{size:.9f} K{off:.9f}\nM2\n"
            yield f"{unit}\nF100\nG2 X{2 * size:.9f} R{size - off / 2:.9f}\nM2\n" if off < size else None


def refused(text):
    try:
        read_program(text)
    except ProgramError:
        return True
    return False


@pytest.mark.full
def test_an_arc_is_refused_where_linuxcnc_refuses_it(tmp_path):
    if missing():
        pytest.skip(missing())
    texts = [text for text in arcs() if text]
    theirs = [isinstance(one, Refused) for one in read_full(texts, tmp_path)]
    assert 0.2 < np.mean(theirs) < 0.8, "both happen"
    other = [text for text, no in zip(texts, theirs, strict=True) if no != refused(text)]
    assert not other, f"{len(other)} of {len(texts)}: {other[:4]}"
