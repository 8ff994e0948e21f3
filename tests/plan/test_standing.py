"""What a machine is at home: gough.plan.standing against other ways to the same numbers."""

from __future__ import annotations

import numpy as np
import pytest

import gough as gk
from gough.machine.sheet import library
from gough.plan.standing import between, standing


@pytest.fixture(scope="module")
def okuma():
    return gk.load_machine("okuma-pm600")


def reordered(machine, *order):
    rows = machine.joints.platform[list(order)]
    return machine.replace(**{"joints.platform": rows, "limits.length": [0.01, 10.0], "limits.condition": 1e6})


@pytest.mark.parametrize("name", sorted(library()))
def test_no_machine_of_the_library_is_suspected(name):
    assert standing(gk.load_machine(name)).remarks == ()


def test_two_rows_exchanged_make_struts_that_cross_and_are_told(okuma):
    found = standing(reordered(okuma, 1, 0, 2, 3, 4, 5)).remarks
    assert len(found) == 1 and found[0].startswith("struts 1 and 2 cross at home; ")
    assert "are the rows of joints.base and joints.platform in one order?" in found[0]


def test_rows_that_begin_with_another_strut_are_told_with_the_order_that_is_better(okuma):
    found = standing(reordered(okuma, 1, 2, 3, 4, 5, 0)).remarks
    assert len(found) == 1 and found[0].startswith("with the platform joints in the order 6, 1, 2, 3, 4, 5 ")


def test_a_drive_that_cannot_hold_the_machine_is_told(okuma):
    weak = okuma.replace(**{"platform.mass": 60 * okuma.platform.mass})
    found = standing(weak)
    assert found.load > 1 and found.remarks[0].startswith("strut ") and "cannot hold the machine" in found.remarks[0]


def test_the_weight_of_a_symmetric_machine_is_shared_by_all_struts(okuma):
    """Of six alike struts without mass each takes m g / (6 cos), cos of the angle between strut and gravity."""
    bare = okuma.replace(strut=None, friction=None)
    lines = {line["name"]: np.array(line["points"]) for line in bare.drawing(np.asarray(bare.home))}
    s = np.diff(lines["strut 1"], axis=0)[0]
    weight = bare.platform.mass * abs(bare.gravity[2])
    force = weight / 6 / (abs(s[2]) / np.linalg.norm(s))
    limit = bare.drive.torque_limit * 2 * np.pi / bare.drive.lead
    assert standing(bare).load == pytest.approx(force / limit, rel=1e-8)  # places of the joints are told to 1e-9 m


def test_the_distance_of_two_lines_is_that_of_a_construction():
    """Along x at height 0 and along y at height h, meeting over (1, 2)."""
    a, b = np.array([0.0, 2, 0]), np.array([4.0, 2, 0])
    c, d = np.array([1.0, 0, 0.3]), np.array([1.0, 8, 0.3])
    apart, at = between(a, b, c, d)
    assert apart == pytest.approx(0.3) and at == pytest.approx((0.25, 0.25))
    apart, at = between(a, b, a + [0, 0, 0.3], b + [0, 0, 0.3])
    assert apart == pytest.approx(0.3) and at == (np.inf, np.inf)
