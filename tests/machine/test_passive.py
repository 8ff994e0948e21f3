"""Inverse dynamics in two velocities: the skew symmetry that Lyapunov proofs need; the same by Christoffel symbols."""

from __future__ import annotations

from functools import partial

import casadi as ca
import numpy as np
import pytest

import gough as gk
from gough import frames

LIBRARY = ["nist-octahedral", "okuma-pm600"]


def general(name):
    """A library machine with its mass off the tool tip and a full inertia: no term vanishes by chance."""
    machine = gk.load_machine(name)
    inertia = np.array([[12, 1.5, -0.8], [1.5, 11, 0.6], [-0.8, 0.6, 15]])
    return machine.replace(**{"platform.center": np.array([0.03, -0.02, 0.11]), "platform.inertia": inertia})


@pytest.fixture(scope="module", params=LIBRARY)
def machine(request):
    return general(request.param)


@pytest.fixture(scope="module")
def functions(machine):
    """passive(z, v, v_r, a_r); inverse force (z, v, a); M(z), its rate along v, and C(v) as a matrix."""
    p, theta = machine.symbols
    z, v, v_r, a = ca.SX.sym("z", 7), ca.SX.sym("v", 6), ca.SX.sym("v_r", 6), ca.SX.sym("a", 6)
    pi = {key: value for key, (value, _) in machine.inertial(p).items()}
    passive = machine.passive_force(p, pi, z, v, v_r, a)
    M, _ = machine.mass_and_bias(p, pi, z, v)
    rate = ca.reshape(ca.jtimes(ca.vec(M), z, machine.rate(p, z, v)), 6, 6)
    made = {
        "passive": ca.Function("passive", [theta, z, v, v_r, a], [passive]),
        "inverse": ca.Function("inverse", [theta, z, v, a], [machine.inverse_force(p, pi, z, v, a)]),
        "matrices": ca.Function("matrices", [theta, z, v, v_r, a], [M, rate, ca.jacobian(passive, v_r)]),
    }
    return {key: partial(_called, f, machine.theta) for key, f in made.items()}


def _called(function, *args):
    out = function(*args)
    return [np.array(x) for x in (out if isinstance(out, tuple) else (out,))]


def draws(machine, count):
    rng = np.random.default_rng(7)
    for _ in range(count):
        x = machine.home + rng.uniform(-1, 1, 6) * [0.1, 0.1, 0.05, 0.2, 0.2, 0.2]
        z = np.concatenate([x[:3], frames.quaternion_of_abc_np(x[3:])])
        yield x, z, *rng.normal(size=(3, 6))


def test_the_mass_matrix_changes_at_the_rate_c_plus_its_transpose(machine, functions):
    """M' - 2 C skew, for every velocity: eq. (3) of docs/theory/sliding.md."""
    for _, z, v, v_r, a in draws(machine, 50):
        M, rate, C = functions["matrices"](z, v, v_r, a)
        skew = rate - 2 * C
        assert np.abs(skew + skew.T).max() < 1e-12 * np.abs(rate).max() + 1e-13 * np.abs(M).max()


def test_one_velocity_in_both_places_is_the_inverse_dynamics(machine, functions):
    for _, z, v, _, a in draws(machine, 20):
        (both,), (one,) = functions["passive"](z, v, v, a), functions["inverse"](z, v, a)
        assert np.abs(both - one).max() < 1e-12 * np.abs(one).max()


def test_it_is_linear_in_the_second_velocity(machine, functions):
    """C(v)(2 v_r) = 2 C(v) v_r: the part that has v_r twice cancels between the two calls."""
    zero = np.zeros(6)
    for _, z, v, v_r, _ in draws(machine, 20):
        g, once, twice = (functions["passive"](z, v, k * v_r, zero)[0] for k in (0, 1, 2))
        assert np.abs((twice - g) - 2 * (once - g)).max() < 1e-11 * np.abs(twice).max()


def test_christoffel_symbols_in_x_y_z_a_b_c_give_the_same_force(machine, functions):
    """Another derivation: M in coordinates, C by Christoffel's symbols, and both velocities carried over."""
    p, theta = machine.symbols
    x, xd = ca.SX.sym("x", 6), ca.SX.sym("xd", 6)
    pi = {key: value for key, (value, _) in machine.inertial(p).items()}
    z = machine.coordinates_of(machine, x)
    R, columns = frames.rotation_of_abc(x[3:]), []  # w from R' = [w] R
    for k in range(3):
        S = ca.reshape(ca.jacobian(ca.vec(R), x[3 + k]), 3, 3) @ R.T
        columns.append(ca.vertcat(S[2, 1], S[0, 2], S[1, 0]))
    E = ca.diagcat(ca.SX.eye(3), ca.horzcat(*columns))
    M, _ = machine.mass_and_bias(p, pi, z, ca.SX(6, 1))
    M_x = E.T @ M @ E
    dM = [ca.reshape(ca.jacobian(ca.vec(M_x), x[k]), 6, 6) for k in range(6)]
    C_x = ca.SX(6, 6)
    for i in range(6):
        for j in range(6):
            C_x[i, j] = sum((dM[k][i, j] + dM[j][i, k] - dM[i][k, j]) * xd[k] for k in range(6)) / 2
    E_rate = ca.reshape(ca.jtimes(ca.vec(E), x, xd), 6, 6)
    found = ca.Function("christoffel", [theta, x, xd], [E, E_rate, M_x, C_x])
    for pose, z0, v, v_r, a_r in draws(machine, 5):
        E0 = np.array(found(machine.theta, pose, np.zeros(6))[0])
        rate = np.linalg.solve(E0, v)
        E0, E_rate0, M0, C0 = (np.array(y) for y in found(machine.theta, pose, rate))
        rate_r = np.linalg.solve(E0, v_r)
        acceleration_r = np.linalg.solve(E0, a_r - E_rate0 @ rate_r)
        (g,) = functions["inverse"](z0, np.zeros(6), np.zeros(6))
        expected = np.linalg.solve(E0.T, M0 @ acceleration_r + C0 @ rate_r) + g.ravel()
        (force,) = functions["passive"](z0, v, v_r, a_r)
        assert np.abs(force.ravel() - expected).max() < 1e-11 * np.abs(expected).max()
