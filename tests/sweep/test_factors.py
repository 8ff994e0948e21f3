"""Factors and settings: names that are there, values that can be, and what a run becomes by them."""

from __future__ import annotations

import pickle
from pathlib import Path

import pytest

from gough.errors import ExperimentError
from gough.experiment import load_experiment
from gough.experiment.resolve import resolved
from gough.sweep.design import design_of
from gough.sweep.factors import factors_of
from gough.sweep.settings import Setter, put

VARY = '"controller.bandwidth" = ["10 Hz"]'


@pytest.mark.parametrize(
    ("vary", "told"),
    [
        ('"plant.friction.colomb" = [1]', "names nothing of this experiment; did you mean plant.friction.coulomb?"),
        ('"controler.bandwidth" = [1]', "names nothing of this experiment; did you mean controller.bandwidth?"),
        ('"controller.bandwith" = [1]', "names nothing of this experiment; did you mean controller.bandwidth?"),
        ('"program.feeed" = [1]', "names nothing of this experiment; did you mean program.feed?"),
        ('"run.signals" = [1]', "names nothing of this experiment; there is run.period, run.substeps,"),
        (
            '"controller.2.bandwidth" = [1]',
            "there is no such controller (limit 2 of them, counted from 0); did you mean controller.1.bandwidth?",
        ),
        ('"observer.bandwidth" = ["1 Hz"]', "the experiment has no [observer]; write that table, or drop this"),
        (
            '"plant.payload" = "normal(20, -1) kg"',
            "impossible distribution: the deviation must be above 0, got 'normal(20, -1) kg'",
        ),
        ('"plant.payload" = "uniform(-1, 2) kg"', "must be at least 0 kg, got"),
        ('"plant.payload" = ["1 kg", "-1 kg"]', "must be at least 0 kg, got '-1 kg'"),
        ('"plant.payload" = "uniform(1, 2) m"', "'1.5 m' is not a quantity in kg"),
        ('"plant.payload" = 3', "must be a list of values or a distribution, got 3"),
        ('"plant.payload" = []', "a list of 1 to 10000 values, got 0 of them"),
        ('"plant.payload" = ["1 kg", "1 kg"]', "stands twice in the list, got '1 kg'; keep one"),
        (
            '"controller.bandwidth" = ["9 Hz"], "controller.0.bandwidth" = ["8 Hz"]',
            "sets controller.0.bandwidth, which 'controller.bandwidth' sets already; keep one",
        ),
        ('"plant.payload" = "normal(1, 0.1) x"', "cannot be scaled: the file gives no number here"),
    ],
)
def test_what_cannot_be_varied_is_said_with_its_place(experiment, vary, told):
    with pytest.raises(ExperimentError) as caught:
        design_of(experiment(vary))
    problem = caught.value.problems[0]
    assert told in str(problem).partition("sweep.vary")[2] and problem.key.startswith("sweep.vary")
    assert Path(problem.file).read_text().splitlines()[problem.line - 1].startswith("vary")


@pytest.mark.parametrize(
    ("more", "told"),
    [
        ('method = "grid"', "a grid has lists alone"),
        ('method = "sobel"', "is none of the words allowed here"),
        ("runs = 0", "must be at least 1"),
        ('metric = "contour_error.mox"', "no such metric, got 'contour_error.mox'; did you mean contour_error.max?"),
        ("rums = 3", "no such key; did you mean runs?"),
    ],
)
def test_what_is_wrong_in_the_rest_of_the_table_is_said(experiment, more, told):
    with pytest.raises(ExperimentError) as caught:
        design_of(experiment('"plant.payload" = "uniform(1, 2) kg"', more))
    assert told in str(caught.value) and "part.toml" in str(caught.value)


def test_draws_without_a_distribution_are_refused(experiment):
    with pytest.raises(ExperimentError, match="counts the draws of distributions, and there is none"):
        design_of(experiment(VARY), runs=7)


def test_all_mistakes_are_told_at_once(experiment):
    with pytest.raises(ExperimentError) as caught:
        design_of(experiment('"plant.payloud" = [1], "controller.bandwith" = [2]', 'method = "sobel"'))
    assert len(caught.value.problems) == 3


@pytest.mark.parametrize(
    ("settings", "old", "new"),
    [
        ({"plant.friction.coulomb": "0.7 x"}, '"0.9 x"', '"0.7 x"'),
        ({"plant.payload": "20 kg"}, '"0.9 x"', '"0.9 x"\npayload = "20 kg"'),
        ({"controller.1.bandwidth": "12 Hz"}, 'torque"\nbandwidth = "10 Hz"', 'torque"\nbandwidth = "12 Hz"'),
        ({"controller.bandwidth": "12 Hz"}, 'bandwidth = "10 Hz"', 'bandwidth = "12 Hz"'),
        ({"controller.bandwidth": "1.2 x"}, 'bandwidth = "10 Hz"', 'bandwidth = "12 Hz"'),
        ({"program.radius": "30 mm"}, '"20 mm"', '"30 mm"'),
        ({"program.kind": "circle", "program.direction": "cw"}, "turns = 0.2", 'turns = 0.2\ndirection = "cw"'),
        ({"machine.platform.mass": "1.1 x"}, '"nist-octahedral"', '"nist-octahedral"\n"platform.mass" = "1.1 x"'),
        ({"machine.use": "gough-hexaglide"}, '"nist-octahedral"', '"gough-hexaglide"'),
        ({"run.seed": 7}, "[sweep]", "[run]\nseed = 7\n[sweep]"),
    ],
    ids=lambda value: str(value)[:40],
)
def test_a_setting_says_what_its_key_would_say_in_the_file(written, settings, old, new):
    if "hexaglide" in new:
        from gough.machine import sheet

        name = next(name for name in sheet.library() if "hexaglide" in name)
        settings, new = {"machine.use": name}, f'"{name}"'
    made = Setter(load_experiment(written(VARY)))(settings)
    other = load_experiment(written(VARY, name="other.toml", change=(old, new)))
    for part in ("machine", "plant", "program", "run", "observer"):
        assert getattr(made, part) == getattr(other, part), part
    assert [one.law for one in made.controllers] == [one.law for one in other.controllers]
    texts, others = resolved(made), resolved(other)
    assert texts.keys() == others.keys()
    assert load_experiment_of(texts, written) == load_experiment_of(others, written)


def load_experiment_of(texts, written):
    """The parts of a resolved experiment, read back."""
    folder = written(VARY, name="base.toml").parent
    for name, text in texts.items():
        (folder / name).write_text(text)
    found = load_experiment(folder / "experiment.toml")
    return found.machine, found.plant, found.program, found.run, [one.law for one in found.controllers]


def test_parts_that_no_setting_touches_stay_the_same_objects(experiment):
    base = experiment(VARY)
    setter = Setter(base)
    a, b = setter({"plant.payload": "1 kg"}), setter({"plant.payload": "2 kg", "controller.0.bandwidth": "9 Hz"})
    assert a.machine is b.machine is base.machine and a.program is b.program is base.program
    assert a.plant is not b.plant and a.controllers[1].law is b.controllers[1].law
    assert setter({"plant.payload": "1 kg"}).plant is a.plant


def test_a_setter_survives_its_way_to_another_process(experiment):
    setter = Setter(experiment(VARY))
    again = pickle.loads(pickle.dumps(setter))
    settings = {"plant.payload": "3 kg", "controller.bandwidth": "8 Hz"}
    assert again(settings).plant == setter(settings).plant


def test_several_names_of_one_key_get_one_value(experiment):
    key = "plant.friction.coulomb, plant.friction.static"
    (factor,) = factors_of({key: "uniform(0.9, 1.3) x"}, experiment(VARY))
    assert factor.settings("1.2 x") == {"plant.friction.coulomb": "1.2 x", "plant.friction.static": "1.2 x"}


def test_a_value_goes_where_the_table_has_its_key_however_it_is_spelled():
    assert put({"friction.coulomb": 1}, "friction.coulomb", 2, nested=False) == {"friction.coulomb": 2}
    assert put({"friction": {"coulomb": 1}}, "friction.coulomb", 2, nested=False) == {"friction": {"coulomb": 2}}
    assert put({}, "friction.coulomb", 2, nested=False) == {"friction.coulomb": 2}
    assert put({}, "law.bandwidth", 2, nested=True) == {"law": {"bandwidth": 2}}
    assert put({"faults": [{"joint": 1}]}, "faults.0.joint", 2, nested=True) == {"faults": [{"joint": 2}]}
    assert put({"friction.coulomb": 1}, "friction", 2, nested=False) == {"friction": 2}
