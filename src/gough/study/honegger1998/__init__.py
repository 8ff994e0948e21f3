"""Honegger 1998: nonlinear adaptive control of a 6 DOF parallel manipulator, the Hexaglide, done again."""

from __future__ import annotations

from ..study import Study
from .beyond import BEYOND
from .drawings import figures
from .experiments import EXPERIMENTS
from .rows import claims

ABOUT = (
    "The paper prints masses, friction and sample times, but neither rails nor platform joints, the circle's radius, "
    "the poles, the learning factors or the motion to learn from.  The machine is the data sheet eth-hexaglide (gough "
    "show eth-hexaglide: every number with its source); radius and geometry were chosen so that the PD rows of Table 2 "
    "come out: these rows are calibrated.  The circle is in the plane of x and y, 15 mm, its error that of the radius "
    "over one steady turn.  The law learns on straight lines between the corners of a cube of 0.2 m, at 0.4 m/s and "
    "10 m/s2, from half of the true parameters, which are those of Table 1."
)

STUDY = Study(
    paper="honegger1998",
    title="Nonlinear Adaptive Control of a 6 DOF Parallel Manipulator",
    cited="M. Honegger, ETH Zurich, 1998",
    about=ABOUT,
    experiments=EXPERIMENTS,
    claims=claims,
    figures=figures,
    beyond=BEYOND,
)
