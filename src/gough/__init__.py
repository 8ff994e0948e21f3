"""gough: an open toolbox for parallel kinematic machine tools.

    import gough as gk

    machine = gk.load_machine("nist-octahedral")
    log = gk.simulate(machine, gk.PID(bandwidth=20), gk.Circle(radius=0.2, feed=0.05))
    print(gk.measure(log))

Units are SI in Python; files carry theirs.  Names are imported when they are first used, so that `import gough` and
`gough --help` stay quick.
"""

from __future__ import annotations

import sys
from importlib import import_module
from types import ModuleType
from typing import Any

__version__ = "0.1.0"

# the public names in reading order: name -> module
_PUBLIC = {
    "load_machine": "machine.sheet",
    "library": "machine.sheet",
    "Hexapod": "machine.hexapod",
    "load_program": "program",
    "Line": "program",
    "Circle": "program",
    "Ellipse": "program",
    "Polyline": "program",
    "Spline": "program",
    "PID": "control.pid",
    "AxisPD": "control.axis_pd",
    "ComputedTorque": "control.computed_torque",
    "RobustAdaptive": "control.robust_adaptive",
    "FuzzyFriction": "control.fuzzy_friction",
    "DisturbanceObserver": "observe.disturbance",
    "DesiredTorqueAdaptive": "control.desired_torque_adaptive",
    "EquivalentError": "control.equivalent_error",
    "Plant": "simulate.plant",
    "simulate": "simulate.run",
    "linearize": "simulate.linear",
    "Log": "log",
    "measure": "measure",
    "identify": "identify.fit",
    "report": "report",
    "monitor": "monitor",
    "export": "export",
    "load_experiment": "experiment",
    "GoughError": "errors",
    "InputError": "errors",
    "RunError": "errors",
}
# found by their names too, but not listed: thirty names are what a reader can hold
_BESIDE = {"envelope": "plan.envelope"}
_VERBS = ("simulate", "measure", "identify", "report", "monitor", "export")  # packages that are also called

__all__ = [*_PUBLIC]


class _Verb(ModuleType):
    """A package that does what its name says when it is called, by its function of the same name."""

    @property
    def _function(self) -> Any:
        name = self.__name__.rpartition(".")[2]
        return getattr(import_module(f"gough.{_PUBLIC[name]}"), name)

    def __call__(self, *args: Any, **options: Any) -> Any:
        return self._function(*args, **options)

    @property
    def __doc__(self) -> str | None:
        return self._function.__doc__

    @property
    def __signature__(self) -> Any:
        import inspect

        return inspect.signature(self._function)


class _Gough(ModuleType):
    """This package.  Whoever imports gough.simulate first, gough.simulate(...) can be called."""

    def __setattr__(self, name: str, value: Any) -> None:  # the import system sets submodules by this
        if name in _VERBS and type(value) is ModuleType:
            value.__class__ = _Verb
        super().__setattr__(name, value)


def __getattr__(name: str) -> Any:
    if name in _VERBS:
        return import_module(f".{name}", __name__)
    module = _PUBLIC.get(name) or _BESIDE.get(name)
    if module is None:
        raise AttributeError(f"module 'gough' has no attribute {name!r}")
    found = getattr(import_module(f".{module}", __name__), name)
    globals()[name] = found
    return found


def __dir__() -> list[str]:
    return [*__all__, "__version__"]


sys.modules[__name__].__class__ = _Gough
