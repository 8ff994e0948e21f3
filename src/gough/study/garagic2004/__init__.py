"""Garagic and Srinivasan, ACC 2004: contouring control of a Stewart platform machine tool, done again."""

from __future__ import annotations

from ..study import Study
from .beyond import BEYOND
from .drawings import figures
from .experiments import EXPERIMENTS
from .rows import claims

ABOUT = (
    "Three laws: CCTPID, computed torque with PID in Cartesian coordinates; CDAC, the paper's robust adaptive law; "
    "FCDAC, its fuzzy adaptive one.  Two cases, by sample rate and encoder: 4 kHz and 0.1 um, 1 kHz and 1 um.  "
    "The paper prints neither geometry nor masses, friction, gains or the sample time.  The machine is the data sheet "
    "nist-octahedral (gough show nist-octahedral: every number with its source); its friction and the poles of CCTPID "
    "were chosen so that glitches of 10 and 3 um and a corner of 350 um come out: these rows are calibrated, and "
    "their agreement says nothing of the paper.  The circle is a full turn about the origin from 240 degrees, at "
    "constant orientation: the printed end point is not on it, and the printed flip of 180 degrees cannot be made."
)

STUDY = Study(
    paper="garagic2004",
    title="Contouring Control of Stewart Platform Based Machine Tools",
    cited="D. Garagic and K. Srinivasan, American Control Conference, 2004",
    about=ABOUT,
    experiments=EXPERIMENTS,
    claims=claims,
    figures=figures,
    beyond=BEYOND,
)
