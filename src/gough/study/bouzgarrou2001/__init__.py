"""Bouzgarrou, Ray, Gogu, Thuilot, 2001: a high-speed machine with a parallel XY stage, rigid and flexible."""

from __future__ import annotations

from ..study import Study
from .drawings import figures
from .experiments import EXPERIMENTS
from .rows import claims

ABOUT = (
    "The paper prints the move, gains and results; geometry, masses and stiffnesses are lost with Fig. 1 and earlier "
    "reports.  The machine is the data sheet ifma-hsm (gough show ifma-hsm: every number with its source), its mirror "
    "image in x = 0, without encoder steps; laws and plant at 50 us for the paper's continuous time.  Two misprints "
    "are repaired: a factor Phi_phi^-1 in C_S, and k_p = 2.25e3 of the low gains, which is 2.25e4."
)

STUDY = Study(
    paper="bouzgarrou2001",
    title="Modeling and Control of a HSM Machine Tool With Parallel Kinematics",
    cited="B. C. Bouzgarrou, P. Ray, G. Gogu and B. Thuilot, 2001",
    about=ABOUT,
    experiments=EXPERIMENTS,
    claims=claims,
    figures=figures,
)
