"""The 3-PRS against Lagrange's equations with multipliers of all its bodies: accelerations and forces in the joints."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from gough.machine.sheet import load_machine
from gough.machine.workspace import random_poses
from oracle.maximal import Maximal


def oblique():
    """ccu-3prs with nothing left at zero: leaning rails, a platform of any shape, gravity askew."""
    m = load_machine("ccu-3prs")
    rng = np.random.default_rng(5)
    direction = m.rails.direction + rng.normal(size=(3, 3)) * 0.05
    direction /= np.linalg.norm(direction, axis=1)[:, None]
    across = m.rails.across + rng.normal(size=(3, 3)) * 0.03
    across -= direction * (across * direction).sum(1)[:, None]
    across /= np.linalg.norm(across, axis=1)[:, None]
    body = m.platform.replace(
        center=[0.03, -0.02, 0.22], inertia=[[1.2, 0.1, -0.2], [0.1, 1.4, 0.15], [-0.2, 0.15, 1.0]]
    )
    return m.replace(
        name="oblique", gravity=[1.5, -2.5, -9.0], platform=body,
        **{
            "rails.direction": direction, "rails.across": across, "limits.angle": [0.8, 1.56], "limits.workspace": None,
            "joints.platform": m.joints.platform + rng.normal(size=(3, 3)) * 0.02, "limits.cone": None,
            "limits.travel": [0.0, 1.0],
        },
    )  # fmt: skip


MACHINES = {"ccu-3prs": lambda: load_machine("ccu-3prs"), "oblique": oblique}


@pytest.fixture(params=MACHINES, scope="module")
def case(request):
    m = MACHINES[request.param]()
    rng = np.random.default_rng(11)
    library = load_machine("ccu-3prs")
    x = m.home + 0.5 * (random_poses(library, 60, rng) - library.home)
    v, u = rng.normal(size=(60, 3)) * 0.4, rng.normal(size=(60, 3)) * 800
    w = rng.normal(size=(60, 6)) * [500, 500, 500, 50, 50, 50]
    return m, Maximal(m), x, v, u, w


@pytest.mark.quick("oblique")
def test_the_sliders_stand_where_nine_constraints_put_them(case):
    m, oracle, x, *_ = case
    for row, q in zip(x, m.inverse_kinematics(x), strict=True):
        assert_allclose(q, oracle.stand(row)[0], rtol=0, atol=1e-13)


@pytest.mark.quick("oblique")
def test_accelerations_are_those_of_lagranges_equations_with_multipliers(case):
    m, oracle, x, v, u, w = case
    found = m.forward_dynamics(x, v, u, w)
    wanted = np.array([oracle.solve(*row).acceleration[6:9] for row in zip(x, v, u, w, strict=True)])
    # rounding: the condition of both systems is some 1e3
    assert_allclose(found, wanted, rtol=0, atol=1e-11 * np.abs(wanted).max())


@pytest.mark.quick("oblique")
def test_forces_in_the_spherical_joints_are_the_multipliers_of_the_joints_themselves(case):
    """Three multipliers of the closure, by eq. (7) of tripod_reactions.py, against nine of the cut joints."""
    m, oracle, x, v, u, w = case
    found = m.reactions(x, v, m.forward_dynamics(x, v, u, w), w).platform_joint
    wanted = np.array([oracle.solve(*row).force for row in zip(x, v, u, w, strict=True)])
    assert_allclose(found, wanted, rtol=0, atol=1e-10 * np.abs(wanted).max())


@pytest.mark.quick("oblique")
def test_inverse_dynamics_give_back_the_forces_of_the_sliders(case):
    m, oracle, x, v, u, w = case
    xdd = np.array([oracle.solve(*row).acceleration[6:9] for row in zip(x, v, u, w, strict=True)])
    assert_allclose(m.inverse_dynamics(x, v, xdd, w), u, rtol=0, atol=1e-10 * np.abs(u).max())
