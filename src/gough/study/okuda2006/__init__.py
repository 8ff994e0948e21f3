"""Okuda et al. 2006, first half, done again: motor torques on circles in air, a static load told from the drives."""

from __future__ import annotations

from ..study import Study
from .drawings import figures
from .experiments import EXPERIMENTS
from .rows import claims

ABOUT = (
    "The paper prints neither geometry nor masses, friction or torques.  The machine is the data sheet okuma-pm600 "
    "(gough show okuma-pm600: every number with its source).  What stands for the real machine here knows things the "
    "estimate does not: friction with bristles, a Stribeck rise and a viscous part, 10 % different from strut to "
    "strut; friction of the joints that grows with their load; torques read in steps of 0.03 N m, noise of 0.05 N m. "
    "The paper's model, its signs repaired (theory page disturbance.md), learns m_S, m_T, f_0j and t_0j from circles "
    "of 100 mm both ways at both tilts, and predicts those of 144 mm.  The true friction is "
    "chosen: docs/studies/okuda2006.md has the rows over its ranges.  Cutting (sections 4.3 and 5) is not here yet."
)

STUDY = Study(
    paper="okuda2006",
    title="Disturbance Estimation on a Hexapod-type Parallel Kinematic Machine Tool by Using a Disturbance Observer",
    cited="T. Okuda, S. Ibaraki, Y. Kakino, M. Nakagawa, T. Matsushita, 2006",
    about=ABOUT,
    experiments=EXPERIMENTS,
    claims=claims,
    figures=figures,
)
