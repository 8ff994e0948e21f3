"""Envelopes against bisection by the machine's own checks, and against the shortest way to the end of a strut."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import minimize

import gough as gk
from gough.errors import ExperimentError, SingularityError, WorkspaceError
from gough.frames import abc_of_rotation_np, rotation_of_abc_np, rotation_of_vector_np
from gough.machine.drives import force_limit
from gough.machine.workspace import condition, random_poses

LIBRARY = ["nist-octahedral", "okuma-pm600", "eth-hexaglide", "ccu-3prs", "ifma-hsm", "emps"]
quick = pytest.mark.quick("ifma-hsm", "emps")


def inside(machine, x):
    """Whether poses (N, d) keep what an envelope is within, by other functions than it asks: the row function of the
    checks, LAPACK's condition number, the inverse dynamics at rest."""
    good = (machine.arrays.run("margins", machine.standing(x))[0] >= 0).all(-1)
    J = machine.jacobian(x[good])
    if x.shape[1] > 1:
        good[good] = condition(machine, J) <= machine.limits.condition
    F = force_limit(machine.drive)
    if F is not None and good.any():
        still = np.zeros_like(x[good])
        u, _ = machine.arrays.run("inverse_dynamics", x[good], still, still, np.zeros(6))
        good[good] = (np.abs(u) <= F).all(-1)
    return good


def bisected(machine, way, longest, step):
    """The first exit of way(s) by marching, and cutting in 40."""
    s = np.arange(0, longest, step)
    outside = ~inside(machine, way(s))
    if not outside.any():
        return np.inf
    low, high = s[outside.argmax() - 1], s[outside.argmax()]
    for _ in range(9):  # 40^9: to rounding
        cuts = np.linspace(low, high, 41)
        k = (~inside(machine, way(cuts[1:]))).argmax()
        low, high = cuts[k], cuts[k + 1]
    return low


def starts(machine):
    x = [np.asarray(machine.home, float)]
    if machine.limits.workspace is not None:
        x += list(random_poses(machine, 1, np.random.default_rng(8)))
    return x


@quick
@pytest.mark.parametrize("name", LIBRARY)
def test_every_way_ends_where_bisection_ends_it(name):
    machine = gk.load_machine(name)
    for x in starts(machine):
        found = gk.envelope(machine, x)
        assert len(found.ways) == 2 * len(x)
        for way in found.ways:
            i = [name.upper() for name, _ in machine.task].index(way.axis)
            ahead = way.sense * np.eye(len(x))[i]
            longest, step = (2.5, 2e-3) if way.unit == "m" else (np.pi, 3e-3)
            wanted = bisected(machine, lambda s, x=x, ahead=ahead: x + s[:, None] * ahead, longest, step)
            assert way.distance == pytest.approx(wanted, abs=1e-9), way


@quick
@pytest.mark.parametrize("name", LIBRARY)
def test_the_limit_named_is_the_one_that_is_met(name):
    """Just behind, its margin is the only negative one, or one of several that end together."""
    machine = gk.load_machine(name)
    for way in gk.envelope(machine).ways:
        x = np.array(machine.home, float)
        x[[name.upper() for name, _ in machine.task].index(way.axis)] += way.sense * (way.distance + 1e-9)
        margins = machine.arrays.run("margins", machine.standing(x[None]))[0][0]
        if way.limit in machine.limit_names:
            assert margins[machine.limit_names.index(way.limit)] < 0
        else:
            assert "cannot hold" in way.limit or "condition number" in way.limit
            assert (margins >= 0).all() and not inside(machine, x[None])[0]


def radius(machine, x, turned):
    """The least first exit over all directions: tried, then polished by Nelder and Mead from the best."""
    R = rotation_of_abc_np(x[3:]) if turned else None
    known = min(way.distance for way in gk.envelope(machine, x).ways if way.unit == ("rad" if turned else "m"))

    def at(d, s):
        rows = np.tile(x, (len(s), 1))
        if turned:
            rows[:, 3:] = abc_of_rotation_np(rotation_of_vector_np(s[:, None] * d) @ R)
        else:
            rows[:, :3] += s[:, None] * d
        return rows

    def exit_along(d):
        d = d / np.linalg.norm(d)
        return min(bisected(machine, lambda s: at(d, s), 1.3 * known, known / 20), 2 * known)

    d = np.random.default_rng(9).standard_normal((3000, 3))
    d /= np.linalg.norm(d, axis=1, keepdims=True)
    r = np.full(len(d), np.inf)
    for s in np.linspace(1.3, 0.05, 60) * known:
        r[~inside(machine, at(d, np.full(len(d), s)))] = s
    taken = []
    for i in np.argsort(r):
        if len(taken) < 3 and all(d[i] @ d[k] < 0.95 for k in taken):
            taken.append(i)
    options = {"xatol": 1e-7, "fatol": 1e-13, "maxiter": 400}
    return min(minimize(exit_along, d[i], method="Nelder-Mead", options=options).fun for i in taken)


@pytest.mark.full("ccu-3prs", "emps")
@pytest.mark.parametrize("name", LIBRARY[:-1])
def test_no_direction_leaves_the_ball_and_one_touches_it(name):
    machine = gk.load_machine(name)
    x = starts(machine)[-1]
    for ball in gk.envelope(machine, x).balls:
        assert ball.radius == pytest.approx(radius(machine, x, ball.kind == "turn"), abs=1e-9), ball


@pytest.mark.full
def test_the_ball_of_a_hexapod_that_only_its_stroke_bounds_is_what_is_left_of_the_nearest_strut():
    """|l(p + d) - l(p)| <= |d|, with equality along the strut: min over struts of longest - l, l - shortest."""
    machine = gk.load_machine("nist-octahedral")
    for x in random_poses(machine, 6, np.random.default_rng(10)):
        x[3:] = 0
        l = machine.inverse_kinematics(x)
        ball = gk.envelope(machine, x).balls[0]
        low, high = machine.limits.length
        assert ball.limit.endswith(("too long", "too short"))
        assert ball.radius == pytest.approx(min((l - low).min(), (high - l).min()), abs=1e-12)


@pytest.mark.full
@pytest.mark.parametrize("name", ["nist-octahedral", "eth-hexaglide"])
def test_the_direction_told_is_the_one_in_which_the_ball_touches(name):
    """Of turns the axis is in W: the pose turned is exp(r d) R, not R exp(r d)."""
    machine = gk.load_machine(name)
    x = starts(machine)[-1]
    for ball in gk.envelope(machine, x).balls:
        r, d = ball.radius + np.array([-1e-8, 1e-8]), np.array(ball.direction)
        rows = np.tile(x, (2, 1))
        if ball.kind == "turn":
            rows[:, 3:] = abc_of_rotation_np(rotation_of_vector_np(r[:, None] * d) @ rotation_of_abc_np(x[3:]))
        else:
            rows[:, :3] += r[:, None] * d
        assert inside(machine, rows).tolist() == [True, False]


def test_a_hybrid_machine_goes_along_its_ram_to_the_ends_of_the_ram():
    machine = gk.load_machine("ifma-hsm")
    found = {(way.axis, way.sense): way for way in gk.envelope(machine).ways}
    low, high = machine.limits.travel[2]
    assert found["Z", 1].distance == pytest.approx(high, abs=1e-12)
    assert found["Z", -1].distance == pytest.approx(-low, abs=1e-12)
    assert found["Z", 1].limit == "ram: beyond the end of its travel"
    assert gk.envelope(machine).balls[0].radius == pytest.approx(-low, abs=1e-12)


def test_an_envelope_within_the_declared_workspace_ends_at_it():
    machine = gk.load_machine("ifma-hsm")
    space, x = machine.limits.workspace, np.array(machine.home) + machine.limits.workspace.middle
    found = {(way.axis, way.sense): way for way in gk.envelope(machine, x, workspace=True).ways}
    # the edge itself counts as inside by 1e-9
    assert found["Z", 1].distance == pytest.approx(space.height / 2, abs=2e-9)
    assert found["Z", 1].limit == "beyond the height of the workspace"


def test_a_wrench_that_the_drives_cannot_hold_is_told_at_the_pose_itself():
    machine = gk.load_machine("ifma-hsm")
    with pytest.raises(WorkspaceError, match=r"the pose itself is outside: ram: the drive cannot hold the machine, "
                       r"got 30000 N \(limit 25000 N\); give a pose inside: home is one"):  # fmt: skip
        gk.envelope(machine, wrench=[0, 0, -30e3, 0, 0, 0])


def test_a_wrench_shortens_the_way_to_where_a_drive_is_at_its_limit():
    machine = gk.load_machine("ifma-hsm")
    w = np.array([0, -35e3, 0, 0, 0, 0.0])  # 42.7 kN with the weight, on two drives of 25 kN
    met = [way for way in gk.envelope(machine, wrench=w).ways if "cannot hold" in way.limit]
    assert met
    for way in met:
        i, still = ["X", "Y", "Z"].index(way.axis), np.zeros((2, 3))
        x = np.tile(machine.home, (2, 1))
        x[:, i] += way.sense * (way.distance + np.array([-1e-9, 1e-9]))
        joint = [name in way.limit for name in machine.joint_names].index(True)
        u = np.abs(machine.inverse_dynamics(x, still, still, w))[:, joint]
        assert u[0] < machine.drive.force_limit < u[1]


def test_a_pose_outside_its_limits_is_told_with_the_limit_and_by_how_much():
    machine = gk.load_machine("emps")
    with pytest.raises(WorkspaceError) as told:
        gk.envelope(machine, [0.4])
    assert str(told.value) == (
        "the pose itself is outside: carriage: beyond the end of its rail, got 0.4 m (limit 0.35 m); "
        "give a pose inside: home is one"
    )
    with pytest.raises(WorkspaceError, match="slide 1: cannot reach: misses by"):
        gk.envelope(gk.load_machine("ifma-hsm"), [-0.86, 0.1, 0])


def test_a_pose_on_a_limit_has_no_way_across_it():
    found = gk.envelope(gk.load_machine("emps"), [0.35])
    assert [way.distance for way in found.ways] == pytest.approx([0.0, 0.4], abs=1e-12)


def test_what_is_no_pose_of_the_machine_is_refused():
    machine = gk.load_machine("emps")
    for wrong, told in (([0, 0], "shape"), ([np.nan], "finite"), ([[0.0]], "one pose"), ("x", "real numbers")):
        with pytest.raises(ExperimentError, match=told):
            gk.envelope(machine, wrong)


@pytest.mark.full
def test_a_singular_pose_is_refused_as_one():
    machine = gk.load_machine("okuma-pm600")
    wide = machine.replace(limits=machine.limits.replace(condition=3.0, condition_warning=2.9))
    with pytest.raises(SingularityError, match="near a singularity: condition number of J, got"):
        gk.envelope(wide, np.array(machine.home) + [0.25, 0.1, 0, 0, 0, 0])


def test_an_envelope_prints_itself_and_goes_into_json():
    found = gk.envelope(gk.load_machine("emps"))
    assert repr(found).splitlines() == [
        "emps at x 0 mm, within joint limits",
        "  X+          350 mm  carriage: beyond the end of its rail",
        "  X-           50 mm  carriage: beyond the start of its rail",
    ]
    assert found.to_json()["ways"][0] == {
        "axis": "X", "sense": 1, "unit": "m", "distance": found.ways[0].distance,
        "limit": "carriage: beyond the end of its rail",
    }  # fmt: skip
