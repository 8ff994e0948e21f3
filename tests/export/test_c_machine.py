"""Kinematics and dynamics in C against Python, every machine of the library."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from compiled import COMPILERS, GENHEX, UNTOUCHED, InC, build, needs_gcc, pointer

import gough as gk
from gough.errors import SingularityError
from gough.export.c.machine_functions import kinematic_functions
from gough.export.c.machine_text import limit_names, machine_text
from gough.kernel.tape import trace
from gough.machine import workspace
from gough.machine.workspace import random_poses

MACHINES = ["okuma-pm600", "nist-octahedral", "eth-hexaglide", "ccu-3prs", "ifma-hsm", "emps", str(GENHEX)]
OK, NOT_FINITE, UNREACHABLE, _, ASSEMBLY_MODE, OUTSIDE_LIMITS, SINGULAR = range(7)
RELATIVE = 1e-12  # issue 12, of the greatest entry of a row


def motions(machine, count: int, seed: int = 1):
    """Poses of the workspace, rates, accelerations and wrenches, rows."""
    rng, d = np.random.default_rng(seed), len(machine.task)
    if machine.limits.workspace is None:
        x = machine.home + rng.uniform(-0.02, 0.02, (count, d))
    else:
        x = random_poses(machine, count, rng)
    return x, rng.normal(size=(count, d)) * 0.5, rng.normal(size=(count, d)) * 5, rng.normal(size=(count, 6)) * 100


def off(found, expected):
    """The largest difference, of the greatest entry of its row."""
    return (np.abs(found - expected).max(-1) / np.abs(expected).max(-1)).max()


def hold_to_python(machine, in_c, count):
    x, xd, xdd, w = motions(machine, count)
    for name, inputs, expected in (
        ("inverse", (x,), machine.inverse_kinematics(x)),
        ("jacobian", (x,), machine.jacobian(x).reshape(count, -1)),
        ("inverse_dynamics", (x, xd, xdd, w), machine.inverse_dynamics(x, xd, xdd, w)),
    ):
        status, found = in_c.call(name, *inputs)
        assert not status.any(), name
        assert off(found, expected) < RELATIVE, name
    status, found, _ = in_c.forward(machine.inverse_kinematics(x), x)
    assert not status.any()
    assert off(found, x) < RELATIVE


@needs_gcc
def test_a_hexapod_in_c_gives_what_python_gives_at_a_thousand_poses(genhex):
    hold_to_python(genhex.machine, genhex, 1000)


@needs_gcc
@pytest.mark.full("nist-octahedral", "emps")
@pytest.mark.parametrize("name", MACHINES, ids=lambda name: Path(name).stem)
def test_every_machine_in_c_gives_what_python_gives_at_a_hundred_thousand_poses(name, tmp_path):
    machine = gk.load_machine(name)
    hold_to_python(machine, InC(tmp_path, machine), 100_000)


@needs_gcc
@pytest.mark.full("nist-octahedral", "eth-hexaglide", "emps")
@pytest.mark.parametrize("name", MACHINES, ids=lambda name: Path(name).stem)
def test_inverse_kinematics_in_c_has_the_bits_of_one_lane(name, tmp_path):
    machine = gk.load_machine(name)
    x = motions(machine, 20)[0]
    tape = trace(kinematic_functions(machine)["inverse"])
    _, found = InC(tmp_path, machine, options=("-O2",)).call("inverse", x)
    expected = np.array([tape.replay(machine.theta, row)[0] for row in x])
    assert np.array_equal(found, expected)


@pytest.mark.full("ccu-3prs-clang", "nist-octahedral-*", "ifma-hsm-gcc")
@pytest.mark.parametrize("compiler", COMPILERS)
@pytest.mark.parametrize("name", MACHINES, ids=lambda name: Path(name).stem)
def test_no_compiler_warns_of_a_machine_even_where_it_looks_hardest(name, compiler, tmp_path):
    InC(tmp_path, gk.load_machine(name), compiler=compiler, options=("-O2",))  # build() has -Werror


@needs_gcc
@pytest.mark.parametrize("wrong", [np.nan, np.inf, -np.inf])
def test_what_is_no_number_gives_a_status_and_no_answer(genhex, wrong):
    x, xd, xdd, w = motions(genhex.machine, 6)
    bad = x.copy()
    bad[np.arange(6), np.arange(6)] = wrong
    for name, inputs in (
        ("inverse", (bad,)),
        ("jacobian", (bad,)),
        ("limits", (bad,)),
        ("inverse_dynamics", (bad, xd, xdd, w)),
        ("inverse_dynamics", (x, bad, xdd, w)),
        ("inverse_dynamics", (x, xd, bad, w)),
        ("inverse_dynamics", (x, xd, xdd, bad)),
    ):
        status, found = genhex.call(name, *inputs)
        assert status.tolist() == [NOT_FINITE] * 6, name
        assert (found == UNTOUCHED).all(), name


@needs_gcc
def test_numbers_beyond_any_machine_never_give_infinity_or_nan(genhex):
    machine = genhex.machine
    x = np.tile(machine.home, (4, 1))
    x[:, 0] = [1e155, 1e300, -1e308, 5e-324]
    for name in ("inverse", "jacobian", "limits"):
        status, found = genhex.call(name, x)
        assert np.isfinite(found).all()
        assert status[1] == UNREACHABLE, name


@needs_gcc
def test_limits_in_c_are_those_of_python_and_say_which(genhex):
    machine = genhex.machine
    x = motions(machine, 50)[0]
    x[0, 2] += 2.0  # struts too long
    x[1, 5] = np.radians(88.0)
    status, found = genhex.call("limits", x)
    expected = workspace.margins(machine, machine.standing(x))
    assert np.abs(found - expected).max() < 1e-12  # lengths of a metre and 16 digits
    assert status[:2].tolist() == [OUTSIDE_LIMITS, SINGULAR]
    assert not status[2:].any()
    names = (np.ctypeslib.ctypes.c_char_p * len(limit_names(machine))).in_dll(genhex.library, "m_limit_names")
    assert [one.decode() for one in names] == list(limit_names(machine))


@needs_gcc
@pytest.mark.full
def test_a_tool_tip_that_no_link_reaches_is_refused(tmp_path):
    machine = gk.load_machine("ccu-3prs")
    in_c = InC(tmp_path, machine, options=("-O0",))
    status, found = in_c.call("inverse", machine.home + [[5.0, 0, 0], [0, 0, 0]])
    assert status.tolist() == [UNREACHABLE, OK]
    assert (found[0] == UNTOUCHED).all()


@needs_gcc
def test_forces_near_a_singular_pose_are_refused_as_in_python(genhex):
    x = np.tile(genhex.machine.home, (2, 1))
    x[:, 5] = np.radians([87.0, 88.0])
    still, w = np.zeros((2, 6)), np.zeros((2, 6))
    status, found = genhex.call("inverse_dynamics", x, still, still, w)
    assert status.tolist() == [OK, SINGULAR]
    assert (found[1] == UNTOUCHED).all()
    with pytest.raises(SingularityError):
        genhex.machine.inverse_dynamics(x[1], still[1], still[1])


@needs_gcc
@pytest.mark.full
def test_with_theta_as_an_argument_one_code_serves_every_machine_of_the_structure(tmp_path):
    """The code of a hexapod, handed the numbers of another, gives that one's joints, forces and pose."""
    first = gk.load_machine(GENHEX)
    other = first.replace(**{"platform.mass": 33.0, "joints.base": first.joints.base * 1.03 + 2e-3})
    c, h = machine_text("m", first, theta="argument")
    library = build(tmp_path, {"m.c": c, "m.h": h}, options=("-O0",))
    x, xd, xdd, w = motions(other, 20)
    theta, q, u, pose = pointer(other.theta), np.empty(6), np.empty(6), np.empty(6)
    expected = other.inverse_kinematics(x), other.inverse_dynamics(x, xd, xdd, w)
    for k in range(20):
        assert library.m_inverse(theta, pointer(x[k]), pointer(q)) == OK
        assert off(q, expected[0][k]) < RELATIVE
        assert library.m_inverse_dynamics(theta, *(pointer(one[k]) for one in (x, xd, xdd, w)), pointer(u)) == OK
        assert off(u, expected[1][k]) < RELATIVE
        pose[:] = other.home
        assert library.m_forward(theta, pointer(q), pointer(pose), None) == OK
        assert off(pose, x[k]) < RELATIVE
    table = (np.ctypeslib.ctypes.c_double * len(first.theta)).in_dll(library, "m_theta")
    assert list(table) == first.theta.tolist()
