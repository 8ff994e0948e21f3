"""CDAC and FCDAC against their equations derived once more (oracle/adaptive.py), at states where no term vanishes."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

import gough as gk
from gough.control.base import Measurement
from gough.frames import abc_of_rotation_np, quaternion_of_rotation_np
from gough.kernel.pack import flatten, unflatten
from gough.machine.drives import force_limit
from gough.observe.forward import Pose
from gough.simulate import tick
from oracle.adaptive import Step, cross_matrix, exponential, rotation

PERIOD = 1e-3
COMMON = {
    "slope": np.array([90.0, 150.0, 200.0, 110.0, 250.0, 60.0]), "damping": np.arange(120.0, 300, 30),
    "sliding": 400.0, "inertia_rate": 2e-3, "leakage": 200.0, "friction_smoothing": 5e-3,
}  # fmt: skip
RULES = {"accelerations": 5, "acceleration_rate": 0.3, "friction_rate": np.arange(1e6, 7e6, 1e6)}
LAWS = {"cdac": (gk.RobustAdaptive, {"viscous_rate": 5.0}), "fcdac": (gk.FuzzyFriction, RULES)}
SETTINGS = {
    "as it comes": {"boundary": 1e-3, "leakage_norm": 3.0},
    "in the boundary layer, leaking": {"boundary": 3.0, "leakage_norm": 0.8},
    "at the measured motion": {
        "boundary": 1e-3, "leakage_norm": 0.4, "regressor": "actual", "friction_speed": "measured",
    },
}  # fmt: skip


@pytest.fixture(scope="module")
def machine():
    inertia = np.array([[12, 1.5, -0.8], [1.5, 11, 0.6], [-0.8, 0.6, 15]])
    center = np.array([0.03, -0.02, 0.11])
    changes = {"platform.center": center, "platform.inertia": inertia, "friction.coulomb_offset": 70.0}
    return gk.load_machine("nist-octahedral").replace(**changes)


def called(law, state, r, y):
    theta = ca.SX.sym("theta", len(law.theta))
    command, after = law.step(state, r, y, theta)
    u, after = ca.Function("step", [theta], [ca.SX(command.u), ca.SX(flatten(after))])(law.theta)
    return np.array(u).ravel(), unflatten(state, np.array(after).ravel())


def moment(machine, law, rng):
    """State, reference, pose now and a sample ago, all by chance; the measurement that belongs to it."""
    x = machine.home + rng.normal(size=6) * [0.05, 0.05, 0.03, 0.08, 0.08, 0.08]
    V, A = 0.08 * rng.normal(size=6), rng.normal(size=6)
    q, qd, qdd = machine.joint_motion(x, V, A)
    r = tick.rest_row(machine, x)._replace(xd=V, xdd=A, q=q, qd=qd, qdd=qdd)

    def beside():  # by 0.1 mm and mrad: two Newton steps from one to the other end at rounding
        R = exponential(cross_matrix(1e-4 * rng.normal(size=3))).real @ rotation(x[3:])
        return np.append(x[:3] + 1e-4 * rng.normal(size=3), abc_of_rotation_np(R))

    now, before = beside(), beside()
    state = law.init(r, np.zeros(6))._replace(
        observer=Pose(np.append(before[:3], quaternion_of_rotation_np(rotation(before[3:])))),
        parameters=rng.uniform(0.6, 1.4, 9), started=50 * rng.normal(size=6),
    )  # fmt: skip
    if law.kind == "robust_adaptive":
        state = state._replace(coulomb=rng.uniform(0.1, 1.9, 6), viscous=rng.uniform(0.1, 1.9, 6))
    else:
        state = state._replace(weights=rng.uniform(-800, 800, len(state.weights)))
    applied = 0.9 * force_limit(machine.drive) * rng.uniform(-1, 1, 6)
    return state, r, now, before, Measurement(machine.inverse_kinematics(now), applied)


@pytest.mark.quick("cdac-as it comes", "fcdac-in the boundary layer, leaking", "cdac-at the measured motion")
@pytest.mark.parametrize("setting", SETTINGS)
@pytest.mark.parametrize("name", LAWS)
def test_forces_and_estimates_are_those_of_the_equations_derived_from_energies(machine, name, setting):
    kind, options = LAWS[name]
    law = kind(**COMMON, **options, **SETTINGS[setting]).on(machine, PERIOD)
    state, r, now, before, y = moment(machine, law, np.random.default_rng(list(map(ord, name + setting))))
    u, after = called(law, state, r, y)
    own = Step(law, state, r, now, before, saturated=False)
    force, *estimates = own.modelled() if name == "cdac" else own.fuzzy()
    found = (after.coulomb, after.viscous) if name == "cdac" else (after.weights,)
    # 1e-9: the pose is that of `now` to 1e-16 m, its velocity to 1e-13 m/s, and K_D turns that into 1e-11 of the forces
    assert np.abs(u - force).max() < 1e-9 * np.abs(force).max()
    assert np.abs(after.parameters - own.parameters).max() < 1e-9
    for ours, expected in zip(found, estimates, strict=True):
        assert np.abs(ours - expected).max() < 1e-9 * max(1, np.abs(expected).max())
    # the setting is what its name says, and no estimate stands still
    assert (own.size < law.boundary) == ("boundary layer" in setting)
    assert (own.leak(state.parameters) > 0) == (setting != "as it comes")
    assert (own.parameters != state.parameters).all()


@pytest.mark.parametrize("name", LAWS)
def test_one_saturated_drive_holds_all_estimates_and_no_force(machine, name):
    kind, options = LAWS[name]
    law = kind(**COMMON, **options, boundary=1e-3).on(machine, PERIOD)
    state, r, now, before, y = moment(machine, law, np.random.default_rng(8))
    y.u[3] = -force_limit(machine.drive)
    u, after = called(law, state, r, y)
    own = Step(law, state, r, now, before, saturated=True)
    assert np.abs(u - (own.modelled() if name == "cdac" else own.fuzzy())[0]).max() < 1e-9 * np.abs(u).max()
    np.testing.assert_array_equal(after.parameters, state.parameters)
    for key in ("coulomb", "viscous") if name == "cdac" else ("weights",):
        np.testing.assert_array_equal(getattr(after, key), getattr(state, key))
