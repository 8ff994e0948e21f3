"""How tools give way: the measured law at its printed points, the cantilever against its differential equation."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from cutting.mills import mill
from gough.cutting import Beam, EndMill, Leaning

TOOL = mill(extension=75e-3)


def test_the_measured_law_leans_as_the_paper_printed():
    """Okuda et al. 2006, table 3, estimated forces 38, 58, 76 N: B +0.038, +0.060, +0.083 deg; X 12, 19, 26 um.

    Half a unit of the digits that are printed.
    """
    theta = Leaning().inclination(np.array([38.0, 58.0, 76.0]))
    assert_allclose(np.degrees(theta), [0.038, 0.060, 0.083], rtol=0, atol=0.5e-3)
    delta = Leaning().lateral(TOOL, np.array([38.0, 58.0, 76.0]), 9e-3, 0.0, 18e-3)
    assert_allclose(delta, [12e-6, 19e-6, 26e-6], rtol=0, atol=0.5e-6)


def test_the_measured_law_turns_round_with_the_force_and_stands_at_the_upper_edge():
    law = Leaning()
    assert_allclose(law.inclination(-50.0), -law.inclination(50.0), rtol=1e-15)
    assert law.lateral(TOOL, 50.0, 9e-3, 18e-3, 18e-3) == 0


def test_a_beam_bends_as_its_differential_equation_says():
    """E I y'' = F (x_F - x) up to the force and 0 behind it, y = y' = 0 at the clamping: integrated numerically."""
    law, F, at = Beam(), 80.0, 9e-3
    x = np.linspace(0, TOOL.extension, 20_001)
    bend = F * np.maximum(TOOL.extension - at - x, 0) / law.stiffness(TOOL)
    step = x[1]
    slope = np.concatenate([[0], np.cumsum((bend[1:] + bend[:-1]) / 2)]) * step
    y = np.concatenate([[0], np.cumsum((slope[1:] + slope[:-1]) / 2)]) * step
    # trapezoids: h^2 / 12 of the second derivative, here 1e-9 of the whole
    assert_allclose(law.lateral(TOOL, F, at, TOOL.extension - x, 18e-3), y, rtol=0, atol=1e-7 * y[-1])
    assert_allclose(law.slope(TOOL, F, at), slope[-1], rtol=1e-7)


def test_a_beam_gives_as_much_there_by_a_force_here_as_here_by_one_there():
    law = Beam()
    assert_allclose(law.lateral(TOOL, 1.0, 4e-3, 15e-3, 0), law.lateral(TOOL, 1.0, 15e-3, 4e-3, 0), rtol=1e-14)


def test_twice_the_length_bends_eight_times_at_its_end():
    short, long = (EndMill(diameter=10e-3, teeth=2, extension=L) for L in (40e-3, 80e-3))
    assert_allclose(Beam().lateral(long, 1.0, 0, 0, 0) / Beam().lateral(short, 1.0, 0, 0, 0), 8, rtol=1e-12)


@pytest.mark.parametrize("law", [Leaning(), Beam()])
def test_no_force_no_deflection(law):
    assert law.lateral(TOOL, 0.0, 9e-3, 0.0, 18e-3) == 0
