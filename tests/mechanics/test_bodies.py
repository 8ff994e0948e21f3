"""Rigid bodies: Steiner's rule, joined masses, the wrench of a motion; and what no body is like (P1, P2)."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest
from numpy.testing import assert_allclose

from gough.errors import InputError, SheetError
from gough.mechanics.bodies import Body, check_inertia, first_moments, rigid_wrench


def cloud(rng, n=12):
    """Point masses (kg) and their places (m): the oracle of every inertia."""
    return rng.uniform(0.5, 3, n), rng.normal(size=(n, 3))


def moments(masses, places, about):
    """Inertia of point masses about a point, by the sum of its definition."""
    I = np.zeros((3, 3))
    for m, r in zip(masses, places - about, strict=True):
        I += m * (r @ r * np.eye(3) - np.outer(r, r))
    return I


def body_of(masses, places):
    center = masses @ places / masses.sum()
    return Body(mass=float(masses.sum()), center=center, inertia=moments(masses, places, center))


def test_first_moments_are_those_of_the_mass_points_about_the_origin():
    m, r = cloud(np.random.default_rng(0))
    total, mc, I = first_moments(body_of(m, r))
    assert total == pytest.approx(m.sum(), rel=1e-15)
    assert_allclose(np.array(mc).ravel(), m @ r, rtol=1e-13)
    assert_allclose(np.array(ca.DM(I)), moments(m, r, np.zeros(3)), rtol=1e-13, atol=1e-13)


def test_a_joined_point_mass_is_one_more_point():
    rng = np.random.default_rng(1)
    m, r = cloud(rng)
    extra, place = 7.5, np.array([0.4, -1.2, 0.3])
    joined = body_of(m, r).joined(extra, place)
    wanted = body_of(np.append(m, extra), np.vstack([r, place]))
    assert joined.mass == pytest.approx(wanted.mass, rel=1e-15)
    assert_allclose(joined.center, wanted.center, rtol=1e-13)
    assert_allclose(joined.inertia, wanted.inertia, rtol=1e-12, atol=1e-12)


def test_a_mass_joined_at_the_centre_adds_no_inertia():
    m, r = cloud(np.random.default_rng(2))
    body = body_of(m, r)
    assert_allclose(body.joined(100.0, body.center).inertia, body.inertia, rtol=1e-13)


def test_rigid_wrench_is_the_sum_over_the_mass_points():
    """f = sum m a, n = sum r x m a with a = a_O + w' x r + w x (w x r)."""
    rng = np.random.default_rng(3)
    m, r = cloud(rng)
    a_O, w, wd = rng.normal(size=(3, 3))
    a = a_O + np.cross(wd, r) + np.cross(w, np.cross(w, r))
    wanted = np.r_[m @ a, (m[:, None] * np.cross(r, a)).sum(0)]
    total, mc, I = first_moments(body_of(m, r))
    found = rigid_wrench(total, ca.DM(mc), ca.DM(I), ca.DM(w), ca.DM(a_O), ca.DM(wd))
    assert_allclose(np.array(found).ravel(), wanted, rtol=1e-12)


PLATE = {"mass": 10.0, "center": [0.0, 0.0, 0.0], "inertia": np.diag([1.0, 2.0, 2.5])}


@pytest.mark.parametrize(
    ("mass", "message"),
    [
        (0.0, r"^mass: must be above 0 kg, got 0 kg$"),
        (-1.0, r"^mass: must be above 0 kg, got -1 kg$"),
        (float("nan"), r"^mass: must be finite, got nan$"),
        (float("inf"), r"^mass: must be finite, got inf$"),
        (True, r"^mass: must be a quantity, got true$"),
        ([1.0], r"^mass: must have shape a single value"),
    ],
)
def test_p1_a_mass_must_be_a_finite_number_above_zero(mass, message):
    with pytest.raises(SheetError, match=message):
        Body(**PLATE | {"mass": mass})


def test_p2_an_asymmetric_inertia_is_refused_though_cholesky_would_take_it():
    I = np.array([[2.0, 0.5, 0.0], [0.1, 2.0, 0.0], [0.0, 0.0, 2.0]])
    np.linalg.cholesky(I)  # does not raise
    with pytest.raises(
        SheetError, match=r"inertia must be symmetric, got \[\[2\.0, 0\.5, 0\.0\].*; give Ixy = Iyx and so on"
    ):
        Body(**PLATE | {"inertia": I})


@pytest.mark.parametrize("moment", [0.0, -1.0])
def test_p2_an_inertia_that_is_not_positive_definite_is_refused_with_its_principal_moments(moment):
    with pytest.raises(
        SheetError, match=rf"inertia must be positive definite, got principal moments {moment:.4g}, 2, 2 kg m2"
    ):
        Body(**PLATE | {"inertia": np.diag([2.0, moment, 2.0])})


def test_p2_an_inertia_against_the_triangle_inequality_is_refused_with_the_numbers():
    with pytest.raises(
        SheetError, match=r"violates the triangle inequality A \+ B >= C, got 1 \+ 1 < 5 kg m2; it must be about"
    ):
        Body(**PLATE | {"inertia": np.diag([1.0, 5.0, 1.0])})
    check_inertia(np.diag([1.0, 1.0, 2.0]))  # a flat plate reaches equality


def test_p2_the_inequality_is_of_principal_moments_not_of_the_diagonal():
    """Turned by 45 deg the same wrong body has a harmless diagonal."""
    c = np.sqrt(0.5)
    R = np.array([[c, -c, 0], [c, c, 0], [0, 0, 1]])
    I = R @ np.diag([1.0, 5.0, 1.0]) @ R.T
    assert I[0, 0] + I[2, 2] > I[1, 1]
    with pytest.raises(InputError, match="triangle inequality"):
        check_inertia(I)


def test_every_inertia_of_mass_points_is_accepted():
    rng = np.random.default_rng(4)
    for _ in range(200):
        m, r = cloud(rng, 4)
        check_inertia(moments(m, r, m @ r / m.sum()))


def test_replace_makes_a_new_body_and_leaves_the_old_one_alone():
    body = Body(**PLATE)
    heavy = body.replace(mass=20.0)
    assert (body.mass, heavy.mass) == (10.0, 20.0)
    with pytest.raises(ValueError, match="read-only"):
        body.inertia[0, 0] = 5.0
