"""What a machine can do, against every direction tried one by one with the machine's own motions and forces."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import minimize

import gough as gk
from gough.machine.drives import force_limit
from gough.machine.workspace import condition, random_poses
from gough.plan.abilities import Evaluated, accelerations, feeds, forces

LIBRARY = ["nist-octahedral", "eth-hexaglide", "ccu-3prs", "ifma-hsm", "emps"]
quick = pytest.mark.quick("ifma-hsm")


def poses(machine, count):
    if machine.limits.workspace is None:
        return np.random.default_rng(3).uniform(*machine.limits.travel, (count, 1))
    return random_poses(machine, count, np.random.default_rng(3))


def blocks(machine):
    d = len(machine.task)
    return [slice(0, min(d, 3)), slice(3, 6)][: 1 + (d == 6)]


def directions(count, k):
    d = np.random.default_rng(4).standard_normal((count, k))
    return d / np.linalg.norm(d, axis=-1, keepdims=True)


def least_over_directions(value, k):
    """min over unit d (k,) of value(d (N, k)) -> (N,): tried all over, then polished from the best."""
    d = directions(400, k)
    first = value(d)
    if k == 1:
        return first.min()

    def one(y):
        return value((y / np.linalg.norm(y))[None])[0]

    options = {"xatol": 1e-8, "fatol": 1e-14, "maxiter": 2000}
    ends = [minimize(one, d[i], method="Nelder-Mead", options=options).fun for i in np.argsort(first)[:4]]
    return min(ends)


def embedded(machine, x, block, d):
    xd = np.zeros((len(d), len(machine.task)))
    xd[:, block] = d
    return np.broadcast_to(x, xd.shape), xd, np.zeros_like(xd)


def limits_of(machine):
    bounds = (machine.limits.speed, machine.limits.acceleration, force_limit(machine.drive))
    return [np.inf if one is None else one for one in bounds]


@pytest.mark.quick("all-emps")
@pytest.mark.parametrize("name", LIBRARY)
@pytest.mark.parametrize("by", ["all", "acceleration", "force"])
def test_no_direction_exceeds_a_limit_below_the_feed_and_one_does_above_it(by, name):
    """Joint speeds, accelerations and forces of moving at 1 along d, scaled: q' by V, q'' and u - u_0 by V^2.

    By all limits it is mostly the speed that counts; so also without that one, and without the acceleration's.
    """
    machine = gk.load_machine(name)
    if by != "all":
        free = {"speed": None} | ({"acceleration": None} if by == "force" else {})
        machine = machine.replace(limits=machine.limits.replace(**free))
    S, A, F = limits_of(machine)
    for x in poses(machine, 2):
        zero = np.zeros((1, len(machine.task)))
        u_0 = machine.inverse_dynamics(x[None], zero, zero)[0]

        def fastest(d, x=x, u_0=u_0, block=None):
            rows, xd, still = embedded(machine, x, block, d)
            _, qd, qdd = machine.joint_motion(rows, xd, still)
            C = machine.inverse_dynamics(rows, xd, still) - u_0
            with np.errstate(divide="ignore"):
                room = np.where(C > 0, F - u_0, F + u_0) / np.abs(C)
                return np.minimum(np.minimum(S / np.abs(qd), np.sqrt(A / np.abs(qdd))), np.sqrt(room)).min(-1)

        for k, block in enumerate(blocks(machine)):
            width = len(range(*block.indices(6)))
            wanted = least_over_directions(lambda d, block=block: fastest(d, block=block), width)
            # 1e-9: the polishing's share of the error, quadratic in an angle of 1e-5 and less
            found = feeds(machine, x[None])[0][0, k].min()
            assert found == pytest.approx(wanted, rel=1e-9)
            assert np.isfinite(found) or name == "emps"  # an axis that nothing bends and nothing drives


@pytest.mark.quick("emps")
@pytest.mark.parametrize("name", LIBRARY)
def test_no_direction_exceeds_a_limit_below_the_acceleration_and_one_does_above_it(name):
    machine = gk.load_machine(name)
    _, A, F = limits_of(machine)
    for x in poses(machine, 2):
        zero = np.zeros((1, len(machine.task)))
        u_0 = machine.inverse_dynamics(x[None], zero, zero)[0]

        def hardest(d, x=x, u_0=u_0, block=None):
            rows, xdd, still = embedded(machine, x, block, d)
            qdd = machine.joint_motion(rows, still, xdd)[2]
            G = machine.inverse_dynamics(rows, still, xdd) - u_0
            with np.errstate(divide="ignore"):
                room = np.where(G > 0, F - u_0, F + u_0) / np.abs(G)
                return np.minimum(A / np.abs(qdd), room).min(-1)

        for k, block in enumerate(blocks(machine)):
            width = len(range(*block.indices(6)))
            wanted = least_over_directions(lambda d, block=block: hardest(d, block=block), width)
            assert accelerations(machine, x[None])[0, k].min() == pytest.approx(wanted, rel=1e-9)


@quick
@pytest.mark.parametrize("name", LIBRARY[:-1])
def test_the_drives_hold_every_force_of_that_size_and_no_larger_one(name):
    machine = gk.load_machine(name)
    F = force_limit(machine.drive)
    for x in poses(machine, 2):
        zero = np.zeros((1, len(machine.task)))
        u_0 = machine.inverse_dynamics(x[None], zero, zero)[0]

        def largest(d, x=x, u_0=u_0):
            rows, still, _ = embedded(machine, x, slice(0, 3), np.zeros_like(d))
            w = np.concatenate([d, np.zeros_like(d)], 1)
            K = machine.inverse_dynamics(rows, still, still, w) - u_0
            with np.errstate(divide="ignore"):
                return (np.where(K > 0, F - u_0, F + u_0) / np.abs(K)).min(-1)

        u, r = forces(machine, x[None])
        np.testing.assert_allclose(u[0], u_0, rtol=1e-9, atol=1e-9)
        assert r.min() == pytest.approx(least_over_directions(largest, 3), rel=1e-9)


@quick
@pytest.mark.parametrize("name", LIBRARY[:-1])
def test_the_dexterity_is_the_condition_number_that_runs_are_checked_by(name):
    machine = gk.load_machine(name)
    x = poses(machine, 200)
    least, greatest = Evaluated("dexterity", machine)(x)[0].T
    np.testing.assert_allclose(greatest / least, condition(machine, machine.jacobian(x)), rtol=1e-11)


def test_a_drive_that_cannot_hold_the_weight_has_no_feed_no_acceleration_and_no_force():
    machine = gk.load_machine("ifma-hsm")
    weak = machine.replace(drive=machine.drive.replace(force_limit=100.0))
    x = machine.home[None]
    assert feeds(weak, x)[0].min() == 0 and accelerations(weak, x).min() == 0 and forces(weak, x)[1].min() == 0


def test_an_axis_goes_as_fast_as_its_carriage():
    machine = gk.load_machine("emps")
    assert feeds(machine, np.array([[0.1]]))[0].min() == pytest.approx(machine.limits.speed)
    assert accelerations(machine, np.array([[0.1]])).min() == pytest.approx(machine.limits.acceleration)
