"""Bodies that can exist: the log-Cholesky numbers, and the nearest body to an estimate that is none."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from gough.errors import RunError
from gough.identify.bodies import bodies_of
from gough.identify.cholesky import log_cholesky, of_log_cholesky, of_pseudo_inertia, pseudo_inertia
from gough.identify.physical import physical_parameters
from gough.identify.regress import estimate
from gough.identify.rows import rows_of_motion
from gough.mechanics.bodies import check_inertia

from .motions import fourier, machine_of, planted, sampled

RNG = np.random.default_rng(7)


def cloud(points=30):
    """Ten numbers of point masses at random places, by their sums."""
    m, r = RNG.uniform(0.1, 2, points), RNG.normal(size=(points, 3))
    I = sum(mass * (p @ p * np.eye(3) - np.outer(p, p)) for mass, p in zip(m, r, strict=True))
    return np.array([m.sum(), *(m @ r), I[0, 0], I[1, 1], I[2, 2], I[0, 1], I[0, 2], I[1, 2]]), m, r


def test_the_pseudo_inertia_is_the_second_moment_of_the_mass():
    pi, m, r = cloud()
    homogeneous = np.column_stack([r, np.ones(len(m))])
    assert pseudo_inertia(pi) == pytest.approx(homogeneous.T @ (m[:, None] * homogeneous), rel=1e-12)


def test_the_log_cholesky_numbers_come_back_to_1e_10():
    for _ in range(200):
        pi = cloud(5)[0]
        J = pseudo_inertia(pi)
        assert of_pseudo_inertia(J) == pytest.approx(pi, rel=1e-12, abs=1e-12)
        lam = log_cholesky(J)
        assert lam.shape == (10,)
        again = of_log_cholesky(lam, 4)[0]
        assert np.abs(again - J).max() < 1e-10 * np.abs(J).max()
        assert np.abs(log_cholesky(again) - lam).max() < 1e-10


def test_no_log_cholesky_numbers_make_a_body_that_cannot_exist():
    """The mass and the principal moments about the centre of mass, looked at by the check of data sheets."""
    for lam in RNG.normal(scale=1.5, size=(300, 10)):
        pi = of_pseudo_inertia(of_log_cholesky(lam, 4)[0])
        m, c = pi[0], pi[1:4] / pi[0]
        I = np.array([[pi[4], pi[7], pi[8]], [pi[7], pi[5], pi[9]], [pi[8], pi[9], pi[6]]])
        assert m > 0
        check_inertia(I - m * (c @ c * np.eye(3) - np.outer(c, c)))


def test_the_derivatives_are_those_of_central_differences():
    lam = RNG.normal(size=10)
    slope = of_log_cholesky(lam, 4)[1]
    for k in range(10):
        step = 1e-6 * np.eye(10)[k]
        ahead, behind = of_log_cholesky(lam + step, 4)[0], of_log_cholesky(lam - step, 4)[0]
        assert np.abs((ahead - behind) / 2e-6 - slope[k]).max() < 1e-7


def test_the_bodies_of_the_library_can_exist_and_what_is_no_mass_is_no_body():
    for name, found in (
        ("nist-octahedral", ["platform", "strut.moving", "strut.fixed", "drive.m"]),
        ("eth-hexaglide", ["platform", "carriage.m"]),
    ):
        parameters = machine_of(name).parameters_of(friction=True)
        bodies = bodies_of(parameters.names)
        assert [body.name for body in bodies] == found
        assert all(body.least(parameters.values) > 0 for body in bodies)
        for body in bodies:
            if body.order > 1:
                back = body.made(log_cholesky(body.pseudo(parameters.values)))[0]
                assert back == pytest.approx(parameters.values[list(body.places)], rel=1e-10, abs=1e-10)


def found_with(noise, Ixx=None, seed=0):
    """An estimate of the hexaglide from forces of planted parameters, one of them changed, and noise of N rms."""
    machine = machine_of("eth-hexaglide")
    x, xd, xdd = sampled(machine, fourier(6))
    rows = rows_of_motion(machine, x, xd, xdd, np.zeros((len(x), 6)), ())
    truth = planted(machine, rows.names, share=0.05)
    if Ixx is not None:
        truth[rows.names.index("platform.Ixx")] = Ixx
    u = rows.Y @ truth + noise * np.random.default_rng(seed).standard_normal((len(x), 6))
    return estimate(dataclasses.replace(rows, u=u)), truth


def test_an_estimate_of_bodies_that_can_exist_is_the_answer_as_it_is():
    found, truth = found_with(0.1)
    physical = physical_parameters(found)
    assert physical.impossible == () and physical.away == 0
    assert np.array_equal(physical.values, found.full)


def test_the_nearest_body_can_exist_and_none_beside_it_is_nearer():
    """Ixx as of a body that cannot be: the forces ask for it, the answer is on the edge, and it is the least of all:
    no mixture with another body, which is a body too, comes nearer.  The set is convex, so that proves it."""
    found, _ = found_with(0.5, Ixx=1.0)
    physical = physical_parameters(found)
    (body, _) = bodies_of(found.rows.names)
    assert physical.impossible == ("platform",)
    assert body.least(found.full) < 0
    assert 0 <= body.least(physical.values) < 1e-4
    assert physical.away > 3

    def distance(pi):
        off = found.base.K @ pi - found.values
        return off @ np.linalg.solve(found.cov, off)

    least = distance(physical.values)
    assert least > 9
    rng = np.random.default_rng(1)
    for _ in range(300):
        other = physical.values.copy()
        lam = log_cholesky(body.pseudo(found.rows.values)) + rng.normal(scale=0.5, size=10)
        other[list(body.places)] = body.made(lam)[0]
        for share in (1e-4, 1e-2, 0.3):
            mixed = (1 - share) * physical.values + share * other
            assert distance(mixed) > least - 1e-6 * least


def test_the_answer_is_told_in_log_cholesky_numbers_as_well():
    found, _ = found_with(0.5, Ixx=1.0)
    physical = physical_parameters(found)
    J = of_log_cholesky(physical.log_cholesky["platform"], 4)[0]
    assert of_pseudo_inertia(J) == pytest.approx(physical.values[:10], rel=1e-9, abs=1e-9)


def test_a_body_held_where_none_can_exist_is_refused():
    """With all but Ixx held, no Ixx makes the rest a body."""
    found, _ = found_with(0.5, Ixx=1.0)
    held = np.array([name == "platform.Ixx" for name in found.rows.names])
    rows = dataclasses.replace(found.rows, values=np.where(held, 1.0, found.rows.values))
    with pytest.raises(
        RunError, match="platform: the sheet's values are no body's, and some are held; let free name all"
    ):
        physical_parameters(dataclasses.replace(found, rows=rows, free=held, full=rows.values))
