"""What can be mapped: for each name what a machine must have, how it is found, its unit and its meaning."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..errors import ExperimentError
from . import abilities

MOST_ELASTIC = 20_000  # poses of a stiffness map: a millisecond and more each

# name: what it is, in the help of the command
QUANTITIES = {
    "workspace": "which limit is nearest, and what is left of it",
    "dexterity": "condition number and singular values of J",
    "feed": "greatest feed in the worst direction, by speed, acceleration and force of the joints",
    "acceleration": "greatest acceleration in the worst direction from rest, by acceleration and force of the joints",
    "force": "greatest force on the tool in the worst direction that the drives hold at rest",
    "gravity": "forces of the drives that hold the machine's own weight",
    "stiffness": "stiffness at the tool, first natural frequency and sag, of the sheet's [[compliance]]",
}

# name of a variable: (unit, meaning)
TOLD = {
    "inside": ("1", "within all limits of the machine"),
    "declared": ("1", "in the declared workspace"),
    "reserve": ("1", "what is left of the nearest limit, as a share; 0 at the limit, negative beyond it"),
    "limit": ("1", "the limit whose margin that is; -1: no joint coordinates have the pose"),
    "condition": ("1", "condition number of J, rotations times the platform's radius"),
    "singular_least": ("1", "least singular value of that J: joint speed by tool speed"),
    "singular_greatest": ("1", "greatest singular value of that J"),
    "feed": ("m/s", "greatest feed in every direction, the tool's direction kept"),
    "feed_limit": ("1", "the joint and what limits it"),
    "turn_rate": ("rad/s", "greatest angular rate about every axis through the tip"),
    "acceleration": ("m/s2", "greatest acceleration in every direction from rest, the tool's direction kept"),
    "acceleration_limit": ("1", "the joint and what limits it"),
    "angular_acceleration": ("rad/s2", "greatest angular acceleration about every axis through the tip, from rest"),
    "force": ("N", "greatest force on the tool in every direction that the drives hold at rest"),
    "force_limit": ("1", "the joint whose drive is at its limit"),
    "holding": ("N", "greatest force of a drive that holds the weight"),
    "holding_share": ("1", "the same as a share of the drive's limit"),
    "stiffness_x": ("N/m", "stiffness along x of W, the joints held"),
    "stiffness_y": ("N/m", "stiffness along y of W, the joints held"),
    "stiffness_z": ("N/m", "stiffness along z of W, the joints held"),
    "stiffness_least": ("N/m", "stiffness in the softest direction"),
    "frequency": ("Hz", "first natural frequency, the joints held"),
    "sag": ("m", "distance of the tip at rest from where the rigid machine has it"),
    "depth": ("m", "axial depth of a cut free of chatter at every spindle speed"),
    "depth_here": ("m", "the same at the spindle speed of the cut; inf: no lobe there"),
    "chatter_frequency": ("Hz", "frequency of the chatter that sets the depth"),
}

Maker = Callable[[np.ndarray, np.ndarray], dict[str, np.ndarray]]


def limits_of(machine, name: str) -> tuple[str, ...]:
    """What the entries of `<name>_limit` count: joint by joint, for each thing that limits."""
    kinds = {"feed": ("speed", "acceleration", "force"), "acceleration": ("acceleration", "force")}
    return tuple(f"{joint}: {kind}" for kind in kinds.get(name, ("force",)) for joint in machine.joint_names)


# the number of each that is worst: least, or greatest
WORST = {
    "reserve": min, "condition": max, "singular_least": min, "feed": min, "turn_rate": min, "acceleration": min,
    "angular_acceleration": min, "force": min, "holding": max, "holding_share": max, "stiffness_least": min,
    "stiffness_x": min, "stiffness_y": min, "stiffness_z": min, "frequency": min, "sag": max, "depth": min,
    "depth_here": min,
}  # fmt: skip

# the variable that a map of that name shows
SHOWN = {
    "workspace": "reserve", "dexterity": "condition", "feed": "feed", "acceleration": "acceleration", "force": "force",
    "gravity": "holding_share", "stiffness": "stiffness_least", "chatter": "depth",
}  # fmt: skip


def checked(name: str, machine, count: int) -> Maker:
    """What makes the columns of `name` out of poses (N, d) and which of them are inside.

    Raises
    ------
    ExperimentError
        the machine has not what it takes, or a stiffness map of too many poses.
    """
    speed, acceleration, force = abilities.limits_of(machine)
    lacks = {
        "feed": ("limits.speed, limits.acceleration or a limit of the drive", min(speed, acceleration, force)),
        "acceleration": ("limits.acceleration or a limit of the drive", min(acceleration, force)),
        "force": ("a limit of the drive: drive.torque_limit or drive.force_limit", force),
    }
    if name in lacks and not np.isfinite(lacks[name][1]):
        raise ExperimentError(
            f"a map of {name} needs {lacks[name][0]}", key="what", value=f"{machine.name} has none",
            cure="write it into the data sheet",
        )  # fmt: skip
    if name == "dexterity" and len(machine.task) == 1:
        raise ExperimentError(
            "one axis has the same dexterity everywhere", key="what", value=machine.name, cure="ask for feed or force"
        )
    if name == "stiffness":
        if not machine.compliance:
            raise ExperimentError(
                "a map of stiffness needs [[compliance]]", key="what", value=f"{machine.name} has none",
                cure="say in the data sheet what gives way: docs/flexible.md",
            )  # fmt: skip
        checked_count(name, count)
    return _MAKERS[name](machine)


def checked_count(name: str, count: int) -> None:
    """Refuse a map of an elastic machine of more poses than anybody waits for."""
    if count > MOST_ELASTIC:
        raise ExperimentError(
            f"a map of {name} takes milliseconds a pose: too many", key="points", value=f"{count} poses",
            limit=f"{MOST_ELASTIC}", cure="take fewer points",
        )  # fmt: skip


def _masked(values, inside):
    values = np.array(values, float)
    values[~inside] = np.nan
    return values


def _workspace(machine) -> Maker:
    return lambda x, inside: {}  # what every map has


def _dexterity(machine) -> Maker:
    def make(x, inside):
        s = abilities.Evaluated("dexterity", machine)(x)[0]
        with np.errstate(divide="ignore", invalid="ignore"):
            number = s[:, 1] / s[:, 0]
        names = ("condition", "singular_least", "singular_greatest")
        return {key: _masked(value, inside) for key, value in zip(names, (number, *s.T), strict=True)}

    return make


def _least(r, inside, names) -> dict[str, np.ndarray]:
    """The least of r (N, sorts, what, n), of each sort, and whose the first is."""
    flat = r.reshape(len(r), r.shape[1], -1)
    found = {key: _masked(flat[:, k].min(-1), inside) for k, key in enumerate(names[: r.shape[1]])}
    known = np.where(np.isnan(flat[:, 0]), np.inf, flat[:, 0]).argmin(-1)
    return found | {f"{names[0]}_limit": np.where(inside, known, -1).astype("i2")}


def _feed(machine) -> Maker:
    return lambda x, inside: _least(abilities.feeds(machine, x)[0], inside, ("feed", "turn_rate"))


def _acceleration(machine) -> Maker:
    names = ("acceleration", "angular_acceleration")
    return lambda x, inside: _least(abilities.accelerations(machine, x), inside, names)


def _force(machine) -> Maker:
    return lambda x, inside: _least(abilities.forces(machine, x)[1][:, None, None], inside, ("force",))


def _gravity(machine) -> Maker:
    limit = abilities.limits_of(machine)[2]

    def make(x, inside):
        held = np.abs(abilities.forces(machine, x)[0]).max(-1)
        share = {"holding_share": _masked(held / limit, inside)} if np.isfinite(limit) else {}
        return {"holding": _masked(held, inside)} | share

    return make


def _stiffness(machine) -> Maker:
    from ..machine.vibration import stiffness_map

    flexible = machine.flexible()

    def make(x, inside):
        found = stiffness_map(flexible, x[inside])
        columns = {
            "stiffness_least": found["least"], "frequency": found["frequency"],
            "sag": np.linalg.norm(found["sag"], axis=-1),
            **{f"stiffness_{axis}": found["stiffness"][:, k] for k, axis in enumerate("xyz")},
        }  # fmt: skip
        out = {}
        for key, values in columns.items():
            out[key] = np.full(len(x), np.nan)
            out[key][inside] = values
        return out

    return make


_MAKERS = {
    "workspace": _workspace, "dexterity": _dexterity, "feed": _feed, "acceleration": _acceleration, "force": _force,
    "gravity": _gravity, "stiffness": _stiffness,
}  # fmt: skip
