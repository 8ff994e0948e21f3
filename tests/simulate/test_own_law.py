"""A law of one's own: compiled when it is symbolic, slower and the same when it is plain NumPy."""

from __future__ import annotations

from typing import Any, ClassVar, NamedTuple

import numpy as np
import pytest

import gough as gk
from gough.control.base import Command, Controller
from gough.declare import quantity
from gough.kernel import KernelWarning
from gough.simulate.notes import StabilityWarning

CIRCLE = gk.Circle(radius=0.02, feed=0.2, settle=0.05)


class State(NamedTuple):
    q: Any
    u0: Any


class Springs(Controller):
    """PD on every strut about the force at rest."""

    kind: str = "springs"
    stiffness: float = quantity("N/m", "of each strut", above=0)
    damping: float = quantity("N s/m", "of each strut", above=0)

    def init(self, r0, u0):
        return State(np.ravel(r0.q), np.ravel(u0))

    def step(self, state, r, y, theta):
        p = self.at(theta)
        v = (y.q - state.q) / p.period
        return Command(state.u0 + p.stiffness * (r.q - y.q) + p.damping * (r.qd - v)), State(y.q, state.u0)


class PlainSprings(Springs):
    """The same, in plain NumPy."""

    symbolic: ClassVar[bool] = False

    def step(self, state, r, y, theta):
        v = (y.q - state.q) / self.period
        u = state.u0 + self.stiffness * (r.q - y.q) + self.damping * (r.qd - v)
        return Command(u), State(y.q, state.u0)


def test_plain_numpy_gives_the_same_run_and_says_that_it_is_slow():
    machine = gk.load_machine("nist-octahedral")
    gains = {"stiffness": 4e6, "damping": 8e4}
    fast = gk.simulate(machine, Springs(**gains), CIRCLE)
    with pytest.warns(KernelWarning, match="control is plain Python"):
        slow = gk.simulate(machine, PlainSprings(**gains), CIRCLE)
    # interpreter and machine code differ by rounding; friction's bristles forget it
    np.testing.assert_allclose(slow["x"], fast["x"], rtol=0, atol=1e-10)
    # the heaviest direction of the coupled struts, 3960 kg, at v^2 / r = 2 m/s2, twice for the swing
    assert fast.metrics["contour_error"]["max"] < 2 * 3960 * 2 / 4e6


def test_two_plain_laws_keep_their_own_numbers():
    machine = gk.load_machine("nist-octahedral").replace(friction=None)
    short = gk.Line(to=[0.001, 0, 0], feed=0.1, settle=0.02)
    with pytest.warns(KernelWarning):
        runs = [gk.simulate(machine, PlainSprings(stiffness=k, damping=8e4), short)["x"] for k in (4e6, 2e6)]
    assert not np.array_equal(*runs)


@pytest.mark.full
def test_a_batch_under_a_plain_law_is_its_single_runs_and_takes_one_law_only():
    """A step in plain NumPy may read its own numbers, which are those of one object."""
    machine = gk.load_machine("nist-octahedral").replace(friction=None)
    short, law = gk.Line(to=[0.001, 0, 0], feed=0.1, settle=0.02), PlainSprings(stiffness=4e6, damping=8e4)
    plants = [gk.Plant(machine=machine, payload=mass) for mass in (10.0, 20.0)]
    with pytest.warns(KernelWarning):
        runs = gk.simulate(machine, law, short, plant=plants)
        alone = [gk.simulate(machine, law, short, plant=plant) for plant in plants]
    for i in range(2):
        np.testing.assert_array_equal(runs.run(i)["x"], alone[i]["x"])
    other = PlainSprings(stiffness=2e6, damping=8e4)
    with pytest.raises(gk.InputError, match=r"^controller: .* must be symbolic: .* plain NumPy, got PlainSprings"):
        gk.simulate(machine, [law, other], short)
    springs = [Springs(stiffness=k, damping=8e4) for k in (4e6, 2e6)]
    runs = gk.simulate(machine, springs, short, lanes=1)
    for i in range(2):
        np.testing.assert_array_equal(runs.run(i)["x"], gk.simulate(machine, springs[i], short)["x"])


class Nothing(NamedTuple):
    """A law that remembers nothing."""


class Stiffness(Controller):
    """Springs without dampers: no state."""

    kind: str = "stiffness"
    stiffness: float = quantity("N/m", "of each strut", above=0)

    def init(self, r0, u0):
        return Nothing()

    def step(self, state, r, y, theta):
        p = self.at(theta)
        return Command(p.stiffness * (r.q - y.q)), state


def test_a_law_may_remember_nothing():
    machine = gk.load_machine("nist-octahedral").replace(gravity=[0.0, 0.0, 0.0])
    # springs without dampers, held for a sample, gain energy; the check of the loop knows it
    with pytest.warns(StabilityWarning, match="stiffness: the loop at a period of 1 ms is unstable"):
        log = gk.simulate(machine, Stiffness(stiffness=1e5), gk.Line(to=[0.0, 0, 1e-3], feed=0.01, settle=0.1))
    assert log.status == "done" and np.isfinite(log["x"]).all()
