"""Load-dependent friction and the forces in the joints, in runs."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

import gough as gk
from gough.errors import ExperimentError
from gough.frames import quaternion_of_abc_np, rotation_of_abc_np
from gough.mechanics.friction import LuGre
from gough.mechanics.load_friction import LoadLuGre, LoadStribeck
from gough.simulate import stability

CIRCLE = gk.Circle(radius=0.05, feed=0.2)
FORCES = ["plant.reaction", "plant.base_reaction", "plant.bushing_mouth", "plant.bushing_end", "plant.normal_force"]
BRISTLES = {"stiffness": 1e9, "damping": 8.85e5}


@pytest.fixture(scope="module")
def nist():
    return gk.load_machine("nist-octahedral").replace(**{"drive.torque_limit": None})


@pytest.fixture(scope="module")
def log(nist):
    nist = nist.replace(**{"joints.friction": None})
    signals = ["x", "q", "xd", "u", "friction", "contour_error", *FORCES]
    return gk.simulate(nist, gk.ComputedTorque(bandwidth=20.0), CIRCLE, signals=signals, period=5e-4)


def test_asked_for_forces_are_in_the_log_with_units_and_meaning(log):
    data = log.dataset
    assert data.attrs["status"] == "done"
    for name in FORCES:
        dims = ("t", "joint") if name == "plant.normal_force" else ("t", "joint", "axis")
        assert data[name].dims == dims and data[name].attrs["units"] == "N"
        assert "W" in data[name].attrs["long_name"] or name == "plant.normal_force"


def test_logged_forces_are_those_of_the_motion_under_the_logged_drives_and_friction(nist, log):
    """`Machine.reactions`, which stand against free bodies elsewhere, at the acceleration that u - friction makes."""
    d = {name: log.dataset[name].values for name in log.dataset}
    k = np.arange(0, len(d["x"]), 50)
    x, V = d["x"][k], d["xd"][k]
    wanted = nist.reactions(x, V, nist.forward_dynamics(x, V, (d["u"] - d["friction"])[k]))
    for name, value in zip(FORCES, wanted, strict=True):
        assert_allclose(d[name][k], value, rtol=0, atol=1e-9 * np.abs(value).max())


def test_friction_is_the_coefficients_times_the_normal_force_away_from_rest(nist, log):
    """mu_c N + mu_v N v + f_0 v.  The log's N is that of the sample, friction's one sub-step old.

    The drive changes once a sample, and with it the acceleration, by what the encoder's steps of 0.1 um make of it.
    """
    d = {name: log.dataset[name].values for name in log.dataset}
    qd = np.einsum("kij,kj->ki", nist.jacobian(d["x"]), d["xd"])
    N = d["plant.normal_force"]
    fast = np.abs(qd) > 0.03
    fast[:200] = False
    wanted = np.sign(qd) * N * 0.18 + (0.5 * N + 94.0) * qd
    assert fast.sum() > 1000
    off = np.abs(d["friction"] - wanted)[fast] / np.abs(wanted)[fast]
    assert np.median(off) < 0.02 and off.max() < 0.3
    quiet = np.abs(N[1:] - N[:-1]) < 1e-3 * N[1:]  # where the load has just stood still
    assert (np.abs(d["friction"] - wanted)[1:] < 5e-3 * np.abs(wanted)[1:])[quiet & fast[1:]].all()


@pytest.mark.full
def test_a_machine_without_guides_has_reactions_but_no_normal_force():
    okuma = gk.load_machine("okuma-pm600")
    law = gk.ComputedTorque(bandwidth=16.0)
    log = gk.simulate(
        okuma, law, gk.Circle(radius=0.02, feed=0.1), signals=["x", "xd", "u", "friction", "plant.reaction"]
    )
    d = {name: log.dataset[name].values for name in log.dataset}
    Vd = okuma.forward_dynamics(d["x"], d["xd"], d["u"] - d["friction"])
    w, wd = d["xd"][:, 3:], Vd[:, 3:]
    c = np.einsum("kij,j->ki", rotation_of_abc_np(d["x"][:, 3:]), okuma.platform.center)
    a = Vd[:, :3] + np.cross(wd, c) + np.cross(w, np.cross(w, c))
    # the struts carry the platform's weight less what accelerates it; forces of some kN, to 1e-11 relative
    assert_allclose(d["plant.reaction"].sum(1), okuma.platform.mass * (okuma.gravity - a), atol=1e-7)
    with pytest.raises(ExperimentError, match="the log has no such variable, got 'plant.normal_force'"):
        gk.simulate(okuma, law, gk.Circle(radius=0.02, feed=0.1), signals=["plant.normal_force"])


def trajectory(machine):
    law = gk.PID(bandwidth=10.0)
    return gk.simulate(machine, law, gk.Circle(radius=0.02, feed=0.1), signals=["x", "friction", "u"])


@pytest.mark.full
def test_with_coefficients_of_zero_it_is_the_machine_of_constant_friction(nist):
    """mu = 0: what is left are the offsets, and the joints turn without friction."""
    constant = nist.replace(friction=LuGre(coulomb=300.0, viscous=930.0, **BRISTLES), **{"joints.friction": None})
    zero = nist.replace(
        friction=LoadLuGre(coulomb=0.0, coulomb_offset=300.0, viscous=0.0, viscous_offset=930.0, **BRISTLES),
        **{"joints.friction.coefficient": 0.0},
    )
    a, b = trajectory(constant).dataset, trajectory(zero).dataset
    # one is compiled with the loads, the other without: rounding, which 0.6 s of a stable loop does not amplify
    assert_allclose(b["x"], a["x"], atol=1e-12)
    assert_allclose(b["friction"], a["friction"], atol=1e-5)
    assert np.abs(a["friction"]).max() > 300


def test_the_step_is_chosen_for_the_largest_load(nist):
    """Friction without memory: its pole grows with the load, and more sub-steps are taken for a greater coefficient."""
    made = [
        nist.replace(friction=LoadStribeck(coulomb=mu, smoothing=1e-4), **{"joints.friction": None})
        for mu in (0.1, 0.4)
    ]
    poles = [stability.fastest_pole(m) for m in made]
    assert poles[1] == pytest.approx(4 * poles[0], rel=1e-3)  # gravity's stiffness, 10 1/s^2, is beside 1e4 1/s
    assert [stability.choose_substeps(m, 1e-3) for m in made] == [
        int(np.ceil(pole * 1e-3 / (stability.RK4_REAL / 3))) for pole in poles
    ]


def test_the_load_at_the_stability_check_is_above_that_of_the_circle(nist):
    row = gk.Circle(radius=0.2, feed=0.05).plan(nist).sample(0, 2500, 0.01)
    normal = nist.reactions(row.x, row.xd, row.xdd).normal
    assert (stability.largest_loads(nist)[:6] > normal.max(0)).all()


def test_friction_that_jams_is_refused_before_it_diverges(nist):
    jamming = nist.replace(**{"friction.coulomb": 1.2, "friction.static": 1.5})
    assert stability.load_gain(nist) == pytest.approx(0.255, abs=0.005)
    with pytest.raises(ExperimentError, match="the struts may jam, got a gain of 1.59") as caught:
        stability.choose_substeps(jamming, 1e-3)
    assert caught.value.problems[0].key == "friction.static"


def test_the_load_gain_bounds_what_an_acceleration_makes_of_itself(nist):
    """By differences: a unit change of the acceleration before, in the metric of M, through loads and breakaway."""
    from gough.simulate import tick

    f, mu = tick.loads_function(nist), 0.24
    z = np.r_[nist.home[:3], quaternion_of_abc_np(nist.home[3:])]
    M, J = nist.mass_matrix(nist.home), nist.jacobian(nist.home)
    L = np.linalg.cholesky(M)
    zero, worst, rng = np.zeros(6), 0.0, np.random.default_rng(0)
    loads = lambda a: np.array(f(nist.theta, z, zero, zero, a, zero)).ravel()[:6]  # noqa: E731
    for _ in range(50):
        y = rng.normal(size=6)
        a = np.linalg.solve(L.T, y / np.linalg.norm(y)) * 1e-3
        change = (loads(a) - loads(-a)) / 2e-3
        sign = rng.choice([-1, 1], 6)
        worst = max(worst, np.linalg.norm(np.linalg.solve(L, J.T @ (mu * sign * change))))
    assert 0.02 < worst < stability.load_gain(nist)


@pytest.mark.full
def test_the_loads_enter_one_sub_step_late_and_only_so(nist):
    """Halving the sub-step halves the difference to fine steps: the lag is the only error of first order."""
    loud = nist.replace(
        friction=LoadStribeck(coulomb=0.3, viscous=1.0, smoothing=0.02),
        **{"drive.encoder": None, "joints.friction": None},
    )
    ends = []
    for substeps in (8, 16, 32, 256):
        log = gk.simulate(loud, gk.PID(bandwidth=10.0), gk.Circle(radius=0.02, feed=0.1), substeps=substeps)
        ends.append(log.dataset["x"].values[300])
    change = [np.abs(end[:3] - ends[-1][:3]).max() for end in ends[:-1]]
    ratio = np.array(change[:-1]) / change[1:]
    # h - h_fine in place of h: (8 to 16) 31/15 = 2.07, (16 to 32) 15/7 = 2.14 for an error of first order
    assert_allclose(ratio, [31 / 15, 15 / 7], rtol=0.1)
