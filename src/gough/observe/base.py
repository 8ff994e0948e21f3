"""What every observer is: numbers, `init` and `step`, beside a law or on a recorded log.

    state = observer.init(x0)                                  NumPy; the machine at rest at the pose x0
    found, state = observer.step(state, y, good, theta)        symbolic and pure; theta as observer.theta

`y` is the Measurement of control/base.py: readings of the joints, and the forces the drives really applied in the last
sample.  `good` is 0 where a log has no such sample, and then y is any finite numbers.  What an observer finds is a
NamedTuple.  Like a law it believes a machine; it changes nothing of what the law does.
"""

from __future__ import annotations

from abc import abstractmethod
from typing import Any, ClassVar

from ..declare import Part, quantity
from ..machine.base import Machine


class Observer(Part):
    """Base of all observers.  `machine` and `period` may be left open: the run fills them in by `on`."""

    found: ClassVar[dict[str, tuple[str, str, str]]] = {}  # of what it finds: (dimension, unit, meaning), for the log

    machine: Machine | None = None
    period: float | None = quantity("s", "sample period; the run's where it is left open", default=None, above=0)

    @abstractmethod
    def init(self, x0) -> Any:
        """The first state, a NamedTuple of NumPy: the machine stands at the pose x0 (d,)."""

    @abstractmethod
    def step(self, state, y, good, theta) -> tuple[Any, Any]:
        """What is found at one sample, and the next state, symbolic and pure; theta as `self.theta`."""

    def on(self, machine: Machine, period: float) -> Observer:
        """This observer for a machine and a sample period, where it does not have its own."""
        return self.replace(
            machine=self.machine if self.machine is not None else machine,
            period=self.period if self.period is not None else period,
        )
