"""The plant: what its payload and its changes do to the machine."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

import gough as gk
from gough.frames import rotation_of_abc_np


@pytest.fixture(scope="module")
def nist():
    return gk.load_machine("nist-octahedral")


def test_a_payload_hangs_where_it_is_said_to(nist):
    """At rest it adds its weight at its place: force m g and moment p x m g about the tip."""
    place = np.array([0.1, -0.05, 0.2])
    x = np.concatenate([[0.02, 0.03, -0.01], [0.1, 0.15, -0.2]])
    loaded = gk.Plant(machine=nist, payload=30.0, payload_center=place).true_machine
    rest = np.zeros(6)
    added = nist.jacobian(x).T @ (loaded.inverse_dynamics(x, rest, rest) - nist.inverse_dynamics(x, rest, rest))
    force = np.array([0, 0, 30.0 * 9.81])  # what the struts must give
    p_W = rotation_of_abc_np(x[3:]) @ place
    assert_allclose(added, np.concatenate([force, np.cross(p_W, force)]), rtol=1e-10, atol=1e-9)


def test_a_payload_resists_acceleration_like_a_point_mass(nist):
    place, x = np.array([0.1, -0.05, 0.2]), nist.home
    loaded = gk.Plant(machine=nist.replace(gravity=[0, 0, 0.0]), payload=30.0, payload_center=place).true_machine
    bare = nist.replace(gravity=[0, 0, 0.0])
    xd, xdd = np.array([0.1, 0.2, -0.1, 0.3, -0.2, 0.4]), np.array([1.0, -2.0, 0.5, 1.5, 0.7, -0.9])
    w, wd = xd[3:], xdd[3:]
    a = xdd[:3] + np.cross(wd, place) + np.cross(w, np.cross(w, place))
    added = bare.jacobian(x).T @ (loaded.inverse_dynamics(x, xd, xdd) - bare.inverse_dynamics(x, xd, xdd))
    assert_allclose(added, np.concatenate([30 * a, np.cross(place, 30 * a)]), rtol=1e-10, atol=1e-9)


def test_the_payloads_place_is_in_t_whatever_frame_the_sheet_uses(nist):
    """The same machine told in a frame P of its own, shifted and turned from T."""
    p_PT, abc = np.array([0.03, -0.02, -0.15]), np.array([0.2, -0.3, 0.4])
    R_PT = rotation_of_abc_np(abc)
    told = nist.replace(
        **{
            "joints.platform": p_PT + nist.joints.platform @ R_PT.T,
            "platform.center": p_PT + R_PT @ nist.platform.center,
            "platform.inertia": R_PT @ nist.platform.inertia @ R_PT.T,
        },
        tool={"position": p_PT, "angles": abc},
    )
    x, place = nist.home + 0.01, np.array([0.1, -0.05, 0.2])
    motion = np.array([0.1, 0.2, -0.1, 0.3, -0.2, 0.4]), np.array([1.0, -2.0, 0.5, 1.5, 0.7, -0.9])
    forces = [
        gk.Plant(machine=m, payload=30.0, payload_center=place).true_machine.inverse_dynamics(x, *motion)
        for m in (nist, told)
    ]
    assert_allclose(forces[1], forces[0], rtol=1e-9)


def test_a_payload_on_one_axis_is_a_heavier_carriage():
    axis = gk.load_machine("emps")
    loaded = gk.Plant(machine=axis, payload=30.0, payload_center=[0.1, 0.2, 0.3]).true_machine
    assert loaded.carriage.mass == axis.carriage.mass + 30.0 and loaded.replace(carriage=axis.carriage) == axis
