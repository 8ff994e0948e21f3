"""Laws around a law in experiment files, on the command line, and beside shapers."""

from __future__ import annotations

import pytest

from gough.errors import ExperimentError, InputError
from gough.experiment import load_experiment
from gough.experiment.parts import controller_of

FILE = """
schema = "gough-experiment-1"

[machine]
use = "ifma-hsm"

[plant]
flexible = true

[program]
kind             = "line"
to               = { unit = "mm", value = [-10, 20, 10] }
feed             = "0.2 m/s"
shaper           = "zvd"
shaper_frequency = "45 Hz"
shaper_damping   = 0.02

[[controller]]
kind  = "gravity_compensation"
where = "target"
target = ["-10 mm", "1220 mm", "10 mm"]
law   = { kind = "pid", bandwidth = "4 Hz" }

[[controller]]
kind = "flexible_feedforward"
law  = { kind = "computed_torque", bandwidth = "4 Hz" }
"""


def test_a_law_inside_a_law_is_read_from_a_file_and_written_back(tmp_path):
    path = tmp_path / "one.toml"
    path.write_text(FILE)
    one = load_experiment(path)
    assert [c.kind for c in one.controllers] == ["gravity_compensation", "flexible_feedforward"]
    assert one.controllers[0].law.law.bandwidth == 4.0
    assert one.program.shaping().delay == pytest.approx(1 / 45 / (1 - 0.02**2) ** 0.5)
    for found in one.controllers:
        again = controller_of({"kind": found.kind, **found.law.to_file()}).law
        assert again == found.law


@pytest.mark.parametrize(
    ("law", "text"),
    [
        ({"kind": "pid"}, "law.bandwidth: is missing"),
        ({"kind": "pidd", "bandwidth": "4 Hz"}, "law.kind: no such controller, got 'pidd'; did you mean pid"),
        ({"kind": "pid", "bandwidth": "4 mm"}, "law.bandwidth: "),
        ("pid", "law: must be a table"),
    ],
)
def test_what_is_wrong_inside_is_said_with_its_key(law, text):
    with pytest.raises(InputError, match=text):
        controller_of({"kind": "gravity_compensation", "law": law})


def test_a_wrapper_without_a_law_is_refused():
    with pytest.raises(ExperimentError, match="law: is missing"):
        controller_of({"kind": "flexible_feedforward"})
