"""Runs of the 3-PRS: laws, logs, closure, forces in the joints, faults, batches, the command line."""

from __future__ import annotations

from functools import lru_cache

import casadi as ca
import numpy as np
import pytest
from numpy.testing import assert_allclose

import gough as gk
from gough.simulate import tick
from gough.simulate.faults import EncoderFault

ccu = lru_cache(lambda: gk.load_machine("ccu-3prs"))
CIRCLE = gk.Circle(radius=0.05, feed=0.3)


@pytest.fixture(scope="module")
def log():
    signals = ["x_r", "x", "xd_r", "xd", "q", "u", "contour_error", "plant.reaction", "plant.multiplier"]
    return gk.simulate(ccu(), gk.ComputedTorque(bandwidth=12.0), CIRCLE, signals=signals)


def test_the_log_has_three_task_coordinates_and_their_rates(log):
    data = log.dataset
    assert data.attrs["status"] == "done"
    assert data["x"].shape[1] == data["xd"].shape[1] == 3 and data["x"].dims[1] == "task"
    rate = np.gradient(log["x"], log.t, axis=0)
    assert_allclose(log["xd"][1:-1], rate[1:-1], rtol=0, atol=5e-3)  # T^2 / 6 of x'''; the forces jump every sample


def test_the_logged_tip_is_where_the_sliders_put_it(log):
    assert_allclose(ccu().forward_kinematics(log["q"][::50], near=log["x"][::50]), log["x"][::50], rtol=0, atol=1e-12)


def test_logged_joint_forces_are_those_of_the_motion_under_the_logged_drives(log):
    k = np.arange(0, len(log.t), 40)
    x, xd, u = (log[name][k] for name in ("x", "xd", "u"))
    wanted = ccu().reactions(x, xd, ccu().forward_dynamics(x, xd, u))
    assert log.dataset["plant.multiplier"].attrs["units"] == "N"
    assert_allclose(log["plant.reaction"][k], wanted.platform_joint, rtol=0, atol=1e-8)
    assert_allclose(log["plant.multiplier"][k], wanted.multiplier, rtol=0, atol=1e-8)


@pytest.mark.full
def test_an_offset_is_where_the_tool_starts():
    plant = gk.Plant(machine=ccu(), offset=[1e-4, 0.0, -2e-4])
    log = gk.simulate(ccu(), gk.PID(bandwidth=10.0), gk.Circle(radius=0.02, feed=0.1), plant=plant)
    assert_allclose((log["x"] - log["x_r"])[0], [1e-4, 0, -2e-4], rtol=0, atol=1e-15)


def closure_of(z):
    m = ccu()
    p, theta, zs, _, _ = tick.symbols_of(m)
    phi = ca.Function("phi", [theta, zs], [m.closure_of(p, zs)])
    return np.array(phi.map(len(z))(m.theta, z.T))


def rows_of(law, program, every):
    """z of a run at every so many samples, straight from the kernel."""
    from gough import kernel as kernels
    from gough.simulate import start

    m, period = ccu(), 1e-3
    law, motion = law.on(m, period), program.plan(m)
    first = motion.sample(0, 1, period)
    row = type(first)(*(column[0] for column in first))
    begin = start.at_rest(m, m, law, gk.Plant(machine=m), row)
    schedule = tick.build(m, law, begin.law, row, period, 4)
    kernel = kernels.compile(schedule)
    numbers = {"theta_plant": m.theta, "theta_law": law.theta, "wrench": np.zeros(6)}
    simulation = kernel.start(numbers, tick.first_states(schedule, begin.z, begin.law, begin.u))
    found, ticks = [], motion.count(period)
    for k in range(0, ticks, 2048):
        n = min(2048, ticks - k)
        table = np.concatenate(motion.sample(k, k + n, period), axis=1)
        out = simulation.advance(n, {"reference": table})[:, 0]
        found.append(out[::every, kernel.columns["z"]])
    return np.concatenate(found), ticks * period


@pytest.mark.full
def test_the_loops_stay_closed_to_a_picometre_over_60_seconds():
    """At 0.3 m/s; drift is what the projection leaves of each sub-step, not what 240 000 of them add up."""
    z, simulated = rows_of(gk.EquivalentError(), gk.Circle(radius=0.05, feed=0.3, turns=58), 37)
    assert simulated > 60
    assert np.abs(closure_of(z)).max() < 1e-12


def test_the_loops_stay_closed_through_a_second_of_hard_corners():
    z, _ = rows_of(gk.PID(bandwidth=12.0), gk.Circle(radius=0.02, feed=0.3, acceleration=20.0, turns=2), 1)
    assert np.abs(closure_of(z)).max() < 1e-14


@pytest.mark.full
def test_plants_side_by_side_are_the_single_runs():
    plants = [ccu().replace(**{"platform.mass": mass}) for mass in (40.0, 50.0)]
    short = gk.Circle(radius=0.02, feed=0.2)
    batch = gk.simulate(ccu(), gk.EquivalentError(), short, plant=plants)
    for i, plant in enumerate(plants):
        one = gk.simulate(ccu(), gk.EquivalentError(), short, plant=plant)
        assert_allclose(batch.run(i)["x"], one["x"], rtol=0, atol=1e-10)


@pytest.mark.full
def test_a_wrong_encoder_is_flagged_and_the_tool_brakes_along_its_path():
    fault = EncoderFault(kind="stuck", joint=2, start=0.5)
    plant = gk.Plant(machine=ccu(), faults=[fault])
    log = gk.simulate(ccu(), gk.PID(bandwidth=12.0), CIRCLE, plant=plant, encoder_check=50.0, stop_ramp=5.0)
    assert log.dataset.attrs["status"] == "failed" and "slider 2" in log.dataset.attrs["reason"]
    assert log["contour_error"].max() < 1e-3


def test_a_linearised_tripod_answers_as_its_mass_says():
    A, B, C, D = gk.linearize(ccu(), ccu().home)
    assert A.shape == (6, 6) and B.shape == (6, 3) and C.shape == (3, 6)
    M = ccu().mass_matrix(ccu().home)
    J = ccu().jacobian(ccu().home)
    assert_allclose(C[:, :3] @ B[3:], np.linalg.solve(M, J.T), rtol=1e-9, atol=1e-15)


@pytest.mark.full
def test_the_command_line_shows_checks_and_runs_it(gough, write):
    assert "ccu-3prs" in gough("machines").out
    assert "spherical joints" in gough("show", "ccu-3prs").out
    write(
        "run.toml",
        """
        schema = "gough-experiment-1"
        [machine]
        use = "ccu-3prs"
        [plant]
        "platform.mass" = "1.1 x"
        [program]
        kind = "circle"
        radius = "30 mm"
        feed = "6 m/min"
        [[controller]]
        kind = "equivalent_error"
        strength = 260
        """,
    )
    checked = gough("check", "run.toml")
    assert checked.status == 0, checked.err
    ended = gough("run", "run.toml", "--json")
    assert ended.status == 0, ended.err
    assert ended.json["controllers"][0]["contour_error"]["max"] < 1e-4
