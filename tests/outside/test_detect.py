"""RELIABILITY L3: what readings and forces alone betray of their sensors."""

from __future__ import annotations

import numpy as np
import pytest

from outside.conftest import MAP, circle

MANY = MAP + '[gaps]\nmost = "50 %"\n'


@pytest.fixture(scope="module")
def slow(okuma):
    """6 s of a circle of 100 mm at 50 mm/s: the struts move slowly enough for the weight to tell."""
    return circle(okuma, 6000, 0.1, 0.1)


def told(found):
    return [str(one) for one in found.findings.kept]


def test_a_sound_record_is_told_nothing_of(record, slow):
    found, _, _ = record(slow.table)
    assert told(found) == []


def test_a_stuck_encoder_is_told_with_its_time(record, okuma):
    rows = circle(okuma, 3000, 0.05, 2.0)
    table = rows.table.copy()
    table[1000:1400, 3] = table[999, 3]
    found, _, _ = record(table)
    (finding,) = (f for f in found.findings.kept if f.kind == "frozen")
    assert finding.rule == "strut 3: the reading stands while others move"
    assert finding.start == pytest.approx(0.999, abs=2e-3) and finding.end == pytest.approx(1.399, abs=2e-3)


def test_a_machine_at_rest_has_no_stuck_encoder(record, okuma):
    rows = circle(okuma, 3000, 0.05, 0.0)
    found, _, _ = record(rows.table)
    assert told(found) == []


def test_a_jump_is_told_with_its_joint(record, slow):
    table = slow.table.copy()
    table[3000, 4] += 20.0
    found, _, _ = record(table)
    assert told(found) == [
        "strut 4: the reading jumps farther than the joint can move, t = 3 s to 3.001 s, 2 samples",
    ]


def test_a_counter_that_ran_over_is_told_as_that(record, slow):
    table = slow.table.copy()
    table[3000:, 1] -= 2**16 * 1e-3  # counts of 1 um, in mm
    found, _, _ = record(table)
    assert told(found)[0] == "strut 1: the counter of 16 bits ran over, t = 3 s"


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda u: -u, "all forces have the other sign, to judge by the weight"),
        (lambda u: u * [1, 1, -1, 1, 1, 1], "strut 3: the force has the other sign, to judge by the weight"),
        (lambda u: u[:, [0, 1, 4, 3, 2, 5]], "strut 3 and strut 5: forces interchanged, to judge by the weight"),
    ],
)
def test_forces_that_cannot_hold_the_weight_are_told(record, okuma, change, message):
    """Tilted, so that the struts carry forces that differ."""
    n = 6000
    t = np.arange(n) * 1e-3
    tilted = okuma.home + [0.1, 0.05, 0, 0.2, -0.1, 0]
    x = np.tile(tilted, (n, 1)) + 1e-3 * np.sin(t)[:, None] * np.eye(6)[0]
    q, u = okuma.inverse_kinematics(x), okuma.inverse_dynamics(x, np.zeros((n, 6)), np.zeros((n, 6)))
    table = np.column_stack([t, q * 1e3, change(u)])
    found, _, _ = record(table)
    assert told(found) == [message]
