"""Laws and observers in C: step after step the bits of one lane, at all rates, and no number that is none."""

from __future__ import annotations

import ctypes
from typing import ClassVar

import numpy as np
import pytest
from compiled import build, needs_gcc, pointer

import gough as gk
from gough.control.base import Controller
from gough.errors import ExperimentError
from gough.experiment.laws import OWN, START
from gough.experiment.observers import OBSERVERS, observer_of
from gough.experiment.parts import controller_of
from gough.export.c.check_text import step_rows
from gough.export.c.step_text import law_stepped, observer_stepped, step_text
from gough.kernel.pack import flatten
from gough.simulate import tick

OK, NOT_FINITE, NO_NUMBER = 0, 1, 2
PERIOD, TICKS = 1e-3, 100
LONG = 5000  # operations a step beyond which the replay in Python takes a second for ten steps
MACHINES = ("okuma-pm600", "eth-hexaglide", "ccu-3prs", "ifma-hsm")


class Stepper:
    """A law or an observer in C."""

    def __init__(self, folder, one):
        self.one = one
        c, h = step_text(one)
        self.library = build(folder, {f"{one.name}.c": c, f"{one.name}.h": h}, options=("-O0",))
        self.state, self.f = ctypes.create_string_buffer(64_000), getattr(self.library, f"{one.name}_step")
        getattr(self.library, f"{one.name}_start")(self.state)

    def step(self, values):
        """Status and what comes out of one step."""
        out = np.full(sum(self.one.outputs.values()), -7.0)
        given = [int(v[0]) if n == "good" else pointer(v) for n, v in zip(self.one.inputs, values, strict=True)]
        return self.f(self.state, *given, pointer(out)), out


def law_on(name, kind, tmp_path):
    """A law on a machine at rest at home, in C, and its recorded steps."""
    machine = gk.load_machine(name)
    row, u0 = tick.rest_row(machine, machine.home), machine.at_rest(machine.home)[1]
    law = controller_of({"kind": kind, **START[kind]}).law.on(machine, PERIOD)
    one = law_stepped(f"m_{kind}", law, row, u0)
    ticks = TICKS if max(tape.operations for _, tape, _ in one.tasks) < LONG else 20
    return Stepper(tmp_path, one), step_rows(one, flatten(row), np.ravel(row.q), u0, ticks)


def hold_step_by_step(stepper, rows):
    for k, (values, expected, _) in enumerate(rows):
        status, found = stepper.step(values)
        assert status == OK
        assert np.array_equal(found, expected), k


COSTLY = pytest.param("gravity_compensation", marks=pytest.mark.slow)  # 690 kB of C a machine


@needs_gcc
def test_a_law_in_c_steps_with_the_bits_of_one_lane(tmp_path):
    hold_step_by_step(*law_on("nist-octahedral", "pid", tmp_path))


@needs_gcc
@pytest.mark.full("okuma-pm600-*", "ifma-hsm-flexible_feedforward", "ccu-3prs-p*")
@pytest.mark.parametrize("kind", [COSTLY if kind == COSTLY.values[0] else kind for kind in OWN])
@pytest.mark.parametrize("name", MACHINES)
def test_every_law_on_every_machine_in_c_steps_with_the_bits_of_one_lane(name, kind, tmp_path):
    try:
        stepper, rows = law_on(name, kind, tmp_path)
    except ExperimentError as error:  # what the law itself refuses of a machine
        pytest.skip(str(error)[:120])
    hold_step_by_step(stepper, rows)


@needs_gcc
@pytest.mark.full
def test_tasks_of_a_law_run_when_they_are_due_and_only_then(tmp_path):
    stepper, rows = law_on("ifma-hsm", "desired_torque_adaptive", tmp_path)
    every = [ticks for _, _, ticks in stepper.one.tasks]
    assert every[-1] == 1
    assert max(every) > 1
    hold_step_by_step(stepper, rows)


@needs_gcc
@pytest.mark.full("okuma-pm600-*", "ifma-hsm-*")
@pytest.mark.parametrize("kind", OBSERVERS)
@pytest.mark.parametrize("name", MACHINES)
def test_every_observer_in_c_steps_with_the_bits_of_one_lane_over_missing_samples_too(name, kind, tmp_path):
    machine = gk.load_machine(name)
    observer = observer_of({"kind": kind, "bandwidth": "20 Hz"}).on(machine, PERIOD)
    one = observer_stepped("m_observer", observer, machine.home)
    row, u0 = tick.rest_row(machine, machine.home), machine.at_rest(machine.home)[1]
    rows = step_rows(one, flatten(row), np.ravel(row.q), u0, TICKS)
    assert any(values[-1][0] == 0 for values, _, _ in rows)
    hold_step_by_step(Stepper(tmp_path, one), rows)


@needs_gcc
def test_inputs_that_are_no_numbers_and_results_that_would_be_none_change_nothing(tmp_path):
    stepper, rows = law_on("nist-octahedral", "pid", tmp_path)
    for values, expected, _ in rows[:10]:
        for place in range(3):
            for wrong in (np.nan, np.inf):
                bad = [v.copy() for v in values]
                bad[place][2] = wrong
                before = stepper.state.raw
                status, found = stepper.step(bad)
                assert status == NOT_FINITE
                assert (found == -7.0).all()
                assert stepper.state.raw == before
        huge = [values[0], np.full_like(values[1], 1e308), values[2]]
        status, found = stepper.step(huge)
        assert status == NO_NUMBER
        assert (found == -7.0).all()
        status, found = stepper.step(values)
        assert status == OK
        assert np.array_equal(found, expected)  # as if nothing had been asked in between


@needs_gcc
@pytest.mark.full
def test_a_reading_that_is_no_number_is_to_an_observer_a_sample_that_is_missing(tmp_path):
    machine = gk.load_machine("ifma-hsm")
    observer = observer_of({"kind": "disturbance", "bandwidth": "20 Hz"}).on(machine, PERIOD)
    one = observer_stepped("m_observer", observer, machine.home)
    stepper, (state, tape) = Stepper(tmp_path, one), (flatten(one.state), one.tasks[0][1])
    q, u = machine.inverse_kinematics(machine.home), machine.at_rest(machine.home)[1]
    bad = q.copy()
    bad[1] = np.nan
    for k in range(12):
        missing = k % 4 == 2
        status, found = stepper.step([bad if missing else q, u, np.ones(1)])
        zero = np.zeros(3)
        expected, state = tape.replay(np.zeros(0), state, zero if missing else q, zero if missing else u, [not missing])
        assert status == (NOT_FINITE if missing else OK)
        assert np.array_equal(found, expected)


def test_a_law_in_plain_python_is_refused():
    class Own(Controller):
        symbolic: ClassVar = False

        def init(self, r0, u0):
            return None

        def step(self, state, r, y, theta):
            return None

    with pytest.raises(ExperimentError, match=r"a law whose step is plain Python cannot be exported, got Own;"):
        law_stepped("m_own", Own(period=1e-3), None, None)
