"""Chen and Tsai, 2008: contouring a 3-PRS by equivalent errors with integral sliding mode, done again."""

from __future__ import annotations

from ..study import Study
from .beyond import BEYOND
from .drawings import figures
from .experiments import EXPERIMENTS
from .rows import claims

ABOUT = (
    "The paper prints gains and paths, and neither geometry nor masses, step, duration or start.  The machine is the "
    "data sheet ccu-3prs (gough show ccu-3prs: every number with its source), without encoder steps and torque limit; "
    "2 s at 1 ms; the tool starts at rest on the path, the reference at full speed.  25 and 50 % are on all masses, "
    "inertias and screws, which was chosen because the averages then come out.  Two signs are repaired: the printed "
    "+Omega in the law, and the third term of the sliding variable, an integral."
)

STUDY = Study(
    paper="chen2008",
    title="Contouring Control of a Parallel Mechanism Based on Equivalent Errors",
    cited="S.-L. Chen and Y.-C. Tsai, 2008",
    about=ABOUT,
    experiments=EXPERIMENTS,
    claims=claims,
    figures=figures,
    beyond=BEYOND,
)
