"""Runs of a hexaglide: both laws on the published circle, what a person reads, and how a run ends at a limit."""

from __future__ import annotations

import re
from functools import lru_cache
from pathlib import Path

import numpy as np
import pytest

import gough as gk
from gough.errors import ExperimentError, ProgramError, WorkspaceError
from gough.simulate import stability

eth = lru_cache(lambda: gk.load_machine("eth-hexaglide"))


@pytest.fixture(scope="module")
def logs():
    circle = gk.Circle(radius=0.015, feed=0.1)
    return {
        law.kind: gk.simulate(eth(), law, circle) for law in (gk.PID(bandwidth=10.0), gk.ComputedTorque(bandwidth=16.0))
    }


def test_both_laws_run_the_published_circle(logs):
    for kind, log in logs.items():
        assert log.dataset.attrs["status"] == "done" and np.isfinite(log["u"]).all(), kind
    assert gk.measure(logs["computed_torque"]).contour_error["max"] < gk.measure(logs["pid"]).contour_error["max"]
    # friction of up to 201 N a motor turns round at a reversal: against M_xx 5 w^2 = 36 N/um of 16 Hz some 10 um
    assert 5e-6 < gk.measure(logs["computed_torque"]).contour_error["max"] < 1e-4


@pytest.mark.full
def test_without_friction_computed_torque_leaves_what_the_sample_time_leaves():
    log = gk.simulate(eth().frictionless(), gk.ComputedTorque(bandwidth=16.0), gk.Circle(radius=0.015, feed=0.1))
    steady = (log.t > 0.3) & (log.t < log.t[-1] - 0.4)
    # a = 0.67 m/s2 turns by 6.7 mrad a sample and is held: 0.67 x 6.7e-3 / 2 / (5 w^2) = 0.04 um, and as much from the
    # speed, half a sample old; the encoder's steps of 0.1 um come on top
    assert log["contour_error"][steady].max() < 3e-7


def test_applied_forces_minus_friction_are_inverse_dynamics_of_the_motion(logs):
    """The plant against the equations of motion, by twist rates differenced from the log."""
    log = logs["computed_torque"]
    k = np.arange(200, len(log) - 300)
    Ts = log.t[1] - log.t[0]
    mean = (log["xd"][k + 1] - log["xd"][k]) / Ts
    middle = (log["x"][k] + log["x"][k + 1]) / 2, (log["xd"][k] + log["xd"][k + 1]) / 2
    wanted = eth().inverse_dynamics(*middle, mean)
    lost = (log["friction"][k] + log["friction"][k + 1]) / 2
    found = log["u"][k] - lost
    # friction changes by up to 100 N within a sample at a reversal: compared where it is steady, to what the middle of
    # a sample is off its mean: third derivatives of the motion, Ts^2 / 24 x 704 kg x 300 m/s4 = 0.01 N
    steady = np.abs(log["friction"][k + 1] - log["friction"][k]).max(1) < 0.5
    assert steady.sum() > 100
    assert np.abs(found - wanted)[steady].max() < 0.01  # N, of up to 500


def test_what_is_read_says_carriage(logs):
    log = logs["pid"]
    assert log.joint_names == [f"carriage {i}" for i in range(1, 7)] and log.joint_word == "carriage"
    assert "carriage force, peak" in repr(gk.measure(log)) and "strut" not in repr(gk.measure(log))
    axes = log.plot.forces()
    assert any(axes.get_title(loc=place).startswith("Carriage forces") for place in ("left", "center", "right"))


@pytest.mark.full
def test_the_page_says_carriage_and_nothing_of_struts(tmp_path, gough):
    Path("c.toml").write_text(
        'schema = "gough-experiment-1"\n[machine]\nuse = "eth-hexaglide"\n'
        '[program]\nkind = "circle"\nradius = "15 mm"\nfeed = "0.1 m/s"\n'
        '[[controller]]\nkind = "pid"\nbandwidth = "10 Hz"\n[run]\nperiod = "1 ms"\n'
    )
    ended = gough("run", "c.toml", "-o", "out")
    assert ended.status == 0
    assert "carriage force, peak" in ended.out and "strut" not in ended.out + ended.err
    page = Path("out/report.html").read_text()
    body = page[page.rindex("<body") :] if "<body" in page else page
    assert "Carriage forces" in body and "a carriage reverses its velocity" in body
    assert not re.findall(r"[^-_\w]strut[ s]", re.sub(r"<script.*?</script>", "", body, flags=re.S))
    assert gough("show", "eth-hexaglide").status == 0
    shown = gough("show", "eth-hexaglide").out
    assert re.search(r"drive\.force_limit +2\.5 kN", shown) and "strut" not in shown
    assert re.search(r"eth-hexaglide +hexaglide +ETH Hexaglide", gough("machines").out)
    ended = gough("export", "eth-hexaglide", "--target", "mjcf")
    assert ended.status == 0 and 'joint="carriage 6"' in ended.out and "strut" not in ended.out


def test_a_program_that_leaves_the_reach_of_the_legs_is_stopped_where_a_leg_stands_square(write, gough):
    part = write("far.ngc", "G21 G90 G94\nG1 X10 F3000\nG1 Z-500\nM2\n")
    ended = gough("check", part, "-m", "eth-hexaglide")
    assert ended.status == 1
    assert re.search(r"NC line 3: leg 1: nearly square across its rail, got 15 deg \(limit 15 deg\)", ended.err)


def test_a_program_whose_start_no_leg_reaches_names_leg_and_distance():
    with pytest.raises(WorkspaceError) as caught:
        gk.simulate(eth(), gk.PID(bandwidth=10.0), gk.Circle(radius=0.015, feed=0.1, origin=[0, 0, -0.5, 0, 0, 0]))
    assert re.match(r"t = 0 s.*: leg 1 cannot reach: misses by 115 mm, got 1.115\d* m from joint to rail \(limit 1 m\)",
                    str(caught.value))  # fmt: skip


def test_feeds_within_joint_limits_say_the_nc_line_a_leg_cannot_reach(write):
    part = gk.load_program(write("far.ngc", "G21 G90 G94\nG1 X10 F3000\nG1 Z-500\nM2\n"))
    part = part.replace(joint_limits=True)
    with pytest.raises(WorkspaceError, match=r"^NC line 3: leg \d cannot reach: misses by "):
        part.plan(eth())


def test_motors_at_their_limit_saturate_and_the_log_says_so():
    """PID asks for 1.7 kN at the start of the circle, and its mean is the weight, 397 N."""
    m = eth().replace(**{"drive.force_limit": 1000.0})
    log = gk.simulate(m, gk.PID(bandwidth=10.0), gk.Circle(radius=0.015, feed=0.1))
    assert np.abs(log["u"]).max() == 1000 and 0 < log["saturated"].mean() < 0.1


def test_substeps_are_chosen_from_the_fastest_pole_and_too_few_refused():
    m = eth()
    pole = stability.fastest_pole(m)
    # bristle damping 1.5e5 N s/m and viscous friction on the lightest direction, at least a carriage's 97.6 kg
    assert 100 < pole < 1.6e5 / 50
    assert stability.choose_substeps(m, 1e-3) >= 4
    with pytest.raises(ExperimentError, match="1 sub-steps of 1 ms cannot follow the plant's fastest pole"):
        stability.choose_substeps(m.replace(**{"friction.damping": 6e5}), 1e-3, 1)


def test_a_program_error_of_the_joints_names_what_is_missing():
    m = eth().replace(**{"limits.speed": None})
    with pytest.raises(ProgramError, match="joint_limits needs the speed limit of the machine's joints"):
        gk.Circle(radius=0.015, feed=0.1, joint_limits=True).plan(m)
