"""A simulation configuration of LinuxCNC for a machine: INI, HAL, tool table.  Lengths in mm, angles in degrees.

Speeds and accelerations of the tool are those of the data sheet's [feed], limits of axes those of its workspace,
limits of joints those of its [limits].  HOME of every joint is the inverse kinematics of the axes' zero, to all
digits: LinuxCNC's stock hexapod, whose HOME has six, starts 7 um away from where it believes to be.
"""

from __future__ import annotations

import numpy as np

from ...errors import ExperimentError, Problem
from .functions import axes_of

_DEGREES = 180 / np.pi


def joint_range(machine) -> tuple[np.ndarray, np.ndarray]:
    """Least and greatest place of every joint, m, (n,) each."""
    limits = machine.limits
    ends = np.asarray(limits.length if hasattr(limits, "length") else limits.travel, float)
    ends = np.broadcast_to(ends, (machine.joints_count, 2))
    return ends[:, 0], ends[:, 1]


def check_limits(machine) -> None:
    """Refuse a machine whose sheet leaves open what LinuxCNC must know.

    Raises
    ------
    ExperimentError
        a problem for each number.
    """
    limits = machine.limits
    asked = [
        ("limits.speed", limits.speed, 'speed = "18 m/min"'),
        ("limits.acceleration", limits.acceleration, 'acceleration = "10 m/s2"'),
        ("limits.workspace", limits.workspace, 'workspace = { radius = "0.25 m", height = "0.2 m", ... }'),
    ]
    wrong = [
        Problem(
            "a machine for LinuxCNC must have its limits", key=key, cure=f"write {text} in [limits] of {machine.name}"
        )
        for key, value, text in asked
        if value is None
    ]
    if wrong:
        raise ExperimentError(problems=wrong)


def axis_range(machine) -> tuple[np.ndarray, np.ndarray]:
    """Least and greatest place of every axis, (d,) each, m and rad: a box about the declared workspace."""
    space = machine.limits.workspace
    half = np.array([space.radius, space.radius] if space.size is None else np.asarray(space.size) / 2)
    middle = np.zeros(3) if space.middle is None else np.asarray(space.middle, float)
    wide = np.array([*half, space.height / 2])
    from ...frames import rotation_of_abc_np

    # the box of W as the axes of the program see it
    R = np.abs(rotation_of_abc_np(np.asarray(machine.program_zero, float)[3:]).T)
    middle, wide = rotation_of_abc_np(np.asarray(machine.program_zero, float)[3:]).T @ middle, R @ wide
    turn = np.array([space.tilt, space.tilt, space.c])
    d = len(machine.task)
    return np.concatenate([middle - wide, -turn])[:d], np.concatenate([middle + wide, turn])[:d]


def ini(machine, words: dict[str, object], period: float, ferror: float, min_ferror: float) -> str:
    """The text of NAME.ini."""
    name, axes, n = words["NAME"], axes_of(machine), machine.joints_count
    feed, limits = machine.feed, machine.limits
    home = machine.inverse_kinematics(machine.home)
    speed, acceleration = feed.rapid * 1e3, feed.acceleration * 1e3
    rate, angular = feed.angular_rate * _DEGREES, feed.angular_acceleration * _DEGREES
    lines = [
        f"# {machine.name} simulated in LinuxCNC, made by gough {words['VERSION']}: mm, degrees, s",
        "[EMC]", "VERSION = 1.1", f"MACHINE = {machine.name}", "DEBUG = 0", "",
        "[DISPLAY]", "DISPLAY = axis", "CYCLE_TIME = 0.1", "POSITION_OFFSET = RELATIVE", "POSITION_FEEDBACK = ACTUAL",
        "MAX_FEED_OVERRIDE = 1.2", f"GEOMETRY = {axes}", "",
        "[RS274NGC]", f"PARAMETER_FILE = {name}.var", "RS274NGC_STARTUP_CODE = G17 G21 G40 G49 G54 G80 G90 G94", "",
        "[TASK]", "TASK = milltask", "CYCLE_TIME = 0.001", "",
        "[EMCMOT]", "EMCMOT = motmod", "COMM_TIMEOUT = 1.0", f"SERVO_PERIOD = {round(period * 1e9)}", "",
        "[EMCIO]", "EMCIO = io", "CYCLE_TIME = 0.1", f"TOOL_TABLE = {name}.tbl", "",
        "[HAL]", f"HALFILE = {name}.hal", "",
        "[KINS]", f"KINEMATICS = {name}_kins", f"JOINTS = {n}", "",
        "[TRAJ]", f"COORDINATES = {' '.join(axes)}", "LINEAR_UNITS = mm", "ANGULAR_UNITS = degree",
        f"DEFAULT_LINEAR_VELOCITY = {_text(speed / 4)}", f"MAX_LINEAR_VELOCITY = {_text(speed)}",
        f"DEFAULT_LINEAR_ACCELERATION = {_text(acceleration)}", f"MAX_LINEAR_ACCELERATION = {_text(acceleration)}",
        f"DEFAULT_ANGULAR_VELOCITY = {_text(rate)}", f"MAX_ANGULAR_VELOCITY = {_text(rate)}",
        f"DEFAULT_ANGULAR_ACCELERATION = {_text(angular)}", f"MAX_ANGULAR_ACCELERATION = {_text(angular)}",
        f"HOME = {' '.join(['0'] * len(axes))}", "",
    ]  # fmt: skip
    lowest, highest = axis_range(machine)
    for i, letter in enumerate(axes):
        scale = 1e3 if i < 3 else _DEGREES
        lines += [
            f"[AXIS_{letter}]", f"MIN_LIMIT = {_text(lowest[i] * scale)}", f"MAX_LIMIT = {_text(highest[i] * scale)}",
            f"MAX_VELOCITY = {_text(speed if i < 3 else rate)}",
            f"MAX_ACCELERATION = {_text(acceleration if i < 3 else angular)}", "",
        ]  # fmt: skip
    lowest, highest = joint_range(machine)
    for i in range(n):
        at = repr(float(home[i] * 1e3))
        lines += [
            f"[JOINT_{i}]", "TYPE = LINEAR", f"HOME = {at}", f"HOME_OFFSET = {at}", "HOME_SEQUENCE = 0",
            f"MIN_LIMIT = {_text(lowest[i] * 1e3)}", f"MAX_LIMIT = {_text(highest[i] * 1e3)}",
            f"MAX_VELOCITY = {_text(limits.speed * 1e3)}", f"MAX_ACCELERATION = {_text(limits.acceleration * 1e3)}",
            f"FERROR = {_text(ferror * 1e3)}", f"MIN_FERROR = {_text(min_ferror * 1e3)}", "",
        ]  # fmt: skip
    return "\n".join(lines)


def hal(machine, words: dict[str, object]) -> str:
    """The text of NAME.hal: joints that are where they are commanded to be, and the components beside them."""
    name, n = words["NAME"], machine.joints_count
    comp = str(name).replace("_", "-")
    lines = [
        f"# {machine.name} simulated: made by gough {words['VERSION']}",
        "loadrt [KINS]KINEMATICS",
        "loadrt [EMCMOT]EMCMOT servo_period_nsec=[EMCMOT]SERVO_PERIOD num_joints=[KINS]JOINTS",
        *(f"loadrt {name}_{part}" for part in ("feedforward", "observer", "following")),
        "addf motion-command-handler servo-thread",
        "addf motion-controller servo-thread",
        *(f"addf {comp}-{part} servo-thread" for part in ("feedforward", "observer", "following")),
        "",
        "# no hardware: feedback is the command, and the drives apply what the commanded motion asks for",
    ]
    for i in range(n):
        lines += [
            f"net joint{i}-motor joint.{i}.motor-pos-cmd => joint.{i}.motor-pos-fb",
            f"net joint{i}-cmd joint.{i}.pos-cmd => {comp}-feedforward.position-{i} {comp}-following.command-{i}",
            f"net joint{i}-vel joint.{i}.vel-cmd => {comp}-feedforward.velocity-{i} {comp}-following.velocity-{i}",
            f"net joint{i}-acc joint.{i}.acc-cmd => {comp}-feedforward.acceleration-{i}",
            f"net joint{i}-fb joint.{i}.pos-fb => {comp}-observer.position-{i} {comp}-following.position-{i}",
            f"net joint{i}-force {comp}-feedforward.force-{i} => {comp}-observer.drive-{i}",
        ]
    lines += [
        "",
        f"net homed motion.is-all-homed => {comp}-observer.good {comp}-following.enable {comp}-feedforward.enable",
        "net estop iocontrol.0.user-enable-out => iocontrol.0.emc-enable-in",
        "net tool-change iocontrol.0.tool-change => iocontrol.0.tool-changed",
        "net tool-prepare iocontrol.0.tool-prepare => iocontrol.0.tool-prepared",
        "",
    ]
    return "\n".join(lines)


def _text(value: float) -> str:
    """A number that reads back the same where it must, and without the rounding of unit changes where it need not."""
    return f"{value:.12g}"
