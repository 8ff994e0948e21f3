"""Control laws by name: those of gough, and those that installed packages offer by the entry point `gough.controllers`.

A name is looked up, never imported: "os.system" is a law only if an installed package says so.
"""

from __future__ import annotations

from functools import cache
from importlib import import_module
from importlib.metadata import EntryPoint, entry_points
from typing import Any

from ..errors import ExperimentError, did_you_mean

GROUP = "gough.controllers"
OWN = {
    "pid": "gough.control.pid:PID",
    "axis_pd": "gough.control.axis_pd:AxisPD",
    "computed_torque": "gough.control.computed_torque:ComputedTorque",
    "desired_torque_adaptive": "gough.control.desired_torque_adaptive:DesiredTorqueAdaptive",
    "robust_adaptive": "gough.control.robust_adaptive:RobustAdaptive",
    "fuzzy_friction": "gough.control.fuzzy_friction:FuzzyFriction",
    "equivalent_error": "gough.control.equivalent_error:EquivalentError",
    "gravity_compensation": "gough.control.gravity_compensation:GravityCompensation",
    "flexible_feedforward": "gough.control.flexible_feedforward:FlexibleFeedforward",
}

# what a law named on the command line starts with, where it needs a number: half of what both library machines bear
START = {
    "pid": {"bandwidth": "10 Hz"},
    "axis_pd": {"stiffness": "4 N/um"},
    "computed_torque": {"bandwidth": "10 Hz"},
    "desired_torque_adaptive": {"pole": "100 1/s"},
    "robust_adaptive": {"slope": "100 1/s", "damping": "200 1/s"},
    "fuzzy_friction": {"slope": "100 1/s", "damping": "200 1/s"},
    "equivalent_error": {},
    "gravity_compensation": {"law": {"kind": "computed_torque", "bandwidth": "10 Hz"}},
    "flexible_feedforward": {"law": {"kind": "computed_torque", "bandwidth": "10 Hz"}},
}


@cache
def laws() -> dict[str, EntryPoint | str]:
    """Every law there is: name -> where it is.  gough's own names cannot be taken by others."""
    found: dict[str, EntryPoint | str] = {point.name: point for point in entry_points(group=GROUP)}
    return dict(sorted({**found, **OWN}.items()))


def law_class(kind: Any) -> type:
    """The class of a law.

    Raises
    ------
    ExperimentError
        there is none of this name, or its package cannot be imported.
    """
    if not isinstance(kind, str) or kind not in laws():
        cure = did_you_mean(kind, laws()) if isinstance(kind, str) else f"one of {', '.join(laws())}"
        raise ExperimentError("no such controller", key="kind", value=ascii(kind)[:60], cure=cure)
    place = laws()[kind]
    if isinstance(place, str):
        module, _, name = place.partition(":")
        return getattr(import_module(module), name)
    try:
        law = place.load()
    except Exception as error:  # whatever an installed package does when it is imported
        package = place.dist.name if place.dist else place.value
        raise ExperimentError(
            f"the controller of package {package} cannot be imported", key="kind", value=str(error)
        ) from error
    if not (isinstance(law, type) and hasattr(law, "from_file") and hasattr(law, "model_fields")):
        raise ExperimentError(f"{place.value} is not a law: it must be a Part", key="kind")
    return law
