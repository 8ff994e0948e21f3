"""gough explain: what an error means, why it comes, and what to do."""

from __future__ import annotations

from textwrap import fill

from .. import errors
from ..errors import ExperimentError, GoughError, did_you_mean
from .end import Outcome

# code: what it means beyond the first line of its class; usual causes and cures
MORE = {
    "UnitError": (
        'Quantities are texts with a unit: "20 mm", "3 m/min", "40 N m", "1.2 x" (times what it is). A bare '
        "number, an unknown unit or one of another dimension is refused; nothing is guessed."
    ),
    "SheetError": (
        "A key is missing, unknown or out of its bounds, a body has an inertia that no body has, or joints "
        "lie where no machine can stand. All mistakes of the file are told at once, each with its line. "
        "`gough new machine` writes a sheet with every key explained; `gough show NAME` shows one of the "
        "library."
    ),
    "ExperimentError": (
        "A table or a key is missing, unknown or out of its bounds, parts do not go together, or an option of "
        "a command is wrong. All mistakes are told at once. `gough new experiment` writes a file with every "
        "key explained; `gough check FILE` finds every mistake without running it."
    ),
    "ProgramError": (
        "NC programs are read as LinuxCNC 2.9 reads them; where gough differs, docs/nc-differences.md says "
        "why. The message names file, line and word. A path of one's own must be finite, in one piece and "
        "long enough to be seen."
    ),
    "LogError": (
        "A column is missing or has other units, times do not rise, a file is cut off, or a signal that is "
        "asked for was not recorded. A map (`gough new map`) tells what the columns of somebody else's log "
        "mean."
    ),
    "KinematicsError": (
        "Newton's method found no pose that these joint coordinates have, or one in another assembly mode: "
        "the machine would have to pass a singular pose to get there. Start nearer (`near=`), or check the "
        "joint coordinates."
    ),
    "WorkspaceError": (
        "The message says which strut, carriage or joint, its value, its limit, when, and the NC line. Move "
        "the workpiece ([program] origin), tilt less, or correct the limit if the data sheet is wrong. "
        "Nothing is ever clipped."
    ),
    "SingularityError": (
        "Near such a pose forces grow without bound, or the platform moves with its joints locked. Keep away "
        "from it: less tilt, another place. `limits.determinant` of the data sheet says how near is too near."
    ),
    "FollowingError": (
        "The drives could not follow: too little force, gains too low, friction, or an unstable loop. "
        "`ferror` and `min_ferror` of [run] set the trip, as on a real controller. See the following error in "
        "the report before the trip."
    ),
    "EncoderError": (
        "The forces on the joint cannot have made the motion that its encoder reads: it sticks, jumps or "
        "drifts. `encoder_check` of [run] sets the force that counts; `stop_ramp` brings the machine to rest "
        "along its path."
    ),
    "DivergedError": (
        "The loop is unstable, or the step of the plant is too long for its fastest motion. The run warns of "
        "the loop's spectral radius before it starts: lower the bandwidth, shorten the period, or give more "
        "`substeps`. The log holds everything up to the last finite sample."
    ),
    "StorageError": (
        "The disk is full, the folder cannot be written, or a file was changed after it was written: its "
        "checksum tells. What was there before is as it was; nothing is half written."
    ),
    "InputError": (
        "The error of anything handed in; its kinds: UnitError, SheetError, ExperimentError, ProgramError, LogError."
    ),
    "RunError": (
        "The error of anything carried out; its kinds: KinematicsError, WorkspaceError, SingularityError, "
        "FollowingError, EncoderError, DivergedError, StorageError. A run that fails still writes its log and "
        "its page."
    ),
    "GoughError": (
        "The base of all errors: `except gk.GoughError` catches each of them. `error.problems` has one entry "
        "for each finding: rule, file, line, key, value, cure, where, time, limit."
    ),
}


def codes() -> dict[str, type[GoughError]]:
    """Every code of an error, as --json gives it, and its class."""
    found = {name: one for name, one in vars(errors).items() if isinstance(one, type) and issubclass(one, GoughError)}
    return {name: found[name] for name in sorted(found)}


def explain(code: str | None, outcome: Outcome) -> None:
    """Say what an error of this code means; without one, what there is.

    Raises
    ------
    ExperimentError
        there is no such code.
    """
    known = codes()
    if code is None:
        outcome.data["codes"] = {name: _first(one) for name, one in known.items()}
        if not outcome.as_json:
            width = max(map(len, known))
            outcome.say(*(f"{name:{width}}  exit {one.exit_status}  {_first(one)}" for name, one in known.items()))
        return
    if code not in known:
        raise ExperimentError(
            "there is no such error", key="CODE", value=ascii(code)[:60], cure=did_you_mean(code, known)
        )
    one = known[code]
    outcome.data.update(code=code, exit_status=one.exit_status, meaning=_first(one), more=MORE[code])
    if not outcome.as_json:
        kind = "the input is wrong" if one.exit_status == 2 else "the run failed"
        outcome.say(f"{code}  (exit status {one.exit_status}: {kind})", "", _first(one), "", fill(MORE[code], 96))


def _first(one: type[GoughError]) -> str:
    return (one.__doc__ or "").strip().partition("\n")[0]
