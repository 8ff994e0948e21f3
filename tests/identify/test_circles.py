"""Circles in air at two tilts: several logs taken together, and the torques of base joints of Okuda et al. 2006."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from numpy.testing import assert_allclose

import gough as gk
from gough.errors import ExperimentError, LogError
from gough.identify import joint_torque
from gough.identify.rows import joined, rows_of_log
from gough.log.build import LogBuilder
from gough.machine.workspace import random_poses
from gough.study.okuda2006 import model

T_0 = np.array([8.0, 7.2, 8.8, 7.6, 8.4, 7.0])  # N m
F_0 = np.array([90.0, 81.0, 99.0, 85.0, 95.0, 83.0])  # N
TILTS = (0.0, np.radians(-20.0))
KINDS = ("coulomb", "base_torque")
# what the paper identifies: m_T moves along a strut, m_S is the motor on the base joint, seen by its moment m_S l_1
FREE = ["friction", "strut.moving.m", "strut.fixed.m c"]


@pytest.fixture(scope="module")
def okuma():
    return gk.load_machine("okuma-pm600").frictionless()


@pytest.fixture(scope="module")
def states(okuma):
    rng = np.random.default_rng(3)
    return random_poses(okuma, 40, rng), rng.normal(size=(40, 6)) * [0.1, 0.1, 0.1, 0.2, 0.2, 0.2]


def test_a_base_joints_torque_takes_the_power_of_its_turning(okuma, states):
    """Along any motion the drives give t_0 |n x n'| for it: n' from differences of the struts' directions."""
    x, xd = states
    h = 1e-6
    power = np.einsum("ni,nij->nj", np.einsum("nij,nj->ni", okuma.jacobian(x), xd), joint_torque.columns(okuma, x, xd))
    n = [model.struts(okuma, _moved(okuma, x, xd, step)).l for step in (-h, h)]
    turning = np.linalg.norm(n[1] - n[0], axis=-1) / (2 * h)
    assert_allclose(power, turning, rtol=1e-4, atol=1e-6 * turning.max())


def _moved(machine, x, xd, h):
    """Poses a little later on the twist: the angles' rates from the rotation's."""
    from gough.frames import abc_of_rotation_np, rotation_of_abc_np

    R, w = rotation_of_abc_np(x[:, 3:]), h * xd[:, 3:]
    K = np.stack([np.cross(w, e) for e in np.eye(3)], -1)
    turned = (np.eye(3) + K + K @ K / 2) @ R
    return np.concatenate([x[:, :3] + h * xd[:, :3], abc_of_rotation_np(turned)], 1)


def test_its_columns_are_those_of_the_papers_model(okuma, states):
    """study/okuda2006/model.py solves the balance of the platform in NumPy; fast joints, so that none is near rest."""
    x, xd = states
    _, Y = model.columns(okuma, x, model.joint_speeds(okuma, x, xd), np.ones((len(x), 6)))
    assert_allclose(joint_torque.columns(okuma, x, xd), Y[..., 8:], rtol=2e-4, atol=2e-4)


def circle(machine, tilt, seconds=20.0, period=5e-3):
    """A log of a circle in air under the forces that its motion, F_0 and T_0 take; readings without steps."""
    t = np.arange(0, seconds, period)
    angle = 2 * np.pi * t / 8
    x, xd, xdd = (np.zeros((len(t), 6)) for _ in range(3))
    x[:] = machine.home
    x[:, 3] += tilt
    w = 2 * np.pi / 8
    for k, (place, rate, rate2) in enumerate(
        ((np.cos, lambda a: -np.sin(a), lambda a: -np.cos(a)), (np.sin, np.cos, lambda a: -np.sin(a)))
    ):
        x[:, k] += 0.1 * place(angle)
        xd[:, k], xdd[:, k] = 0.1 * w * rate(angle), 0.1 * w * w * rate2(angle)
    qd = np.einsum("nij,nj->ni", machine.jacobian(x), xd)
    u = machine.inverse_dynamics(x, xd, xdd) + F_0 * np.sign(qd) + joint_torque.columns(machine, x, xd) @ T_0
    builder = LogBuilder(t, machine.task, 6)
    builder.add("q_m", machine.inverse_kinematics(x))
    builder.add("u", u + np.random.default_rng(1).normal(size=u.shape))
    return builder.build({})


@pytest.fixture(scope="module")
def logs(okuma):
    return [circle(okuma, tilt) for tilt in TILTS]


@pytest.mark.full
def test_circles_at_two_tilts_together_give_back_friction_and_torques(okuma, logs):
    fit = gk.identify(logs, okuma, free=FREE, friction=KINDS)
    f_0, t_0 = (np.array([fit[f"friction.{kind}[{j}]"] for j in range(6)]) for kind in KINDS)
    for found, planted in ((f_0, F_0), (t_0, T_0)):
        assert (np.abs(found[:, 0] - planted) < 4 * found[:, 1]).all()
    assert (t_0[:, 1] < 1.0).all(), "an eighth of them: the interval says something"
    for name in FREE[1:]:
        value, std = fit[name]
        (sheet,) = (v for n, v in zip(okuma.parameters.names, okuma.parameters.values, strict=True) if n == name)
        assert abs(value - sheet) < 4 * std < 0.1 * abs(sheet)
    assert fit.estimate.residual_rms < 1.5, "1 N was planted"


@pytest.mark.full
def test_two_tilts_tell_the_masses_better_than_twice_one(okuma, logs):
    """Gravity stands otherwise to the struts; of as many rows of one tilt the deviations are at least a half more."""
    std = []
    for some in ([logs[0], logs[0]], logs):
        fit = gk.identify(some, okuma, free=FREE, friction=KINDS)
        std.append([fit[name][1] for name in FREE[1:]])
    assert (1.5 * np.array(std[1]) < std[0]).all()


def test_logs_taken_together_are_their_rows_one_behind_the_other(okuma, logs):
    parts = [rows_of_log(log, okuma, ("coulomb",)) for log in logs]
    both = joined(parts)
    assert_allclose(both.Y, np.concatenate([part.Y for part in parts]), rtol=0, atol=0)
    assert (np.diff(both.t) > 0).all() and both.samples == sum(part.samples for part in parts)


def test_logs_of_different_sample_periods_are_refused(okuma, logs):
    slow = dataclasses.replace(rows_of_log(logs[1], okuma, ("coulomb",)), step=0.03)
    with pytest.raises(LogError, match="logs that are taken together need one sample period"):
        joined([rows_of_log(logs[0], okuma, ("coulomb",)), slow])


def test_a_torque_of_base_joints_is_for_machines_of_struts():
    glide = gk.load_machine("eth-hexaglide")
    t = np.arange(0, 2, 2e-3)
    builder = LogBuilder(t, glide.task, 6)
    x = np.repeat(glide.home[None], len(t), 0)
    x[:, 0] += 0.02 * np.sin(3 * t)
    q = glide.inverse_kinematics(x)
    builder.add("q_m", q)
    builder.add("u", 0 * q)
    with pytest.raises(ExperimentError, match="friction: only a machine of struts has base joints with a torque"):
        gk.identify(builder.build({}), glide, friction=KINDS)


@pytest.mark.full
def test_the_command_takes_several_logs(gough, okuma, logs, tmp_path):
    for k, log in enumerate(logs):
        log.save(tmp_path / f"{k}.nc")
    asked = [word for name in FREE for word in ("--free", name)]
    command = ["identify", "0.nc", "1.nc", "-m", "okuma-pm600", "--friction", "base_torque,coulomb", *asked, "--json"]
    found = gough(*command).json
    assert found["logs"] == ["0.nc", "1.nc"]
    named = {row["name"]: row["value"] for row in found["parameters"]}
    assert named["friction.base_torque[0]"] == pytest.approx(T_0[0], abs=2)
