"""Laws whose parts run at several rates."""

from __future__ import annotations

from typing import Any, ClassVar, NamedTuple

import numpy as np
import pytest

import gough as gk
from gough.control.base import Command, Controller, Task
from gough.declare import quantity
from gough.kernel import KernelWarning
from gough.simulate import stability

SHORT = gk.Line(to=[0.0, 0, 1e-3], feed=0.05, settle=0.01)


@pytest.fixture(scope="module")
def machine():
    return gk.load_machine("nist-octahedral").replace(friction=None)


class State(NamedTuple):
    slow: Any  # counts
    slower: Any
    steps: Any
    seen: Any  # what step found in `slow` and `slower`, 100 slow + slower
    spring: Any  # forces
    error: Any
    u0: Any


class Counting(Controller):
    """PD on every strut with its springs in a task of their own, and tasks that count."""

    kind: str = "counting"
    stiffness: float = quantity("N/m", "of each strut", default=4e6, above=0)
    damping: float = quantity("N s/m", "of each strut", default=8e4, above=0)
    slow_period: float = quantity("s", "of one task", default=3e-3, theta=False, above=0)
    slower_period: float = quantity("s", "of the other", default=4e-3, theta=False, above=0)
    growth: float = quantity("1", "what a sample of the slow task makes of its state", default=1.0)

    def init(self, r0, u0):
        return State(0.0, 0.0, 0.0, 0.0, np.zeros(6), np.zeros(6), np.ravel(u0))

    def tasks(self):
        return (
            Task("slow", self.slow_period, lambda s, r, y, theta: s._replace(slow=self.at(theta).growth * s.slow + 1)),
            Task("slower", self.slower_period, lambda s, r, y, theta: s._replace(slower=s.slow)),
            Task("spring", self.period, self.springs),
        )

    def springs(self, state, r, y, theta):
        return state._replace(spring=self.at(theta).stiffness * (r.q - y.q))

    def step(self, state, r, y, theta):
        p = self.at(theta)
        e = r.q - y.q
        u = state.u0 + state.spring + p.damping * (e - state.error) / p.period
        seen = 100 * state.slow + state.slower
        return Command(u), state._replace(error=e, steps=state.steps + 1, seen=seen)


class Plain(Counting):
    """The same in plain NumPy."""

    symbolic: ClassVar[bool] = False

    def tasks(self):
        return (
            Task("slow", self.slow_period, lambda s, r, y, theta: s._replace(slow=self.growth * s.slow + 1)),
            Task("slower", self.slower_period, lambda s, r, y, theta: s._replace(slower=s.slow)),
            Task("spring", self.period, lambda s, r, y, theta: s._replace(spring=self.stiffness * (r.q - y.q))),
        )

    def step(self, state, r, y, theta):
        e = r.q - y.q
        u = state.u0 + state.spring + self.damping * (e - state.error) / self.period
        seen = 100 * state.slow + state.slower
        return Command(u), state._replace(error=e, steps=state.steps + 1, seen=seen)


def test_tasks_run_at_their_multiples_from_sample_0_on_before_the_step_and_in_their_order(machine):
    log = gk.simulate(machine, Counting(), SHORT)
    k = np.arange(len(log["t"]))
    np.testing.assert_array_equal(log["controller.steps"], k + 1)
    np.testing.assert_array_equal(log["controller.slow"], k // 3 + 1)
    slower = (k // 4 * 4) // 3 + 1  # what `slow` was at the last multiple of four
    np.testing.assert_array_equal(log["controller.slower"], slower)
    np.testing.assert_array_equal(log["controller.seen"], 100 * (k // 3 + 1) + slower)


@pytest.mark.full
def test_a_law_slower_than_the_plant_has_tasks_at_multiples_of_its_own_period(machine):
    law = Counting(period=2e-3, slow_period=6e-3, slower_period=4e-3, stiffness=1e6, damping=4e4)
    log = gk.simulate(machine, law, SHORT)
    k = np.arange(len(log["t"]))
    np.testing.assert_array_equal(log["controller.steps"], k // 2 + 1)
    np.testing.assert_array_equal(log["controller.slow"], k // 6 + 1)


def test_a_part_of_a_law_as_a_task_of_the_same_period_is_that_law(machine):
    together = gk.AxisPD(stiffness=4e6, damping=8e4)
    in_two = gk.simulate(machine, Counting(), SHORT)
    # k e + d e' / Ts against u_0 + k e + ...: the same sums in another order
    np.testing.assert_allclose(in_two["x"], gk.simulate(machine, together, SHORT)["x"], rtol=0, atol=1e-15)


def test_tasks_in_plain_numpy_are_the_same_run(machine):
    fast = gk.simulate(machine, Counting(), SHORT)
    with pytest.warns(KernelWarning, match="law slow"):
        slow = gk.simulate(machine, Plain(), SHORT)
    for name in ("slow", "slower", "seen"):
        np.testing.assert_array_equal(slow[f"controller.{name}"], fast[f"controller.{name}"])
    np.testing.assert_allclose(slow["x"], fast["x"], rtol=0, atol=1e-12)


@pytest.mark.full
def test_runs_side_by_side_have_their_tasks_too(machine):
    laws = [Counting(stiffness=k) for k in (4e6, 3e6)]
    log = gk.simulate(machine, laws, SHORT, lanes=1)
    for i, law in enumerate(laws):
        np.testing.assert_array_equal(log.run(i)["x"], gk.simulate(machine, law, SHORT)["x"])


def test_a_period_that_is_no_multiple_is_refused_by_name(machine):
    with pytest.raises(gk.InputError) as caught:
        gk.simulate(machine, Counting(slow_period=2.5e-3), SHORT)
    assert str(caught.value) == (
        "controller.slow_period: counting: the period of a law's task must be a multiple of the law's own, 1 ms, "
        "got 2.5 ms; give 2 ms or 3 ms"
    )
    with pytest.raises(gk.InputError, match=r"slower_period: .*got 0\.4 ms; give 1 ms or 2 ms$"):
        gk.simulate(machine, Counting(slower_period=4e-4), SHORT)


def test_the_spectral_radius_is_that_of_a_cycle_of_all_rates_per_sample(machine):
    """A state that grows by 1.5 every three samples, in a cycle of twelve."""
    law = Counting(growth=1.5).on(machine, 1e-3)
    assert stability.spectral_radius(machine, law, 1e-3, 2) == pytest.approx(1.5 ** (1 / 3), rel=1e-6)
    slow = Counting(period=2e-3, slow_period=6e-3, slower_period=8e-3, growth=1.5, stiffness=1e6, damping=4e4)
    assert stability.spectral_radius(machine, slow.on(machine, 1e-3), 1e-3, 2) == pytest.approx(
        1.5 ** (1 / 3), rel=1e-6
    )
