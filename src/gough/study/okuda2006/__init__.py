"""Okuda et al. 2006, done again: torques of circles, a static load, milling forces, compensation of the tool."""

from __future__ import annotations

from ..study import Study
from . import drawings, experiments, milling, milling_drawings, milling_rows, rows
from .cantilever import CANTILEVER
from .certainty import CERTAINTY

ABOUT = (
    "The paper prints neither geometry nor masses, friction or torques.  The machine is the data sheet okuma-pm600 "
    "(gough show okuma-pm600: every number with its source).  What stands for the real machine here knows things the "
    "estimate does not: friction with bristles, a Stribeck rise and a viscous part, 10 % different from strut to "
    "strut; friction of the joints that grows with their load; torques read in steps of 0.03 N m, noise of 0.05 N m. "
    "The paper's model, its signs repaired (theory page disturbance.md), learns m_S, m_T, f_0j and t_0j from circles "
    "of 100 mm both ways at both tilts, and predicts those of 144 mm.  The true friction is "
    "chosen: docs/studies/okuda2006.md has the rows over its ranges.  The second half (sections 4.3 and 5) mills: a "
    "tool of two flutes with 5 um of runout cuts in closed loop, its force is told from the same torques, and the "
    "spindle leans against it, by commands from a first cut and in the loop.  The wall leans by the paper's law of the "
    "tool, f(d), with other coefficients than those believed; what a cantilever leaves whose wall is made tooth by "
    "tooth stands beside it.  The material is calibrated on table 3, and so is f(d): figure 10 is lost."
)

FIRST = len(experiments.EXPERIMENTS)

STUDY = Study(
    paper="okuda2006",
    title="Disturbance Estimation on a Hexapod-type Parallel Kinematic Machine Tool by Using a Disturbance Observer",
    cited="T. Okuda, S. Ibaraki, Y. Kakino, M. Nakagawa, T. Matsushita, 2006",
    about=ABOUT,
    experiments=(*experiments.EXPERIMENTS, *milling.EXPERIMENTS),
    claims=lambda results: [*rows.claims(results[:FIRST]), *milling_rows.claims(results[FIRST:])],
    figures=lambda results, folder: [
        *drawings.figures(results[:FIRST], folder), *milling_drawings.figures(results[FIRST:], folder),
    ],
    beyond=(CANTILEVER, CERTAINTY),
)  # fmt: skip
