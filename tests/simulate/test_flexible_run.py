"""Runs on plants that give way: the true tool, the law that knows nothing of it, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

import gough as gk
from gough.errors import ExperimentError
from gough.simulate.loop import closed_loop
from gough.simulate.stability import choose_substeps, fastest_pole


@pytest.fixture(scope="module")
def nist():
    """Encoders without steps, so that what is small is seen."""
    return gk.load_machine("nist-octahedral").with_perfect_drives()


@pytest.fixture(scope="module")
def slick(nist):
    return nist.frictionless()


LAW = gk.PID(bandwidth=4.0)
STAND = gk.Line(to=[0.001, 0, 0], feed=0.001)  # 1 mm in a second


def run(machine, program=STAND, law=LAW, **plant):
    found = gk.Plant(machine=machine, **plant)
    return gk.simulate(machine, law, program, plant=found, strict=True)


@pytest.mark.full
def test_a_run_starts_at_rest_under_gravity_and_the_tool_hangs_by_what_gives_way(slick):
    log = run(slick, flexible=True).dataset
    sag = slick.flexible().settled_pose(slick.home) - slick.home
    assert_allclose(log.x.values[0], sag, atol=1e-15)
    assert np.abs(sag[2]) > 1e-5
    assert_allclose(log.q.values[0], slick.inverse_kinematics(slick.home), atol=1e-14)
    assert np.abs(log.xd.values[0]).max() == 0
    # contour error is of the true tip: the line lies across the sag
    assert_allclose(log.contour_error.values[0], np.linalg.norm(sag[1:3]), rtol=1e-3)


@pytest.mark.full
def test_a_steady_wrench_moves_the_tool_by_its_static_compliance_while_the_motors_hold(slick):
    wrench = np.array([300.0, -200.0, 100.0, 20.0, 10.0, -30.0])
    bare, pushed = (run(slick, flexible=True, wrench=w).dataset for w in (np.zeros(6), wrench))
    C = slick.flexible().tool_compliance(slick.home)
    moved = (pushed.x.values - bare.x.values)[0]
    assert_allclose(moved, C @ wrench, rtol=1e-3, atol=1e-3 * np.abs(C @ wrench).max())


@pytest.mark.full
def test_the_stiffer_the_springs_the_nearer_the_run_is_to_the_rigid_one(slick):
    """Differences fall as 1 / stiffness: springs without end are the rigid machine."""
    circle = gk.Circle(radius=0.05, feed=0.1)
    rigid = run(slick, circle).dataset.x.values
    off = []
    for stiffness in (30.0, 300.0):
        # substeps of the plant follow from its pole; the law sees the same samples
        soft = run(slick, circle, flexible=True, stiffness=stiffness).dataset.x.values
        off.append(np.abs(soft - rigid)[:, :3].max())
    assert off[1] < 2e-7
    assert 7 < off[0] / off[1] < 13


@pytest.mark.full
def test_the_step_that_is_chosen_is_exact_to_nanometres():
    """RK4 at a third of its stability limit, against steps a quarter as long, on the stiffest machine with the law."""
    m = gk.load_machine("ifma-hsm").with_perfect_drives()
    circle, law = gk.Circle(radius=0.02, feed=0.2), gk.PID(bandwidth=3.0)
    plant = gk.Plant(machine=m, flexible=True)
    chosen = choose_substeps(m.flexible(), 1e-3)
    assert chosen == 8
    x = [gk.simulate(m, law, circle, plant=plant, substeps=n).dataset.x.values for n in (chosen, 4 * chosen)]
    assert np.abs(x[0] - x[1]).max() < 5e-9  # of some 0.5 mm of contour error


@pytest.mark.full
def test_steps_that_cannot_follow_the_springs_are_refused():
    m = gk.load_machine("ifma-hsm")
    assert 7000 < fastest_pole(m.flexible()) < 7500  # sqrt(1.2e9 N/m / 40 kg) and the links' share
    with pytest.raises(ExperimentError, match="2 sub-steps of 0.5 ms cannot follow the plant's fastest pole"):
        choose_substeps(m.flexible(), 1e-3, 2)
    with pytest.raises(ExperimentError, match="asks for more sub-steps than a run takes"):
        choose_substeps(m.flexible(stiffness=1e6), 1e-3)


@pytest.mark.full
def test_encoders_at_the_joints_let_the_law_take_the_sag_away(slick):
    at_joint = run(slick, flexible=True, measured="joint").dataset
    at_motor = run(slick, flexible=True).dataset
    assert_allclose(at_joint.x.values[0], slick.home, atol=1e-12)
    assert np.abs(at_joint.x.values[-1, 2]) < 1e-7 < 1e-5 < np.abs(at_motor.x.values[-1, 2])
    # the log's q are the motors; what the encoders read is q_m
    assert_allclose(at_joint.q_m.values[0], slick.inverse_kinematics(slick.home), atol=1e-12)
    assert np.abs(at_joint.q.values[0] - at_joint.q_m.values[0]).max() > 1e-6


@pytest.mark.full
def test_the_loop_on_a_flexible_plant_follows_its_reference_at_rest_and_tells_its_stability(slick):
    space = closed_loop(slick.flexible(), LAW, 1e-3, 4)
    still = space.C @ np.linalg.solve(np.eye(len(space.A)) - space.A, space.B)
    # where the motors go the tool goes, but for the little that gravity bends more or less there
    assert_allclose(still, np.eye(6), atol=2e-3)
    assert np.abs(np.linalg.eigvals(space.A)).max() <= 1 + 1e-9
    # the model-based law of the rigid machine is too quick for these springs, and the run says so
    with pytest.raises(ExperimentError, match="unstable on nist-octahedral"):
        run(slick, law=gk.ComputedTorque(poles=[100, 100, 200]), flexible=True)


@pytest.mark.full
@pytest.mark.parametrize("name", ["eth-hexaglide", "ccu-3prs", "okuma-pm600"])
def test_every_kind_with_friction_and_payload_runs_as_a_flexible_plant(name):
    m = gk.load_machine(name)
    log = run(m, gk.Line(to=[0, 0, 0.002], feed=0.01), flexible=True, payload=5.0)
    assert log.dataset.status == "done"
    sag = log.dataset.x.values[0] - log.dataset.x_r.values[0]
    assert 1e-7 < np.abs(sag[:3]).max() < 1e-4


@pytest.mark.full
def test_friction_that_scales_with_forces_in_the_joints_goes_on_doing_so_on_springs(nist):
    circle = gk.Circle(radius=0.05, feed=0.1)
    rigid, soft = (run(nist, circle, flexible=f) for f in (False, True))
    assert soft.dataset.status == "done"
    # the same glitches at the reversals, within what the springs add
    found = [log.info["metrics"]["contour_error"]["max"] for log in (rigid, soft)]
    assert 0.5 < found[1] / found[0] < 2


@pytest.mark.full
def test_plants_of_a_batch_may_differ_in_stiffness(slick):
    plants = [gk.Plant(machine=slick, flexible=True, stiffness=s) for s in (1.0, 0.5, 1.0)]
    log = gk.simulate(slick, LAW, STAND, plant=plants).dataset
    sag = log.x.values[0][:, 2]
    assert_allclose(sag[1] / sag[0], 2, rtol=1e-3)
    assert (log.x.values[:, 0] == log.x.values[:, 2]).all()


def test_what_does_not_go_together_is_refused(nist):
    with pytest.raises(ExperimentError) as caught:
        gk.Plant(machine=nist, stiffness=2.0)
    assert str(caught.value) == "stiffness: is for flexible machines; write flexible = true beside it"
    with pytest.raises(ExperimentError) as caught:
        gk.Plant(machine=nist.replace(compliance=None), flexible=True)
    assert str(caught.value).startswith("flexible: nist-octahedral has no [[compliance]]: nothing in it gives way;")
    with pytest.raises(ExperimentError) as caught:
        gk.simulate(nist.flexible(), LAW, STAND)
    assert str(caught.value) == (
        "machine: laws believe the rigid machine, got a flexible nist-octahedral; give machine.rigid, and "
        "plant=gk.Plant(machine=machine.rigid, flexible=True)"
    )
    with pytest.raises(ExperimentError, match="give gk.Plant"):
        gk.simulate(nist, LAW, STAND, plant=nist.flexible())


@pytest.mark.full
def test_forces_in_the_joints_are_refused_by_name(nist):
    with pytest.raises(ExperimentError) as caught:
        gk.simulate(nist, LAW, STAND, plant=gk.Plant(machine=nist, flexible=True), signals=["x", "plant.reaction"])
    assert str(caught.value) == (
        "run.signals.1: a flexible plant does not tell the forces in its joints, got plant.reaction; ask a plant "
        "without flexible = true"
    )


@pytest.mark.full
def test_the_record_of_a_run_repeats_its_plant(slick):
    log = run(slick, flexible=True, stiffness=0.8, measured="motor")
    again = gk.Plant.from_file({**log.info["plant"], "machine": slick})
    assert again == gk.Plant(machine=slick, flexible=True, stiffness=0.8, measured="motor")
    from gough.machine.sheet import machine_class

    assert machine_class("hexapod").from_file(log.info["plant"]["machine"]) == slick


@pytest.mark.full
def test_observers_and_supervision_of_the_rigid_machine_go_on_beside_a_flexible_plant(slick):
    """An observer's wrench is that of the load; the encoders' check flags nothing; the trip knows its errors."""
    push = np.array([0, 0, -400.0, 0, 0, 0])
    plant = gk.Plant(machine=slick, flexible=True, wrench=push)
    log = gk.simulate(
        slick, LAW, gk.Line(to=[0.02, 0, 0], feed=0.02), plant=plant, observer=gk.DisturbanceObserver(bandwidth=5.0),
        encoder_check=5e3, stop_ramp=2.0, ferror=2e-3,
    )  # fmt: skip
    assert log.status == "done" and not log["encoder_flag"].any()
    # without friction nothing hides it; the observer believes the tool where the motors are, 1e-5 m off: 1e-5 of 9 kN
    assert abs(np.median(log["wrench_hat"][-200:, 2]) + 400) < 1
