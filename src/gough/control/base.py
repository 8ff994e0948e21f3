"""What every control law is: numbers, `init` and `step`, and `tasks` where not all of it runs at one rate.

    state = law.init(r0, u0)                               NumPy; u0 the joint forces at rest
    state = task.step(state, r, y, theta)                  every task of law.tasks() that is due, in their order
    command, state = law.step(state, r, y, theta)          symbolic and pure; theta as law.theta

A task runs at a multiple of the law's period, at sample 0 and every `period` seconds after, on the State, Reference and
Measurement that `step` gets a moment later: what it leaves in the State, `step` finds there, until it is due again.

The first step gives u0 when r = r0 and q = q(r0): a law starts without a bump.  `r` is a program.reference.Reference,
`y` a Measurement.  A law believes a machine (`law.machine`); what is true is the Plant's business.  Laws act on twists
and rotation vectors, never on Euler angles.  Saturation and delay belong to the drive; a law sees them through
Measurement.u.

A law of one's own is a subclass of Controller in any file, handed to gk.simulate.  Written in CasADi's operations it is
compiled; with `symbolic = False` its step gets and gives NumPy arrays and is called from Python every sample, some
forty times slower, and the run says so.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable
from typing import Any, ClassVar, NamedTuple

import casadi as ca
import numpy as np

from ..declare import Part, quantity
from ..machine.base import Machine
from ..machine.drives import force_limit


class Measurement(NamedTuple):
    """What the controller is told at sample k."""

    q: Any  # encoder readings, (n,) m
    u: Any  # the force the drives really applied in the last sample, (n,) N


class Command(NamedTuple):
    """What the controller asks for."""

    u: Any  # joint forces, (n,) N


class Task(NamedTuple):
    """A part of a law with a period of its own; `law.<name>_period`, where it is a number of the law."""

    name: str
    period: float  # s, a multiple of the law's
    step: Callable  # (state, r, y, theta) -> next state, symbolic and pure


class Controller(Part):
    """Base of all laws.  `machine` and `period` may be left open: the run fills them in by `on`."""

    states: ClassVar[dict[str, tuple[str, str, str]]] = {}  # of its State: (dimension, unit, meaning), for the log
    # numbers that make the loop so many times as quick when all of them grow so many times
    tuned: ClassVar[tuple[str, ...]] = ()
    adapted: ClassVar[tuple[str, ...]] = ()  # names of states that are learned
    symbolic: ClassVar[bool] = True  # False: `step` is plain NumPy and takes the slow path

    machine: Machine | None = None
    period: float | None = quantity(
        "s", "sample period of the law; the run's where it is left open", default=None, above=0
    )

    @abstractmethod
    def init(self, r0, u0) -> Any:
        """The law's first state, a NamedTuple of NumPy: the first step gives u0 (n,) N when r = r0 and q = q(r0)."""

    @abstractmethod
    def step(self, state, r, y, theta) -> tuple[Command, Any]:
        """The command of one sample and the next state, symbolic and pure; theta as `self.theta`."""

    def tasks(self) -> tuple[Task, ...]:
        """What runs at multiples of `period`, before `step` and in this order.  Which there are hangs on no number."""
        return ()

    def doubts(self) -> tuple[str, ...]:
        """What a run with this law, bound by `on`, should warn of, numbers included."""
        return ()

    def standing(self) -> Controller:
        """A law of the same linear loop that is defined at rest at home, for `simulate.stability`; itself for most."""
        return self

    def believing(self, machine: Machine) -> Controller:
        """This law, bound by `on`, with other numbers of the machine it believes."""
        return self.replace(machine=machine)

    def learns(self, name: str) -> bool:
        """Whether adaptation moves the state of this name."""
        return name.partition(".")[0] in self.adapted

    def state_told(self, name: str) -> tuple[str, str, str] | None:
        """What `states` says of the state of this name."""
        return self.states.get(name)

    def check_motion(self, motion, period: float) -> None:
        """Refuse a motion that this law cannot follow, before it starts; most follow any."""

    def on(self, machine: Machine, period: float) -> Controller:
        """This law for a machine and a sample period, where it does not have its own.  Numbers may follow from both."""
        return self.replace(
            machine=self.machine if self.machine is not None else machine,
            period=self.period if self.period is not None else period,
        )


def unknown_force(machine, r0, u0):
    """What the joint forces u0 (n,) N do on v at rest at r0 beyond what the model of `machine` asks for.  (len(v),)."""
    x0 = np.ravel(r0.x)
    still = np.zeros(len(x0))
    return machine.velocity_jacobian(x0).T @ (np.ravel(u0) - machine.inverse_dynamics(x0, still, still))


def saturated(machine, p, u):
    """1 where an applied force (n,) has reached the limit of its drive, else 0; None without a limit.

    `p` is the view of `machine`.  A law that integrates stops while this holds (conditional integration): it needs no
    memory of what it asked for, so a delay in the drive does not confuse it.
    """
    if force_limit(machine.drive) is None:
        return None
    return ca.fabs(u) >= force_limit(p.drive) * (1 - 1e-9)
