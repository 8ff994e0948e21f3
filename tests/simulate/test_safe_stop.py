"""RELIABILITY S8: encoders are flagged, and a run is brought to rest: simulate.supervise, safe_stop, stopped."""

from __future__ import annotations

from pathlib import Path

import casadi as ca
import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import gough as gk
from gough.errors import EncoderError, ExperimentError, FollowingError
from gough.experiment.experiment import load_experiment
from gough.frames import rotation_of_abc_np, rotation_of_vector_np
from gough.kernel.pack import flatten, unflatten
from gough.program.reference import Reference
from gough.simulate import safe_stop
from gough.simulate.faults import EncoderFault
from gough.simulate.notes import EncoderWarning
from gough.simulate.plant import Plant
from gough.simulate.tick import rest_row

pytestmark = [
    pytest.mark.filterwarnings("ignore::gough.simulate.notes.EncoderWarning"),
    pytest.mark.filterwarnings("ignore::gough.simulate.notes.EffortWarning"),
]
EXAMPLES = Path(__file__).parents[2] / "examples"
CIRCLE = gk.Circle(radius=0.02, feed=0.05, settle=0.1)
LAW = gk.ComputedTorque(bandwidth=10.0)
UNKNOWN, RAMP = 1e3, 2.0  # N, above all friction of the machine (0.7 kN); m/s2
COUNT = 1e-6


@pytest.fixture(scope="module")
def nist():
    return gk.load_machine("nist-octahedral").replace(**{"drive.encoder": COUNT})


def plant(machine, joint=2, start=0.6, **fault):
    return Plant(machine=machine, faults=[EncoderFault(joint=joint, start=start, **fault)])


# -- the way to rest --------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def stop(nist):
    """(row, t, a, alpha) -> rows of the reference at times t after a stop began in `row`; and T."""
    p, theta = nist.symbols
    like = rest_row(nist, nist.home)
    row, t, limits = ca.SX.sym("row", len(flatten(like))), ca.SX.sym("t"), ca.SX.sym("limits", 2)
    given = unflatten(like, row)
    start = safe_stop.origin(given)
    T = safe_stop.duration(start, limits[0], limits[1], 1e-3)
    f = ca.Function("f", [theta, row, t, limits], [flatten(safe_stop.ramp(nist, p, given, start, t, T)), T])

    def rows(first: Reference, times, a=RAMP, alpha=3.0):
        out = f.map(len(times))(
            np.tile(nist.theta[:, None], len(times)), np.tile(flatten(first)[:, None], len(times)),
            np.array(times)[None], np.tile(np.array([[a], [alpha]]), len(times)),
        )  # fmt: skip
        split = [unflatten(like, column) for column in np.array(out[0]).T]
        return Reference(*(np.array(column) for column in zip(*split, strict=True))), float(out[1][0])

    return rows


def moving(nist, v, a=(0, 0, 0), w=(0, 0, 0)) -> Reference:
    """A row of the reference at home plus some, with speed, acceleration and rate of turn."""
    x = nist.home + np.array([0.02, -0.01, 0.03, 0.05, -0.04, 0.1])
    V, Vd = np.concatenate([v, w]), np.concatenate([a, np.zeros(3)])
    q, qd, qdd = nist.joint_motion(x, V, Vd)
    return rest_row(nist, x)._replace(xd=V, xdd=Vd, q=q, qd=qd, qdd=qdd, s=np.array([0.7]))


def test_every_column_of_the_ramp_is_the_rate_of_the_one_before(nist, stop):
    first = moving(nist, [0.03, 0.04, 0.01], [1.0, 2.0, -0.5], [0.2, -0.1, 0.3])
    h, inner = 1e-5, np.arange(1, 240) * 1e-4
    here, T = stop(first, inner)
    assert pytest.approx(np.sqrt(0.14) / 3.0) == T  # the turning takes longer here than sqrt(0.0026) / 2
    before, after = stop(first, inner - h)[0], stop(first, inner + h)[0]
    for value, rate, scale in (("q", "qd", 1), ("qd", "qdd", 1), ("s", "sd", 1)):
        slope = (getattr(after, value) - getattr(before, value)) / (2 * h)
        assert_allclose(slope, getattr(here, rate), atol=1e-7 * scale, rtol=1e-6)
    assert_allclose((after.x - before.x)[:, :3] / (2 * h), here.xd[:, :3], atol=1e-9)
    assert_allclose((after.xd - before.xd) / (2 * h), here.xdd, atol=1e-6)
    for one, two, V in zip(before.x, after.x, here.xd, strict=True):
        turned = rotation_of_abc_np(two[3:]) @ rotation_of_abc_np(one[3:]).T
        assert_allclose(turned, rotation_of_vector_np(V[3:] * 2 * h), atol=1e-12)
    assert_allclose(here.q, nist.inverse_kinematics(here.x), atol=1e-14)
    assert_allclose(here.axis, rotation_of_abc_np(here.x[:, 3:])[..., 2], atol=1e-14)
    assert_allclose(here.tangent, here.xd[:, :3] / np.linalg.norm(here.xd[:, :3], axis=1)[:, None], atol=1e-6)


def test_it_begins_where_the_program_was_and_ends_at_rest(nist, stop):
    first = moving(nist, [0.03, 0.04, 0.0])
    rows, T = stop(first, [0.0, 0.025, 0.1, 5.0])
    assert pytest.approx(0.05 / RAMP) == T
    for name in ("x", "xd", "q", "qd", "s"):
        assert_allclose(getattr(rows, name)[0], getattr(first, name), atol=1e-15)
    assert (rows.xd[1:] == 0).all() and (rows.xdd[1:] == 0).all() and (rows.qd[1:] == 0).all()
    assert_allclose(rows.x[1:, :2], first.x[:2] + np.array([0.03, 0.04]) * T / 2 + np.zeros((3, 2)), atol=1e-15)


def test_it_brakes_along_the_circle_that_the_path_turned_on_whatever_the_feed_did(nist, stop):
    radius, speed = 0.01, 0.2
    center = (nist.home + np.array([0.02, -0.01, 0.03, 0, 0, 0]))[:3] + np.array([0, radius, 0])
    # accelerating along the path at 1.5 m/s2 when the stop begins
    rows, T = stop(moving(nist, [speed, 0, 0], [1.5, speed**2 / radius, 0]), np.linspace(0, 0.12, 50))
    d = rows.x[:, :3] - center
    assert_allclose(np.linalg.norm(d, axis=1), radius, atol=1e-13)
    assert_allclose(rows.s[-1] - rows.s[0], speed**2 / (2 * RAMP), rtol=1e-12)
    way = np.unwrap(np.arctan2(d[:, 0], -d[:, 1]))
    assert_allclose(way * radius, rows.s[:, 0] - rows.s[0], atol=1e-13)
    on = rows.sd[:, 0] > 1e-9
    along = np.einsum("ij,ij->i", rows.xdd[on, :3], rows.tangent[on])
    assert_allclose(along, -RAMP, rtol=1e-9)
    assert_allclose(rows.curvature[on], 1 / radius, rtol=1e-6)


def test_a_reference_at_rest_stays_where_it_is(nist, stop):
    first = rest_row(nist, nist.home)
    rows, T = stop(first, [0.0, 1e-3, 1.0])
    assert T == 1e-3 and np.isfinite(flatten(rows)).all()
    assert_allclose(rows.x, first.x + np.zeros((3, 6)), atol=1e-16)
    assert (rows.xd == 0).all()


@pytest.mark.parametrize("angle", [0.0, 1e-7, 0.9e-4, 1.1e-4, 0.02, 1.0, 3.0])
def test_series_and_functions_of_the_angle_are_one_to_rounding(angle):
    tau = 0.3
    found = [float(ca.evalf(part)) for part in safe_stop._series(ca.SX(tau), ca.SX((angle / tau) ** 2))]
    sinc, versine = (np.sin(angle) / angle, 2 * (np.sin(angle / 2) / angle) ** 2) if angle else (1.0, 0.5)
    assert_allclose(found, [tau * sinc, tau**2 * versine, np.cos(angle)], rtol=1e-15, atol=1e-16)


def test_angles_go_on_from_the_turn_the_program_was_in(nist, stop):
    """A tool that has turned by more than half a turn: the angles do not jump by a whole one."""
    first = moving(nist, [0.01, 0, 0], w=[0, 0, 0.2])
    for c in (-2.5, 2.0, 3.1):
        turned = first._replace(x=np.r_[first.x[:5], c])
        assert_allclose(stop(turned, [0.0])[0].x[0], turned.x, atol=1e-13)
    for turns in (-1, 1, 2):
        away = first._replace(x=first.x + 2 * np.pi * turns * np.array([0, 0, 0, 1, 0, 1]))
        rows, _ = stop(away, [0.0, 0.02])
        assert_allclose(rows.x[0], away.x, atol=1e-13)
        assert_allclose(rows.x[1] - away.x, stop(first, [0.02])[0].x[0] - first.x, atol=1e-13)


def test_a_reference_that_has_just_begun_to_move_stays_where_it_is_to_a_micrometre(nist, stop):
    """No direction yet, 1 um/s, under any acceleration."""
    first = moving(nist, [1e-6, 0, 0], [1.5, 0.5, 0])
    rows, T = stop(first, [0.0, 5e-4, 0.1])
    assert T == 1e-3 and np.abs(rows.x - first.x).max() < 1e-9 and np.abs(rows.xd[1:]).max() < 1e-6
    assert np.isfinite(flatten(rows)).all()


# -- flags ------------------------------------------------------------------------------------------------------------


def bound(machine) -> np.ndarray:
    """Eq. (3) of observe.encoders at home, (6,) m, from arrays; it varies by a fifth over these circles."""
    J, M = machine.jacobian(machine.home), machine.mass_matrix(machine.home)
    G = J @ np.linalg.solve(M, J.T)
    return 1e-6 * UNKNOWN * np.abs(G).sum(1) + 2 * COUNT


@pytest.mark.quick("stuck")
@pytest.mark.parametrize("kind", ["dropout", "stuck", "glitch"])
def test_every_fault_is_flagged_in_the_sample_in_which_it_can_be_seen_and_on_its_own_joint_first(nist, kind):
    """A fault can be seen when it moves the reading by more than the bound; each strut, at four places."""
    size = {"size": 2 * bound(nist).max()} if kind == "glitch" else {}
    cases = [(j, t) for j in range(1, 7) for t in (0.3, 0.6, 1.1, 1.7)]
    runs = gk.simulate(
        nist, LAW, CIRCLE, plant=[plant(nist, j, t, kind=kind, **size) for j, t in cases],
        encoder_check=UNKNOWN, stop_ramp=RAMP,
    )  # fmt: skip
    clean = gk.simulate(nist, LAW, CIRCLE)
    late = 0
    for i, (joint, start) in enumerate(cases):
        log, k = runs.run(i), round(start * 1e3)
        jump = {"dropout": 1.0, "glitch": 2 * bound(nist).max()}.get(
            kind, abs(clean["q"][k, joint - 1] - clean["q"][k - 1, joint - 1])
        )
        flags = log["encoder_flag"]
        assert flags[:, joint - 1].any() and not flags[:k].any()
        first = int(np.argmax(flags.any(1)))
        assert flags[first].nonzero()[0].tolist() == [joint - 1], "the joint at fault is flagged first"
        if jump > 1.2 * bound(nist)[joint - 1]:
            assert first == k
        else:  # a strut that turns round, stuck: seen when the law has pushed with more than nobody knows
            late += 1
            assert kind == "stuck" and first < k + 100
        assert log.reason.startswith(f"strut {joint}: its encoder reads what no force explains; brought to rest in ")
        assert log["stopping"].nonzero()[0][0] == first, "a flag begins the stop at once"
    assert late <= 4


@pytest.mark.full
def test_how_late_a_stuck_strut_is_flagged_depends_on_where_it_stands_before_its_reversal(nist):
    """One fault of each row of the table in docs/theory/encoders.md; the last is the worst of its 660."""
    cases = {0.28: (31, 0.73), 0.26: (50, 0.74), 0.24: (71, 0.65), 0.22: (104, 4.88)}
    runs = gk.simulate(
        nist, LAW, CIRCLE, plant=[plant(nist, 3, t, kind="stuck") for t in cases], encoder_check=UNKNOWN, stop_ramp=RAMP
    )
    for i, (start, (late, off)) in enumerate(cases.items()):
        log, k = runs.run(i), round(start * 1e3)
        first = int(np.argmax(log["encoder_flag"].any(1)))
        assert first - k == late and log["encoder_flag"][first].nonzero()[0].tolist() == [2]
        # in the digits that the page gives
        assert abs(log["q"][first, 2] - log["q_r"][first, 2]) * 1e3 == pytest.approx(off, abs=0.006)
        assert np.abs(log["q_m"][k:first, 2] - log["q_r"][k:first, 2]).max() < 0.2e-3


def test_a_flag_is_latched_while_the_run_goes_on_and_is_told(nist):
    glitch = plant(nist, 3, 0.5, kind="glitch", size=5e-5, duration=0.002)
    with pytest.warns(EncoderWarning, match=r"the encoder of strut 3 is flagged from t = 0.5 s on"):
        log = gk.simulate(nist, LAW, CIRCLE, plant=glitch, encoder_check=UNKNOWN)
    assert log.status == "done" and log["encoder_flag"].dtype == np.int8
    assert (log["encoder_flag"][500:, 2] == 1).all() and log["encoder_flag"].sum() == len(log) - 500
    assert log.info["warnings"] == [
        "the encoder of strut 3 is flagged from t = 0.5 s on: it reads what no force explains"
    ]
    residual = log["observer.encoder_residual"][:, 2]
    assert_allclose(residual[500:504], [5e-5, -5e-5, -5e-5, 5e-5], atol=bound(nist)[2])
    without = gk.simulate(nist, LAW, CIRCLE, plant=glitch)
    assert_array_equal(log["x"], without["x"])  # who looks on changes nothing


@pytest.mark.quick("computed_torque")
@pytest.mark.parametrize("law", [LAW, gk.PID(bandwidth=8.0)], ids=lambda law: law.kind)
def test_a_sound_machine_is_not_flagged_and_not_changed(nist, law):
    """Friction, a payload and a force on the tool that nobody told: less than the unknown force, so no flag."""
    true = Plant(machine=nist.replace(**{"friction.coulomb": 0.2}), payload=20.0, wrench=[200.0, 100, -300, 5, 0, 0])
    log = gk.simulate(nist, law, CIRCLE, plant=true, encoder_check=UNKNOWN, stop_ramp=RAMP)
    assert log.status == "done" and not log["encoder_flag"].any() and not log["stopping"].any()
    plain = gk.simulate(nist, law, CIRCLE, plant=true)
    for name in plain:
        assert_allclose(log[name], plain[name], rtol=0, atol=0, err_msg=name)
    assert log.metrics == plain.metrics


@pytest.mark.full
def test_an_unknown_force_is_flagged_from_its_size_on(nist):
    """A push that nobody knows, in every strut the way that moves strut 1 most: (3) is equal then, to 4 counts."""
    count = 1e-8
    smooth = nist.replace(friction=None, **{"joints.friction": None, "drive.encoder": count})
    rest = gk.Circle(radius=1e-4, feed=1e-3, settle=0.01)
    J = nist.jacobian(nist.home)
    G = J @ np.linalg.solve(nist.mass_matrix(nist.home), J.T)
    force = 2000.0
    push = Plant(machine=smooth, wrench=J.T @ (force * np.sign(G[0])))
    grain = 4 * count / 1e-6 / np.abs(G[0]).sum()  # N; two counts of (3), two that the readings may add
    assert grain < force / 50
    less = gk.simulate(smooth, LAW, rest, plant=push, encoder_check=force - grain)
    assert less["encoder_flag"][:, 0].any()
    assert not gk.simulate(smooth, LAW, rest, plant=push, encoder_check=force)["encoder_flag"].any()


@pytest.mark.full
@pytest.mark.parametrize("example", sorted(EXAMPLES.glob("*.toml")), ids=lambda p: p.stem)
def test_no_shipped_example_raises_a_flag(example):
    e = load_experiment(example)
    for controller in e.controllers:
        log = gk.simulate(
            e.machine, controller.law, e.program, plant=e.plant, period=e.run.period, encoder_check=UNKNOWN,
            stop_ramp=RAMP, signals=["encoder_flag", "stopping"],
        )  # fmt: skip
        assert log.status == "done" and not log["encoder_flag"].any() and not log["stopping"].any()


# -- the stop in a run ------------------------------------------------------------------------------------------------


def test_a_stop_brings_the_tool_to_rest_on_its_path_and_says_why(nist):
    log = gk.simulate(
        nist, LAW, CIRCLE, plant=plant(nist, kind="dropout"), encoder_check=UNKNOWN, stop_ramp=RAMP
    )  # fmt: skip
    length = gk.simulate(nist, LAW, CIRCLE)["q"][600, 1] * 1e3
    assert log.reason == (
        "strut 2: its encoder reads what no force explains; brought to rest in 36 ms, the drives are off, "
        f"got {np.abs(log['observer.encoder_residual'][600, 1]) * 1e3:.6g} mm (limit 0.00489024 mm) at t = 0.6 s; look "
        "at the encoder, its head and its cable; if nothing is wrong, allow more unknown force in encoder_check"
    )
    assert abs(np.abs(log["observer.encoder_residual"][600, 1]) * 1e3 - length) < 1  # it read 0 in place of its length
    assert len(log) == 600 + 36 and log["stopping"].sum() == 36  # 0.05 m/s / 2 m/s2, 10 ms at rest, and sample 600
    speed = np.linalg.norm(log["xd_r"][:, :3], axis=1)
    assert_allclose(np.diff(speed[600:626]), -RAMP * 1e-3, rtol=1e-9)
    assert speed[599:601] == pytest.approx(0.05) and (speed[625:] < 1e-15).all()
    # the true tool: no faster braked than twice that over 5 ms, at rest within what 10 ms leave, on the path
    true = np.linalg.norm(log["xd"][:, :3], axis=1)
    assert np.abs(true[605:] - true[600:-5]).max() < 2 * RAMP * 5e-3
    assert true[-1] < 1e-3
    assert log["contour_error"][600:].max() < 20e-6
    assert not log["counted"][600:].any() and log["counted"][599]
    assert log.metrics["counted"] == log["counted"].sum() and log.metrics["contour_error"]["at"] < 0.6


def test_a_following_error_may_brake_too_and_its_limit_is_that_of_the_trip(nist):
    held = nist.replace(**{"friction.coulomb_offset": 4000.0})  # a machine that sticks: 4 kN more in every guide
    weak = gk.PID(bandwidth=4.0)
    tripped = gk.simulate(nist, weak, CIRCLE, plant=held, ferror=2e-4)
    braked = gk.simulate(nist, weak, CIRCLE, plant=held, ferror=2e-4, stop_ramp=RAMP)
    assert tripped.failed and "following error, the drives are off" in tripped.reason
    k = len(tripped)
    assert braked["stopping"].nonzero()[0][0] == k and "encoder_flag" not in braked
    assert_array_equal(braked["x"][:k], tripped["x"])
    head, _, tail = tripped.reason.partition("following error, the drives are off")
    assert braked.reason.startswith(head + "following error; brought to rest in ") and braked.reason.endswith(tail)
    with pytest.raises(FollowingError):
        gk.simulate(nist, weak, CIRCLE, plant=held, ferror=2e-4, stop_ramp=RAMP, on_fail="raise")


@pytest.mark.parametrize("joint", [1, 4, 6])
def test_the_joint_whose_following_error_began_a_stop_is_named(nist, joint):
    log = gk.simulate(
        nist, LAW, CIRCLE, plant=plant(nist, joint, kind="glitch", size=1e-3), ferror=5e-4, stop_ramp=RAMP
    )
    assert log.reason.startswith(f"strut {joint}: following error; brought to rest in ")
    assert log["stopping"].nonzero()[0][0] == 600


def test_a_stop_that_the_program_ends_before_is_a_failure_still(nist):
    log = gk.simulate(
        nist, LAW, CIRCLE, plant=plant(nist, start=len(gk.simulate(nist, LAW, CIRCLE)) * 1e-3 - 5e-3, kind="dropout"),
        encoder_check=UNKNOWN, stop_ramp=RAMP,
    )  # fmt: skip
    assert log.failed and "not yet at rest at the end in 5 ms" in log.reason


def test_a_limit_in_the_middle_of_a_stop_ends_the_run_by_its_own_name(nist):
    """The stop of a machine at the end of its stroke: the stroke is what is told, the flag is a warning."""
    free = gk.simulate(nist, LAW, CIRCLE)["q"]
    longest = float(free.max()) - 1e-3
    k, joint = np.argwhere(free > longest)[0]
    short = nist.replace(**{"limits.length": [1.4, longest]})
    hit = plant(short, int(joint + 1) % 6 + 1, float(k - 2) * 1e-3, kind="dropout")
    log = gk.simulate(nist, LAW, CIRCLE, plant=hit, encoder_check=UNKNOWN, stop_ramp=0.1)
    assert log.failed and f"strut {joint + 1}: too long" in log.reason and log["stopping"][-1] == 1
    assert any("is flagged from t = " in text for text in log.info["warnings"])


@pytest.mark.full
def test_runs_of_a_batch_stop_each_alone(nist):
    plants = [nist, plant(nist, kind="dropout"), plant(nist, 5, 1.0, kind="stuck"), nist]
    options = {"encoder_check": UNKNOWN, "stop_ramp": RAMP}
    runs = gk.simulate(nist, LAW, CIRCLE, plant=plants, lanes=1, **options)
    assert runs["failed"].tolist() == [0, 1, 1, 0] and runs["x_r"].ndim == 3
    for i, one in enumerate(plants):
        alone = gk.simulate(nist, LAW, CIRCLE, plant=one, **options)
        assert (runs.run(i).status, runs.run(i).reason) == (alone.status, alone.reason)
        assert runs.run(i).metrics == alone.metrics and len(runs.run(i)) == len(alone)
        for name in alone:
            assert_array_equal(runs.run(i)[name], alone[name], err_msg=name)
    assert runs.info["warnings"][0].startswith(
        "encoders are flagged in 2 of 4 runs; in run 1 the encoder of strut 2 is flagged from t = 0.6 s on"
    )
    only = gk.simulate(nist, LAW, CIRCLE, plant=plants, keep="metrics", **options)
    assert only.runs[1]["reason"].startswith("strut 2: its encoder") and only["failed"].tolist() == [0, 1, 1, 0]


@pytest.mark.full
def test_a_slower_law_is_stopped_as_well(nist):
    law = gk.PID(bandwidth=6.0, period=2e-3)
    log = gk.simulate(
        nist, law, CIRCLE, plant=plant(nist, start=0.601, kind="dropout"), encoder_check=UNKNOWN, stop_ramp=RAMP
    )
    assert log["stopping"].nonzero()[0][0] == 601 and log["contour_error"][601:].max() < 1e-4


def test_stops_and_flags_are_kept_in_files(nist, tmp_path):
    log = gk.simulate(nist, LAW, CIRCLE, plant=plant(nist, kind="dropout"), encoder_check=UNKNOWN, stop_ramp=RAMP)
    again = gk.Log.load(log.save(tmp_path / "a.nc"))
    assert again.reason == log.reason and again.dataset.equals(log.dataset)
    assert again.units("encoder_flag") == "1" and again.units("observer.encoder_residual") == "m"
    assert again.info["run"]["stop_ramp"] == "2.0 m/s2" and again.info["run"]["encoder_check"] == "1000.0 N"


def test_a_ramp_that_nothing_begins_is_refused(nist):
    cure = r"write encoder_check = \"1 kN\" or ferror = \"1 mm\" beside it"
    with pytest.raises(
        ExperimentError, match=rf"^run.stop_ramp: .* needs something that begins it, got 2 m/s2; {cure}"
    ):
        gk.simulate(nist, LAW, CIRCLE, stop_ramp=RAMP)
    for name in ("stop_ramp", "encoder_check"):
        with pytest.raises(ExperimentError, match=f"{name}: must be above 0"):
            gk.simulate(nist, LAW, CIRCLE, **{"encoder_check": 1.0, name: 0.0})


def test_the_error_of_a_flag_has_a_name(nist):
    with pytest.raises(EncoderError) as caught:
        gk.simulate(
            nist, LAW, CIRCLE, plant=plant(nist, kind="dropout"), encoder_check=UNKNOWN, stop_ramp=RAMP, on_fail="raise"
        )
    assert caught.value.exit_status == 1 and caught.value.log["stopping"].any()
