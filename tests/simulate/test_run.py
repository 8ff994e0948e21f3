"""simulate(): what a run promises, whatever the machine and the law."""

from __future__ import annotations

import numpy as np
import pytest

import gough as gk
from gough.errors import DivergedError, ExperimentError, WorkspaceError
from gough.kernel import noise
from gough.simulate.notes import EffortWarning, ReachWarning, StabilityWarning
from gough.simulate.run import Run
from gough.simulate.single import CHUNK, Single

CIRCLE = gk.Circle(radius=0.02, feed=0.05, settle=0.1)


@pytest.fixture(scope="module")
def nist():
    return gk.load_machine("nist-octahedral")


@pytest.fixture(scope="module")
def base(nist):
    return gk.simulate(nist, gk.PID(bandwidth=12.0), CIRCLE)


@pytest.mark.full
def test_the_same_seed_gives_the_same_bits(nist):
    noisy = nist.replace(**{"drive.noise": 1e-7})
    runs = [gk.simulate(noisy, gk.PID(bandwidth=12.0), CIRCLE, seed=seed).dataset["x"].values for seed in (3, 3, 4)]
    np.testing.assert_array_equal(runs[0], runs[1])
    assert not np.array_equal(runs[0], runs[2])


def test_the_encoder_reads_the_joint_plus_its_noise_rounded_to_a_count(nist):
    """Eq. (2) of simulate.drive, with the kernel's noise from its definition in NumPy."""
    sigma, res = 3e-6, 1e-7
    noisy = nist.replace(**{"drive.noise": sigma, "drive.encoder": res})
    log = gk.simulate(noisy, gk.PID(bandwidth=8.0), CIRCLE, seed=4)
    for k in range(0, len(log), 7):
        normal = noise.normals("noise", 6, noise.run_key(4, 0), k)
        read = res * np.floor((log["q"][k] + sigma * normal) / res + 0.5)
        np.testing.assert_allclose(log["q_m"][k], read, rtol=0, atol=1.001 * res)  # a rounding may fall either way
        assert np.abs(log["q_m"][k] - read).mean() < res / 2


def test_the_pose_stays_a_pose_in_every_sample(nist):
    """S3: a hexapod has no loop that drifts open, its struts follow from the pose; what could drift is |quaternion|."""
    job = Single(nist, gk.PID(bandwidth=8.0), CIRCLE, gk.Plant(machine=nist), Run(), False)
    rows, build = [], job._advance

    def advance(k, reference):
        done = build(k, reference)
        rows.append(job.simulation.state("z")[0])
        return done

    job._advance = advance
    log, error = job.run(None)
    assert error is None and len(rows) == -(-len(log) // CHUNK)
    assert np.abs(np.linalg.norm(np.array(rows)[:, 3:], axis=1) - 1).max() < 1e-15
    np.testing.assert_allclose(nist.inverse_kinematics(log["x"]), log["q"], rtol=0, atol=1e-14)


def test_noise_has_the_declared_deviation(nist):
    noisy = nist.replace(**{"drive.noise": 1e-6, "drive.encoder": 1e-9})
    log = gk.simulate(noisy, gk.PID(bandwidth=5.0), CIRCLE)
    error = log["q_m"] - log["q"]
    count = error.size
    assert abs(error.std() / 1e-6 - 1) < 5 / np.sqrt(2 * count)  # five standard deviations of a standard deviation
    assert abs(error.mean()) < 5 * 1e-6 / np.sqrt(count)


def test_the_encoder_rounds_to_its_resolution(base, nist):
    steps = base["q_m"] / nist.drive.encoder
    np.testing.assert_allclose(steps, np.round(steps), rtol=0, atol=1e-6)
    assert np.abs(base["q_m"] - base["q"]).max() <= nist.drive.encoder / 2 * (1 + 1e-6)


def test_a_thinned_log_has_the_same_metrics(base, nist):
    thin = gk.simulate(nist, gk.PID(bandwidth=12.0), CIRCLE, log_every=7, signals=["x", "contour_error"])
    assert thin.metrics == base.metrics
    np.testing.assert_array_equal(thin["x"], base["x"][::7])
    assert set(thin.dataset.data_vars) == {"x", "contour_error"}


def test_metrics_are_those_of_the_rows(base):
    counted = base["counted"] == 1
    assert base.metrics["contour_error"]["max"] == base["contour_error"][counted].max()
    np.testing.assert_allclose(
        base.metrics["contour_error"]["rms"], np.sqrt(np.mean(base["contour_error"][counted] ** 2)), rtol=1e-12
    )


def test_every_sample_from_start_to_settled_end_is_there(base, nist):
    motion = CIRCLE.plan(nist)
    np.testing.assert_allclose(base["t"], np.arange(motion.count(1e-3)) * 1e-3, rtol=0, atol=1e-12)
    assert base["t"][-1] >= motion.duration - 1e-9


def test_the_force_is_held_from_its_sample_on(nist):
    """Row k holds the measurement read at k and the force computed from it; with delay the one computed before."""
    for delay in (0.0, 1.0):
        log = gk.simulate(nist.replace(**{"drive.delay": delay}), gk.PID(bandwidth=8.0), CIRCLE)
        shift = int(delay)
        np.testing.assert_array_equal(log["u"][1:], log["u_c"][1 - shift : len(log["u_c"]) - shift])


@pytest.mark.quick("computed_torque")
@pytest.mark.parametrize("law", [gk.PID(bandwidth=12.0), gk.ComputedTorque(bandwidth=16.0)], ids=lambda law: law.kind)
def test_it_starts_without_a_bump(nist, law):
    """Under a payload nobody told the law about, the first forces are those at rest, to what the encoder rounds."""
    still = gk.Polyline(points=np.array([[0.01, 0.02, 0.0], [0.01, 0.02, 0.005]]), feed=0.01, lead_in=0.2)
    for encoder in (None, 1e-7):
        machine = nist.replace(**{"drive.encoder": encoder})
        plant = gk.Plant(machine=machine, payload=30.0)
        log = gk.simulate(machine, law, still, plant=plant)
        rest = plant.true_machine.inverse_dynamics(log["x_r"][0], np.zeros(6), np.zeros(6))
        # half a count between two samples is a speed; times the speed gain and the largest mass of a joint, 3960 kg,
        # twice for the coupling: PID 3 K_v, computed torque 4 w
        gain = {"pid": 3 * 2 * np.pi * 12, "computed_torque": 4 * 2 * np.pi * 16}[law.kind]
        allowed = 1e-6 if encoder is None else 2 * (encoder / 2 / 1e-3) * gain * 3960
        assert np.abs(log["u_c"][0] - rest).max() < allowed
        still_there = log["t"] < 0.19
        # the joints stay within a count of where they were; J^-1 says what that is at the tool
        within = 1e-9 if encoder is None else np.abs(np.linalg.inv(machine.jacobian(log["x_r"][0]))).sum(1) * encoder
        assert (np.abs(log["x"] - log["x_r"])[still_there] < within).all()


def test_a_payload_is_felt(nist):
    heavy = gk.Plant(machine=nist, payload=50.0)
    log = gk.simulate(nist, gk.ComputedTorque(bandwidth=16.0), CIRCLE, plant=heavy)
    light = gk.simulate(nist, gk.ComputedTorque(bandwidth=16.0), CIRCLE)
    lift = (log["u"][0] - light["u"][0]) @ nist.jacobian(light["x"][0])  # J' u is the force on the platform
    # the encoder's rounding moves the first force by up to half a count over a sample times K_D and the mass
    assert lift[2] == pytest.approx(50 * 9.81, abs=0.5e-7 / 1e-3 * 4 * 2 * np.pi * 16 * 1300 * 3)


def test_a_steady_force_on_the_tool_is_carried(nist):
    pushed = gk.Plant(machine=nist.replace(friction=None), wrench=[300.0, 0, 0, 0, 0, 0])
    log = gk.simulate(nist.replace(friction=None), gk.ComputedTorque(bandwidth=16.0), CIRCLE, plant=pushed)
    assert log.metrics["contour_error"]["max"] < 5e-6  # taken over at the start, so never seen
    np.testing.assert_array_equal(log["wrench"][0], [300, 0, 0, 0, 0, 0])


def test_a_program_out_of_reach_ends_where_it_leaves(nist):
    """K1: which strut, how long, the limit, the time; the log holds what was run."""
    far = gk.Line(to=[0.6, 0, 0], feed=0.5)
    log = gk.simulate(nist, gk.PID(bandwidth=12.0), far)
    assert log.dataset.attrs["status"] == "failed"
    reason = log.dataset.attrs["reason"]
    assert "strut" in reason and "too" in reason and "limit" in reason and "t =" in reason
    assert len(log["t"]) > 100 and np.isfinite(log["x"]).all()
    with pytest.raises(WorkspaceError, match="strut [1-6]: too (long|short)") as caught:
        gk.simulate(nist, gk.PID(bandwidth=12.0), far, on_fail="raise")
    assert len(caught.value.log["t"]) == len(log["t"])


def test_an_unstable_loop_is_warned_of_and_then_stopped(nist):
    """P5 and S1: the number before, the reason after; the last good state stays."""
    law = gk.PID(bandwidth=200.0)  # at 100 Hz friction, growing with acceleration, holds a limit cycle
    with pytest.warns(
        StabilityWarning, match=r"pid: the loop at a period of 1 ms is unstable .* spectral radius 13\.9"
    ):
        log = gk.simulate(nist.replace(**{"drive.torque_limit": None}), law, CIRCLE)
    assert log.dataset.attrs["status"] == "failed"
    assert np.isfinite(log["x"]).all() and np.isfinite(log["u"]).all()
    with pytest.raises(ExperimentError, match="spectral radius"):
        gk.simulate(nist, law, CIRCLE, strict=True)


class Poisoned(gk.PID):
    """A law that commands something that is not a number from half a second on."""

    def step(self, state, r, y, theta):
        import casadi as ca

        command, after = super().step(state, r, y, theta)
        bad = ca.if_else(r.s > 0.02, ca.log(-1 - r.s * 0), 0)
        return command._replace(u=command.u + bad), after


def test_nan_is_stopped_even_behind_a_torque_limit(nist):
    """S1: a command that is no number passes the drive's limit as no number and ends the run."""
    log = gk.simulate(nist, Poisoned(bandwidth=12.0), CIRCLE)
    assert log.dataset.attrs["status"] == "failed"
    assert "no longer finite" in log.dataset.attrs["reason"] and "t =" in log.dataset.attrs["reason"]
    assert log["s_r"][-1] < 0.02 + 1e-3
    for name in log.dataset.data_vars:
        assert np.isfinite(log[name].astype(float)).all(), name
    with pytest.raises(DivergedError):
        gk.simulate(nist, Poisoned(bandwidth=12.0), CIRCLE, on_fail="raise")


def test_saturation_is_logged_and_does_not_wind_up(nist):
    """S7: with weak motors the run saturates, says so, and is back on the path when the demand is over."""
    weak = nist.replace(**{"drive.torque_limit": 12.0})
    quick = gk.Polyline(points=np.array([[0, 0, 0], [0.1, 0, 0]]), feed=0.3, acceleration=6.0, settle=1.0)
    with pytest.warns(EffortWarning, match=r"pid: a drive is at its limit in \d+(\.\d+)? % of the samples"):
        log = gk.simulate(weak, gk.PID(bandwidth=12.0), quick)
    limit = 12.0 * 2 * np.pi / nist.drive.lead
    assert np.abs(log["u"]).max() <= limit
    assert log["saturated"].max() == 1 and 0 < log.metrics["saturated"] < 1
    assert np.abs(log["u_c"]).max() > limit
    assert np.linalg.norm(log["x"][-1, :3] - log["x_r"][-1, :3]) < 20e-6
    assert len(log.info["warnings"]) == 1 and "at its limit" in log.info["warnings"][0]


def test_another_geometry_is_wrong_by_what_the_struts_say(nist):
    """What is believed and what is true differ in a joint; the encoder cannot know."""
    base = nist.joints.base.copy()
    base[0, 0] += 1e-4
    true = nist.replace(**{"joints.base": base})
    log = gk.simulate(nist, gk.PID(bandwidth=12.0), CIRCLE, plant=true)
    assert np.abs(log["q"] - log["q_r"])[0].max() < 1e-9
    assert 1e-6 < np.abs(log["x"] - log["x_r"])[0].max() < 1e-3


def test_wrong_arguments_are_refused(nist):
    with pytest.raises(ExperimentError, match="period"):
        gk.simulate(nist, gk.PID(bandwidth=12.0), CIRCLE, period=0.0)
    with pytest.raises(ExperimentError, match="did you mean contour_error"):
        gk.simulate(nist, gk.PID(bandwidth=12.0), CIRCLE, signals=["contour_eror"])
    with pytest.raises(ExperimentError, match="on_fail"):
        gk.simulate(nist, gk.PID(bandwidth=12.0), CIRCLE, on_fail="ignore")
    with pytest.raises(
        ExperimentError,
        match=r"1 sub-steps of 5 ms cannot follow .* pole x step = 11\.8 \(limit 2\.0\); give at least 6, .* for 20",
    ):
        gk.simulate(nist, gk.PID(bandwidth=3.0), CIRCLE, period=5e-3, substeps=1)


@pytest.mark.full
def test_a_slower_law_holds_its_force_between_its_ticks(nist):
    log = gk.simulate(nist, gk.ComputedTorque(bandwidth=10.0, period=1e-3), CIRCLE, period=2.5e-4)
    held = log["u_c"][: len(log["u_c"]) // 4 * 4].reshape(-1, 4, 6)
    np.testing.assert_array_equal(held, held[:, :1].repeat(4, 1))
    assert not np.array_equal(held[1:, 0], held[:-1, 0])
    alone = gk.simulate(nist, gk.ComputedTorque(bandwidth=10.0), CIRCLE, period=1e-3, substeps=4)
    # the plant is stepped alike and the law sees it at the same instants
    np.testing.assert_allclose(log["x"][::4][:100], alone["x"][:100], rtol=0, atol=1e-12)
    with pytest.raises(gk.InputError, match="multiple of the base tick"):
        gk.simulate(nist, gk.PID(bandwidth=10.0, period=1.5e-3), CIRCLE)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"controller": 3}, r"controller: must be a Controller, got 3; gk.PID"),
        ({"program": "part.ngc"}, r"program: must be a Program, got 'part.ngc'; gk.load_program"),
        ({"plant": 3}, r"plant: must be a Plant, got 3"),
        ({"machine": "nist-octahedral"}, r"machine: must be a Machine, got 'nist-octahedral'; gk.load_machine"),
        ({"signals": ["controller.integrl"]}, r"run.signals.0: .* no such variable, .* mean controller.integral"),
        ({"signals": "x"}, r"signals: must be a list"),
        ({"controller": gk.PID(bandwidth=9.0, mass=[100.0, 200.0])}, r"mass: must be one value or 6, got 2 values"),
        ({"controller": gk.PID(bandwidth=9.0, period=1.5e-3)}, r"controller.period: .* multiple of the base tick"),
        ({"program": gk.Circle(radius=0.02, feed=1e-9)}, r"run.log_every: .* takes .* log_every = \d+ or more"),
    ],
)  # fmt: skip
def test_what_does_not_fit_is_said(nist, arguments, message):
    whole = {"machine": nist, "controller": gk.PID(bandwidth=12.0), "program": CIRCLE} | arguments
    with pytest.raises(gk.InputError, match=message):
        gk.simulate(**whole)


def test_the_bristles_spring_sets_the_sub_steps_too(nist):
    """Held memory makes a leapfrog of mass and bristle: h sqrt(s0 / m) must stay well below 2, or it chatters."""
    from gough.simulate.stability import choose_substeps, fastest_pole

    stiff = nist.replace(**{"friction.stiffness": 1e11})
    lightest = 422.0  # kg, the lightest direction of the coupled struts at home (tests/machine)
    # the spring alone has sqrt(s0 / m); its damper, 7 % of critical, turns the pole without changing its size
    assert fastest_pole(stiff) == pytest.approx(np.sqrt(1e11 / lightest), rel=0.01)
    steps = choose_substeps(stiff, 1e-3)
    assert 1e-3 / steps * fastest_pole(stiff) < 2 / 3
    quiet = {"drive.encoder": None, "friction.stiffness": 1e11}
    rest = gk.Line(to=[0, 0, 1e-6], feed=1e-3, lead_in=0.2, settle=0.0)
    log = gk.simulate(nist.replace(**quiet), gk.PID(bandwidth=12.0), rest)
    jump = np.abs(np.diff(log["friction"][100:200], axis=0)).max()
    assert jump < 1.0, "N; chatter was 477 to 687 N"
    with pytest.raises(ExperimentError, match="cannot follow"):
        gk.simulate(stiff, gk.PID(bandwidth=12.0), CIRCLE, substeps=4)


def test_a_path_beyond_the_declared_workspace_is_warned_of_once(nist):
    """K1: where the machine can still go but is not meant to; the tool is 0.26 m from home at t = 5.2 s."""
    out = gk.Line(to=[0.26, 0, 0], feed=0.05, acceleration=1e3)
    with pytest.warns(
        ReachWarning, match=r"t = 5\.\d+ s: beyond the radius of the workspace, .* \(limit 0.25 m\)"
    ) as seen:
        log = gk.simulate(nist, gk.PID(bandwidth=8.0), out)
    assert log.status == "done"
    assert sum(issubclass(w.category, ReachWarning) for w in seen) == 1


@pytest.mark.full
def test_a_poor_condition_number_is_warned_of_before_it_ends_the_run(nist):
    """K2: warn at one number, stop at the other."""
    wide = {"limits.length": [1.0, 3.0], "strut.tube": 2.5, "limits.cone": None, "limits.workspace": None}
    wide = nist.replace(**wide)
    turn = gk.Polyline(points=np.array([[0, 0, 0], [0, 0, 1e-3]]), feed=0.01, abc=[0.0, 0, np.radians(80)])
    with pytest.warns(ReachWarning, match=r"near a singularity: condition number of J, got \d+(\.\d+)? \(limit 20\)"):
        gk.simulate(wide.replace(**{"limits.condition_warning": 20.0}), gk.PID(bandwidth=4.0), turn)
