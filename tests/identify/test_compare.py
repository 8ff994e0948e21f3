"""Laws of friction held against one another: the one that was planted is told, and of equals the simpler one."""

from __future__ import annotations

import numpy as np
import pytest

import gough as gk
from gough.errors import ExperimentError
from gough.identify.compare import best, compare, text
from gough.identify.rows import rows_of_motion

PLANTED = {
    "coulomb, viscous": lambda v: 20 * np.sign(v) + 200 * v,
    "offset": lambda v: 20 * np.sign(v) + 200 * v - 3,
    "asymmetric": lambda v: 20 * np.sign(v) + 200 * v - 3 + 30 * np.abs(v),
    "stribeck": lambda v: 20 * np.sign(v) * (1 + 0.4 * np.exp(-((v / 0.02) ** 2))) + 200 * v - 3,
}


@pytest.fixture(scope="module")
def motion():
    """30 s of an axis that turns back some twenty times, and its machine."""
    t = np.arange(0, 30, 0.005)[:, None]
    x = 0.15 + 0.1 * np.sin(2 * t) * np.cos(0.3 * t)
    xd = np.gradient(x[:, 0], 0.005)[:, None]
    return gk.load_machine("emps"), x, xd, np.gradient(xd[:, 0], 0.005)[:, None]


def planted(motion, law, noise=1.0):
    machine, x, xd, xdd = motion
    u = 95 * xdd + PLANTED[law](xd) + noise * np.random.default_rng(0).normal(size=x.shape)
    return compare(rows_of_motion(machine, x, xd, xdd, u))


@pytest.mark.quick("stribeck", "coulomb, viscous")
@pytest.mark.parametrize("law", PLANTED)
def test_the_law_that_was_planted_is_the_one_that_is_told(motion, law):
    compared = planted(motion, law)
    assert best(compared).law == law
    # 1 N of noise is what is left, and nothing that a law could have explained
    assert best(compared).found.held_out_rms == pytest.approx(1.0, abs=0.05)
    (line,) = (line for line in text(compared).split("\n") if line.endswith("*"))
    assert line.startswith(law)


def test_planted_numbers_come_back_with_the_law(motion):
    found = planted(motion, "asymmetric", noise=1e-6)[2].to_json()
    values = {p["name"]: p["value"] for p in found["parameters"]}
    assert values == pytest.approx(
        {"carriage.m": 95, "friction.coulomb[0]": 20, "friction.viscous[0]": 200, "friction.offset[0]": -3,
         "friction.asymmetric[0]": 30}, rel=1e-5,
    )  # fmt: skip


def test_the_speed_of_the_rise_at_rest_is_the_nearest_that_is_tried(motion):
    """0.02 m/s was planted; those tried are a factor of 1.7 apart."""
    assert 0.02 / 1.8 < planted(motion, "stribeck")[3].v_s[0] < 0.02 * 1.8


def test_rows_without_columns_of_friction_are_refused(motion):
    machine, x, xd, xdd = motion
    with pytest.raises(ExperimentError, match="compared on rows with Coulomb and viscous friction of every joint"):
        compare(rows_of_motion(machine, x, xd, xdd, 95 * xdd, friction=()))
