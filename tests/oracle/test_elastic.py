"""Modes and compliance of flexible machines against a linear assembly of bodies, springs and constraints in NumPy.

Gravity is left out of both: the assembly knows nothing of the stiffness that forces in the legs make.
"""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

import gough as gk
from gough.frames import rotation_of_abc_np

from . import elastic_assembly as fe

pytestmark = pytest.mark.full

# both are solved in double precision, with condition numbers of some 1e4; a wrong lever or axis is off by percents
AGREE = 1e-9
SLIDES = np.diag([8e8, 1.2e9, 8e8, 2.8286e6, 2e7, 1.5e8])


def agree(found, wanted):
    return np.abs(found - wanted).max() / np.abs(wanted).max() < AGREE


@pytest.mark.parametrize("x", [[0, 1.2, 0], [0, 1.5, 0.275], [-0.315, 1.83, 0.55]])
def test_the_hybrid_machine_with_elastic_slides_is_seven_bodies_on_two_springs(x):
    m = gk.load_machine("ifma-hsm").replace(gravity=[0, 0, 0.0])
    wanted, f = fe.hybrid(m, np.array(x), SLIDES), m.flexible()
    assert_allclose(f.modes(x).frequency, wanted.frequencies(), rtol=AGREE)
    assert agree(f.tool_compliance(x), wanted.compliance("ram"))


def test_a_full_stiffness_with_coupling_is_that_of_the_assembly():
    rng = np.random.default_rng(7)
    scale = np.sqrt(np.diag(SLIDES))
    mixed = rng.normal(size=(6, 6))
    K = np.outer(scale, scale) * (np.eye(6) + 0.08 * (mixed + mixed.T))
    entry = {"joint": "slides", "translation": K[:3, :3], "coupling": K[:3, 3:], "rotation": K[3:, 3:]}
    m = gk.load_machine("ifma-hsm").replace(gravity=[0, 0, 0.0], compliance=[entry])
    x = np.array([0.1, 1.4, 0.2])
    wanted, f = fe.hybrid(m, x, K), m.flexible()
    assert_allclose(f.modes(x).frequency, wanted.frequencies(), rtol=AGREE)
    assert agree(f.tool_compliance(x), wanted.compliance("ram"))


@pytest.fixture(scope="module")
def nist():
    joints = [
        {"joint": "struts", "stiffness": 4e8},
        {"joint": "base joints", "stiffness": [8e8, 5e8, 7e8]},
        {"joint": "platform joints", "stiffness": [9e8, 8e8, 4e8]},
    ]
    return gk.load_machine("nist-octahedral").replace(gravity=[0, 0, 0.0], compliance=joints)


POSE = np.array([0.1, 0.05, 0.02, 0.1, -0.1, 0.2])


def struts(nist, masses):
    stiffness = np.tile([8e8, 5e8, 7e8], (6, 1)), np.full(6, 4e8), np.tile([9e8, 8e8, 4e8], (6, 1))
    return fe.hexapod(nist, nist.home + POSE, rotation_of_abc_np(POSE[3:]), *stiffness, masses)


def test_struts_without_mass_are_condensed_exactly(nist):
    light = nist.replace(strut=None, friction=None, **{"joints.friction": None})
    wanted, f = struts(nist, False), light.flexible()
    assert_allclose(f.modes(nist.home + POSE).frequency, wanted.frequencies(), rtol=AGREE)
    assert agree(f.tool_compliance(nist.home + POSE), wanted.compliance("platform"))


def test_struts_with_mass_lose_little_by_condensation_in_the_low_modes(nist):
    """150 kg a strut that may also swing on its joints, against legs that only push: docs/theory/compliance.md, 2."""
    found, wanted = nist.flexible().modes(nist.home + POSE).frequency, struts(nist, True).frequencies()
    off = found / wanted[:6] - 1
    # the first mode of a strut on its joints alone is near 400 Hz: (27, 42, 67 Hz / 400 Hz)^2 and their share of mass
    assert (np.abs(off[:3]) < 0.005).all() and (np.abs(off) < 0.08).all()
    # statics know no mass
    assert agree(nist.flexible().tool_compliance(nist.home + POSE), struts(nist, True).compliance("platform"))


def test_a_hexaglide_on_guides_with_levers_is_condensed_exactly():
    scale, mixed = np.sqrt([1e9, 8e8, 6e8, 4e6, 3e6, 5e6]), np.random.default_rng(5).normal(size=(6, 6))
    guide = np.outer(scale, scale) * (np.eye(6) + 0.1 * (mixed + mixed.T))  # coupled, so that a lever's sign is seen
    center = np.array([0.02, 0.05, 0.1])
    blocks = {"translation": guide[:3, :3], "coupling": guide[:3, 3:], "rotation": guide[3:, 3:]}
    joints = [
        {"joint": "legs", "stiffness": 1.5e8},
        {"joint": "guides", **blocks, "center": center},
        {"joint": "carriage joints", "stiffness": [3e8, 4e8, 5e8]},
    ]
    m = gk.load_machine("eth-hexaglide").replace(gravity=[0, 0, 0.0], compliance=joints)
    x = m.home + POSE * [1, 1, 1, 1, 1, 0.5]
    wanted, f = fe.hexaglide(m, x, rotation_of_abc_np(x[3:]), guide, center, 1.5e8, [3e8, 4e8, 5e8]), m.flexible()
    assert_allclose(f.modes(x).frequency, wanted.frequencies(), rtol=AGREE)
    assert agree(f.tool_compliance(x), wanted.compliance("platform"))
