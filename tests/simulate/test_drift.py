"""Friction that drifts, and friction that is there or not: what the plant has and nobody tells the law."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import gough as gk
from gough.errors import ExperimentError
from gough.mechanics.friction import LuGre, Stribeck
from gough.mechanics.load_friction import LoadStribeck
from gough.simulate.drift import LEAST, levels, scale, scaled
from gough.simulate.faults import EncoderFault
from gough.simulate.stability import choose_substeps

SHORT = gk.Circle(radius=0.01, feed=0.05, settle=0.05)
LAW = gk.ComputedTorque(bandwidth=16.0)
PERIOD = 1e-3


@pytest.fixture(scope="module")
def nist():
    return gk.load_machine("nist-octahedral")


@pytest.fixture(scope="module")
def plain(nist):
    return gk.simulate(nist, LAW, SHORT)


def run(believed, plant, **options):
    return gk.simulate(believed, LAW, SHORT, plant=plant, **options)


# -- drift ----------------------------------------------------------------------------------------------------------


def test_what_drifts_are_the_levels_of_friction_and_nothing_else(nist):
    strut = ["friction.coulomb", "friction.static", "friction.viscous"]
    offsets = ["friction.coulomb_offset", "friction.viscous_offset"]
    assert levels(nist) == ["joints.friction.coefficient", *strut, *offsets]
    bare = nist.replace(**{"joints.friction": None})
    bristles = LuGre(coulomb=300.0, viscous=930.0, stiffness=1e9, damping=1e5)
    assert levels(bare.replace(friction=bristles)) == ["friction.coulomb", "friction.viscous"]
    assert levels(bare.replace(friction=None)) == []
    twice = scaled(nist, 2.0)
    names = np.array([name.partition("[")[0] for name in nist.names])
    changed = twice.theta != nist.theta
    assert set(names[changed]) == set(levels(nist)) - {"friction.coulomb_offset"}  # which is 0
    assert_array_equal(twice.theta[changed], 2 * nist.theta[changed])


@pytest.mark.full
def test_no_drift_changes_no_bit_also_beside_runs_that_drift(nist, plain):
    assert_array_equal(run(nist, gk.Plant(machine=nist, friction_drift=0.0))["x"], plain["x"])
    plants = [gk.Plant(machine=nist), gk.Plant(machine=nist, friction_drift=0.05)]
    mixed, alone = run(nist, plants), run(nist, plants[:1] * 2)
    assert_array_equal(mixed.run(0)["x"], alone.run(0)["x"])
    assert_array_equal(mixed.run(0)["u"], alone.run(0)["u"])
    assert_array_equal(run(nist, plants, lanes=1).run(1)["x"], run(nist, plants[1])["x"])


@pytest.mark.parametrize("rate", [0.5, -0.4])
def test_friction_at_t_is_that_of_the_sheet_times_one_plus_the_drift_times_t(nist, rate):
    """Without memory the log's friction is the law's at the log's speed; it is that of the sub-steps before."""
    law = Stribeck(coulomb=300.0, static=400.0, stribeck=2e-3, viscous=930.0, smoothing=1e-3)
    true = nist.replace(friction=law, **{"joints.friction": None})
    log = run(nist, gk.Plant(machine=true, friction_drift=rate))
    J = true.jacobian(log["x"])
    v = np.einsum("tij,tj->ti", J, log["xd"])
    curve = (300 + 100 * np.exp(-((v / 2e-3) ** 2))) * np.tanh(v / 1e-3) + 930 * v
    before = np.maximum(log["t"] - PERIOD, 0)
    # J again from the pose in abc instead of the quaternion: rounding, on speeds where friction is steep (4e5 N s/m)
    assert_allclose(log["friction"], (1 + rate * before)[:, None] * curve, rtol=1e-9, atol=1e-6)
    assert_allclose(log["plant.friction_scale"], 1 + rate * log["t"], rtol=1e-14)


@pytest.mark.full
def test_loads_that_scale_friction_and_friction_of_passive_joints_drift_too(nist):
    """Over 1.3 s at -90 % a second all of it is gone: what is left is the machine without any."""
    true = nist.replace(friction=LoadStribeck(coulomb=0.18, viscous=0.5, viscous_offset=94.0, smoothing=1e-3))
    gone = run(nist, gk.Plant(machine=true, friction_drift=-1.0))
    assert gone["plant.friction_scale"][-1] == LEAST
    late = gone["t"] > 1.05
    assert np.abs(gone["friction"][late]).max() < 1e-3 * 0.2 * 3000 + 1e-3 * (94 + 0.5 * 3000) * 0.05


def test_drift_that_has_come_as_far_as_another_sheet_is_that_sheet(nist):
    """After t s at d against a sheet 1 + d t times as much: friction is alike but for what d changes in a settling."""
    d, far = 1e-4, 0.5
    slow = run(nist, gk.Plant(machine=nist, friction_drift=d))
    there = run(nist, gk.Plant(machine=scaled(nist, 1 + d * far)))
    k = round(far / PERIOD)
    assert_allclose(slow["friction"][k], there["friction"][k], rtol=1e-4)  # d times a tenth of a second, tenfold


def test_bristles_bear_friction_that_fades_to_nothing(nist):
    """The level sinks to a thousandth in 1.1 s: forces stay within what it was a moment before."""
    log = run(nist, gk.Plant(machine=nist, friction_drift=-0.9))
    assert log.status == "done"
    t, friction = log["t"], np.abs(log["friction"])
    most = friction[:50].max()
    falling = (t > 0.05) & (t < 1.1)
    # the load on a strut changes by a third on this circle, friction by Stribeck's rise of a third at a reversal
    assert (friction[falling] < 1.8 * most * (1 - 0.9 * t[falling, None]) + 5).all()
    assert friction[t > 1.2].max() < 0.01 * most


@pytest.mark.full
def test_sub_steps_are_chosen_for_the_most_friction_there_will_be(nist):
    stiff = nist.replace(friction=Stribeck(coulomb=300.0, smoothing=2e-4), **{"joints.friction": None})
    log = run(nist, gk.Plant(machine=stiff, friction_drift=1.0))
    grown = scale(1.0, log.info["simulated_time"])
    assert log.info["run"]["substeps"] == choose_substeps(scaled(stiff, grown), PERIOD) > choose_substeps(stiff, PERIOD)
    falling = run(nist, gk.Plant(machine=stiff, friction_drift=-0.5))
    assert falling.info["run"]["substeps"] == choose_substeps(stiff, PERIOD)
    slippery = nist.replace(**{"friction.coulomb": 0.4, "friction.static": 0.5})
    with pytest.raises(
        ExperimentError, match=r"with 2\.3\d* times the friction, friction grows faster with the acc.* jam"
    ):
        run(nist, gk.Plant(machine=slippery, friction_drift=1.0))


def test_a_run_with_an_encoder_fault_and_drift_has_one_clock(nist):
    fault = {"kind": "glitch", "joint": 2, "start": 0.3, "duration": 0.002, "size": 1e-5}
    log = run(nist, gk.Plant(machine=nist, friction_drift=0.1, faults=[EncoderFault(**fault)]))
    clean = run(nist, gk.Plant(machine=nist, friction_drift=0.1))
    k = 300
    assert_array_equal(log["x"][: k + 1], clean["x"][: k + 1])
    assert log["q_m"][k, 1] - clean["q_m"][k, 1] == pytest.approx(1e-5, rel=1e-9)


def test_the_log_tells_of_the_drift(nist):
    log = gk.simulate(
        nist, LAW, SHORT, plant=gk.Plant(machine=nist, friction_drift=0.01), signals=["plant.friction_scale"]
    )
    assert log.info["plant"]["friction_drift"] == "0.01 1/s"
    assert log.dataset["plant.friction_scale"].dims == ("t",)
    plants = [gk.Plant(machine=nist), gk.Plant(machine=nist, friction_drift=0.01)]
    assert run(nist, plants, keep="metrics").info["runs"][1]["plant"]["friction_drift"] == "0.01 1/s"
    with pytest.raises(
        ExperimentError, match=r"run.signals.0: the log has no such variable, got 'plant.friction_scale'"
    ):
        run(nist, gk.Plant(machine=nist), signals=["plant.friction_scale"])


# -- on and off, from Python and from files -------------------------------------------------------------------------

FILE = """
schema = "gough-experiment-1"
[machine]
use = "nist-octahedral"
{machine}
[plant]
{plant}
[program]
kind   = "circle"
radius = "10 mm"
feed   = "3 m/min"
settle = "0.05 s"
[[controller]]
kind      = "computed_torque"
bandwidth = "16 Hz"
"""


def read(write, plant='payload = "1 kg"', machine=""):
    return gk.load_experiment(write("e.toml", FILE.format(plant=plant, machine=machine)))


@pytest.mark.parametrize(("text", "names"), [
    ('"joints.friction" = "none"', ["joints.friction"]),
    ('friction = "none"', ["friction"]),
    ('friction = "none"\njoints = { friction = "none" }', ["friction", "joints.friction"]),
])  # fmt: skip
def test_a_file_takes_friction_from_the_plant_alone(write, nist, text, names):
    experiment = read(write, text)
    assert experiment.machine == nist
    assert experiment.plant.machine == nist.replace(**dict.fromkeys(names))


def test_a_file_takes_friction_and_torque_limit_from_what_is_believed(write, nist):
    experiment = read(write, machine='"joints.friction" = "none"\n"drive.torque_limit" = "none"')
    assert experiment.machine == nist.replace(**{"joints.friction": None, "drive.torque_limit": None})
    assert experiment.plant.machine == experiment.machine  # what is true starts from it


def test_a_file_gives_friction_to_a_plant_whose_machine_believes_in_none(write, nist):
    joints = '"joints.friction" = { coefficient = 0.01, platform_radius = "40 mm", base_radius = "40 mm" }'
    experiment = read(write, joints, '"joints.friction" = "none"')
    assert experiment.machine.joints.friction is None
    assert experiment.plant.machine == nist


def test_a_file_gives_the_drift_with_its_unit(write):
    assert read(write, 'friction_drift = "2 %/min"').plant.friction_drift == pytest.approx(0.02 / 60)
    with pytest.raises(ExperimentError, match=r'plant.friction_drift: has no unit, got 0.02; write e.g. "0.02 1/s"'):
        read(write, "friction_drift = 0.02")
    with pytest.raises(ExperimentError, match=r"plant.friction_drift: must be at most 1 1/s, got '200 %/s'"):
        read(write, 'friction_drift = "200 %/s"')


@pytest.mark.full
def test_friction_of_passive_joints_and_stribecks_rise_are_felt_where_they_are_and_not_where_they_are_not(nist, plain):
    """Each alone changes the run, and taking both away leaves Coulomb and viscous friction."""
    rise = {"friction.static": None, "friction.stribeck": None}
    made = {key: run(nist, gk.Plant(machine=nist.replace(**changes))) for key, changes in (
        ("no joints", {"joints.friction": None}), ("no rise", rise), ("neither", {"joints.friction": None, **rise}),
    )}  # fmt: skip
    errors = [log.metrics["contour_error"]["max"] for log in (plain, *made.values())]
    assert len(set(errors)) == 4
    assert np.abs(made["no rise"]["friction"]).max() < np.abs(plain["friction"]).max()


def test_check_finds_the_friction_that_will_jam_the_struts(gough, write):
    text = FILE.format(machine="", plant='"friction.coulomb" = 0.4\n"friction.static" = 0.5\nfriction_drift = "1 1/s"')
    ended = gough("check", write("e.toml", text))
    assert ended.status == 2
    assert "times the friction, friction grows faster with the acceleration than the drives push" in ended.err
