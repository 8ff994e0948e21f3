"""Identification: the numbers of a machine from what its drives did, with how sure they are, and what stayed unseen.

fit = gk.identify(log, machine)          a table of values and deviations; `free` names what is sought
program = excite(machine)                a motion that shows them, for gk.simulate and gough run
"""

from .base import BaseParameters, base_parameters
from .excite import excite, shown
from .fit import Fit, identify
from .physical import Physical, physical_parameters
from .regress import Estimate, estimate
from .rows import Rows, rows_of_log, rows_of_motion

__all__ = [
    "BaseParameters",
    "Estimate",
    "Fit",
    "Physical",
    "Rows",
    "base_parameters",
    "estimate",
    "excite",
    "identify",
    "physical_parameters",
    "rows_of_log",
    "rows_of_motion",
    "shown",
]
