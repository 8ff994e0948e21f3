"""Elastic joints: what their numbers say, what of them is refused, and what elements in series make."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest
from numpy.testing import assert_allclose

from gough.errors import SheetError
from gough.mechanics.compliance import Compliance, Springs, in_series


def test_one_number_is_a_stiffness_alike_in_all_translations_and_rigid_against_turns():
    C, E = Compliance(joint="j", stiffness=4e8, beta=1e-4).matrices()
    assert_allclose(C, np.diag([2.5e-9] * 3 + [0] * 3))
    assert_allclose(E, 1e-4 * C)


def test_damping_by_number_is_what_the_matrices_dissipate_at_one_force():
    """E = C D C: with F held sinusoidal, d' D d' of the same amplitude."""
    K, D = np.array([8e8, 5e8, 7e8, 1e6, 2e6, 3e6]), np.array([1e4, 2e4, 3e4, 10, 20, 30])
    _, E = Compliance(joint="j", stiffness=K, damping=D).matrices()
    assert_allclose(E, np.diag(D / K**2))


def test_a_damping_ratio_at_a_frequency_is_that_of_a_mass_on_the_spring():
    one = Compliance(joint="j", stiffness=2e8, damping_ratio=0.02, frequency=49.0)
    mass = 2e8 / (2 * np.pi * 49.0) ** 2
    assert_allclose(one.time * 2e8 / (2 * np.sqrt(2e8 * mass)), 0.02)


def test_a_full_stiffness_is_its_blocks_and_compliance_its_inverse():
    rng = np.random.default_rng(3)
    A = rng.normal(size=(6, 6))
    K = A @ A.T + 6 * np.eye(6)
    one = Compliance(joint="j", translation=K[:3, :3], coupling=K[:3, 3:], rotation=K[3:, 3:])
    assert_allclose(one.spring()[0], K)
    assert_allclose(one.matrices()[0] @ K, np.eye(6), atol=1e-12)


# -- what is refused ---------------------------------------------------------------------------------------------------


def refusal(**numbers):
    with pytest.raises(SheetError) as caught:
        Compliance(joint="slide 1", **numbers)
    return str(caught.value)


def test_a_stiffness_that_is_not_positive_definite_is_refused_with_its_eigenvalue():
    assert refusal(stiffness=[8e8, -1e8, 8e8]) == (
        "stiffness: a stiffness must be positive definite: every eigenvalue above 0, got least eigenvalue -1e+08 N/m; "
        "check the signs and the size of what couples; leave a rigid joint out"
    )
    twisted = np.array([[1e6, 0, 2e6], [0, 1e6, 0], [2e6, 0, 1e6]])
    assert "least eigenvalue -1e+06 N m/rad" in refusal(translation=1e8 * np.eye(3), rotation=twisted)
    # each block alone is sound, what couples them is too large: 1e8 x 1e6 < (2e7)^2; (101 - sqrt(99^2 + 4 x 20^2)) / 2
    assert "least eigenvalue -2.888e+06" in refusal(
        translation=1e8 * np.eye(3), rotation=1e6 * np.eye(3), coupling=2e7 * np.eye(3)
    )


def test_a_stiffness_that_is_not_symmetric_is_refused():
    assert refusal(translation=[[1e8, 1e7, 0], [0, 1e8, 0], [0, 0, 1e8]], rotation=np.eye(3)) == (
        "translation: a stiffness must be symmetric; give Kxy = Kyx and so on"
    )


def test_stiffness_is_said_once_and_in_one_three_or_six_numbers():
    assert refusal() == (
        "stiffness: needs one stiffness; give stiffness (1, 3 or 6 numbers), or translation and rotation (3 x 3 each)"
    )
    assert refusal(stiffness=[1e8, 1e8]) == "stiffness: has one, three or six numbers, got 2"
    assert refusal(translation=np.eye(3)) == "rotation: is missing; translation and rotation belong together"
    assert "needs one stiffness" in refusal(stiffness=1e8, translation=np.eye(3), rotation=np.eye(3))


def test_damping_is_said_once_and_with_as_many_numbers():
    assert refusal(stiffness=1e8, damping=[1.0, 2.0, 3.0]) == (
        "damping: needs as many numbers as stiffness has, 1; give beta, or damping_ratio and frequency"
    )
    assert refusal(stiffness=1e8, damping=1.0, beta=1e-4) == "beta: damping already says it; leave one of them out"
    assert refusal(stiffness=1e8, damping_ratio=0.02) == (
        "frequency: is missing; a damping ratio holds at a frequency: give both"
    )
    assert refusal(stiffness=1e8, damping=-1.0) == "damping: must be at least 0 N s/m, got -1 N s/m"
    assert refusal(stiffness=float("nan")) == "stiffness: must be finite, got nan"


def test_a_file_gives_every_number_its_unit_and_gets_it_back():
    one = Compliance.from_file({"joint": "slides", "stiffness": [
        "800 N/um", "1.2e9 N/m", "8e8 N/m", "2e6 N m/rad", "2e7 N m/rad", "1e8 N m/rad"]})  # fmt: skip
    assert_allclose(one.stiffness, [8e8, 1.2e9, 8e8, 2e6, 2e7, 1e8])
    assert Compliance.from_file(one.to_file()) == one
    three = Compliance.from_file({"joint": "j", "stiffness": {"unit": "N/um", "value": [1, 2, 3]}})
    assert_allclose(three.stiffness, [1e6, 2e6, 3e6])
    with pytest.raises(SheetError, match="is not a unit of"):  # one unit cannot be that of forces and moments
        Compliance.from_file({"joint": "j", "stiffness": {"unit": "N/m", "value": [1, 2, 3, 4, 5, 6]}})
    with pytest.raises(SheetError, match="has no unit"):
        Compliance.from_file({"joint": "j", "stiffness": 1e8})


# -- in series ---------------------------------------------------------------------------------------------------------


def series_of(springs, ratio, force):
    found = in_series(springs, springs, ratio, lambda place: (ca.DM(force), None))
    return [None if part is None else np.array(ca.DM(part)).ravel() for part in found]


def test_springs_in_series_add_their_compliance_and_elements_of_one_beta_keep_it():
    beta = 2e-4
    springs = Springs(constant=[1 / 4e8 + 2 / 8e8], constant_loss=[beta * (1 / 4e8 + 2 / 8e8)])
    c, e = series_of(springs, [1.0], np.zeros((3, 1)))
    assert_allclose(1 / c, 2e8)  # 1/400 + 1/800 + 1/800 = 1/200
    assert_allclose(e / c**2, beta * 2e8)


def test_a_joint_gives_way_by_the_force_across_its_axes_and_by_its_lever():
    """k by hand: force 1 N along n on a spring at r behind the joint: n' Ct n + (n x r)' Cr (n x r)."""
    K, r, n = np.array([8e8, 5e8, 7e8, 1e6, 2e6, 3e6]), np.array([0.1, -0.2, 0.05]), np.array([0.6, 0, 0.8])
    entry = Compliance(joint="j", stiffness=K, beta=1e-4, center=r)
    C, E = entry.matrices()
    springs = Springs(
        constant=[0.0], places=("joint",), full=C.reshape(1, 36), full_loss=E.reshape(1, 36), center=r.reshape(1, 3)
    )
    c, e = series_of(springs, None, n.reshape(3, 1))
    lever = np.cross(n, r)
    assert_allclose(c, (n**2 / K[:3]).sum() + (lever**2 / K[3:]).sum())
    assert_allclose(e, 1e-4 * c)


def test_dampers_of_different_springs_in_series_agree_to_first_order_in_the_frequency():
    """True: c(s) = sum of 1 / (k_j + d_j s); here 1 / (k + d s).  Halving s must quarter what they differ by."""
    k, d = np.array([4e8, 8e8, 2e8]), np.array([3e4, 1e3, 6e4])
    c, e = (1 / k).sum(), (d / k**2).sum()
    springs = Springs(constant=[c], constant_loss=[e])
    found_c, found_e = series_of(springs, None, np.zeros((3, 1)))
    K, D = 1 / found_c[0], found_e[0] / found_c[0] ** 2

    def off(s):
        return abs((1 / (k + d * s)).sum() - 1 / (K + D * s))

    s = 2j * np.pi * 20
    assert 3.9 < off(s) / off(s / 2) < 4.1
    assert off(s) < 1e-3 * c
