"""RELIABILITY.md, rows P1 to P5, as a person meets them: in a file."""

from __future__ import annotations

import pytest

from sample_files import EXPERIMENT, SHEET

FRICTION = '[friction]\nkind = "stribeck"\n'
INERTIA = "[[5, 0, 0], [0, 5, 0], [0, 0, 6]]"

ROWS = {
    "P1 a mass of zero": (SHEET, {'"120 kg"': '"0 kg"'}, "6: platform.mass: must be above 0 kg, got '0 kg'"),
    "P1 a negative mass": (SHEET, {'"120 kg"': '"-1 kg"'}, "6: platform.mass: must be above 0 kg, got '-1 kg'"),
    "P2 not symmetric": (
        SHEET,
        {INERTIA: "[[5, 1, 0], [0, 5, 0], [0, 0, 6]]"},
        "5: platform: inertia must be symmetric, got [[5.0, 1.0, 0.0], [0.0, 5.0, 0.0], [0.0, 0.0, 6.0]]; "
        "give Ixy = Iyx and so on",
    ),
    "P2 not positive definite": (
        SHEET,
        {INERTIA: "[[5, 0, 0], [0, -5, 0], [0, 0, 6]]"},
        "5: platform: inertia must be positive definite, got principal moments -5, 5, 6 kg m2",
    ),
    "P2 against the triangle inequality": (
        SHEET,
        {INERTIA: "[[1, 0, 0], [0, 1, 0], [0, 0, 5]]"},
        "5: platform: inertia",
    ),
    "P3 a negative gain": (
        EXPERIMENT,
        {'kind = "pid"': 'kind = "pid"\nderivative = "-1 s"'},
        "13: controller.0.derivative: must be at least 0 s, got '-1 s'",
    ),
    "P3 a bandwidth of zero": (
        EXPERIMENT,
        {'kind = "pid"\nbandwidth = "10 Hz"': 'kind = "pid"\nbandwidth = "0 Hz"'},
        "13: controller.0.bandwidth: must be above 0 Hz, got '0 Hz'",
    ),
    "P4 negative friction": (
        SHEET,
        {"[drive]": FRICTION + 'coulomb = "-1 N"\n[drive]'},
        "22: friction.coulomb: must be at least 0 N, got '-1 N'",
    ),
    "P4 breakaway below Coulomb": (
        SHEET,
        {"[drive]": FRICTION + 'coulomb = "10 N"\nstatic = "5 N"\nstribeck = "1 mm/s"\n[drive]'},
        "20: friction: static friction must be at least the Coulomb friction, got 5.0 N against 10.0 N",
    ),
    "P4 a period of zero": (EXPERIMENT, {'"1 ms"': '"0 ms"'}, "20: run.period: must be above 0 s, got '0 ms'"),
    "P4 a negative period": (EXPERIMENT, {'"1 ms"': '"-1 ms"'}, "20: run.period: must be above 0 s, got '-1 ms'"),
    "P4 half a sample of delay": (
        SHEET,
        {'lead = "20 mm"': 'lead = "20 mm"\ndelay = 0.5'},
        "22: drive.delay: must be 0 or 1 samples, got 0.5",
    ),
    "P4 a shortest strut above the longest": (
        SHEET,
        {'["0.70 m", "1.15 m"]': '["1.15 m", "0.70 m"]'},
        "24: limits.length: the shortest must be below the longest, got [1.15, 0.7] m",
    ),
    "K7 millimetres for metres": (
        SHEET,
        {"-0.1455, 0.6847, 1.0": "-145.5, 684.7, 1000.0"},
        "11: joints.base: base joints span a strange distance, got 999 m; did you mean mm?",
    ),
}


@pytest.mark.parametrize("text, changes, expected", ROWS.values(), ids=ROWS)
def test_a_number_without_physical_sense_is_refused_with_its_line(complaints, text, changes, expected):
    (line,) = complaints(text, changes)
    assert line.startswith(expected)


@pytest.mark.full
def test_p5_a_loop_that_grows_is_a_warning_with_its_number_and_with_strict_an_error(gough, write):
    """60 Hz in the position loop asks for a speed loop beyond what 1 ms can sample."""
    write("f.toml", EXPERIMENT, {'kind = "pid"\nbandwidth = "10 Hz"': 'kind = "pid"\nbandwidth = "60 Hz"'})
    ended = gough("check", "f.toml")
    assert ended.status == 0
    grows = "pid: the loop at a period of 1 ms is unstable on nist-octahedral"
    assert ended.err.startswith(f"warning: {grows}: spectral radius ")
    ended = gough("run", "f.toml", "--strict", "--controller", "pid")
    assert ended.status == 2
    assert f"f.toml:11: controller.0: {grows}, got spectral radius " in ended.err
    assert ended.err.rstrip().endswith("; lower the bandwidth or shorten the period")


def test_p5_sub_steps_too_few_for_the_friction_are_refused_with_how_many_are_enough(gough, write):
    """300 N rising within 0.01 mm/s on some 400 kg is a pole near 75 000 1/s; RK4 needs pole x step < 2.785."""
    friction = '[machine.friction]\nkind = "stribeck"\ncoulomb = "300 N"\nsmoothing = "0.01 mm/s"\n[program]'
    write("f.toml", EXPERIMENT, {"[program]": friction, 'period = "1 ms"': 'period = "1 ms"\nsubsteps = 1'})
    ended = gough("check", "f.toml")
    assert ended.status == 2
    expected = "f.toml:25: run.substeps: 1 sub-steps of 1 ms cannot follow the plant's fastest pole, got "
    assert ended.err.startswith(expected)
    assert "; give at least " in ended.err
