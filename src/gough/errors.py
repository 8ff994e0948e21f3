"""One tree of errors.  An error names the place, the rule, the value and the cure, in that order of need.

GoughError
  InputError   exit status 2, the input is wrong     UnitError SheetError ExperimentError ProgramError LogError
  RunError     exit status 1, the run failed         KinematicsError WorkspaceError SingularityError DivergedError
                                                     FollowingError EncoderError StorageError
"""

from __future__ import annotations

import dataclasses
import difflib
from collections.abc import Iterable
from dataclasses import dataclass


@dataclass(frozen=True)
class Problem:
    """One thing that is wrong: where it stands, what was expected, what was found, what to do."""

    rule: str
    file: str | None = None
    line: int | None = None
    key: str | None = None
    value: str | None = None
    cure: str | None = None
    where: str | None = None  # joint, signal or pose, for a run
    time: float | None = None  # s, for a run
    limit: str | None = None

    def __str__(self) -> str:
        place = ":".join(str(part) for part in (self.file, self.line) if part is not None)
        head = ": ".join(part for part in (place, self.key, self.where) if part)
        text = f"{head}: {self.rule}" if head else self.rule
        if self.value is not None:
            text += f", got {self.value}"
        if self.limit is not None:
            text += f" (limit {self.limit})"
        if self.time is not None:
            text += f" at t = {self.time:.6g} s"
        return f"{text}; {self.cure}" if self.cure else text


class GoughError(Exception):
    """Base of all errors of gough.  `problems` holds every finding; the message is one line each."""

    exit_status = 1

    def __init__(self, rule: str | None = None, *, problems: Iterable[Problem] = (), **parts):
        self.problems = tuple(problems) or (Problem(rule or "unknown problem", **parts),)
        super().__init__("\n".join(map(str, self.problems)))

    def __reduce__(self):  # worker processes send errors home
        return _rebuild, (type(self), self.problems)

    def at(self, **parts) -> GoughError:
        """The same error with its place filled in where it was still unknown (file, line, key, ...)."""
        return type(self)(
            problems=[
                dataclasses.replace(p, **{k: v for k, v in parts.items() if getattr(p, k) is None})
                for p in self.problems
            ]
        )

    def to_json(self) -> dict:
        """What `--json` prints under "error"."""
        return {
            "code": type(self).__name__,
            "problems": [{k: v for k, v in dataclasses.asdict(p).items() if v is not None} for p in self.problems],
        }


def _rebuild(kind: type[GoughError], problems: tuple[Problem, ...]) -> GoughError:
    return kind(problems=problems)


class InputError(GoughError, ValueError):  # a ValueError, so that pydantic collects it
    """What was handed in is wrong."""

    exit_status = 2


class UnitError(InputError):
    """A text is not a quantity, or not of this dimension."""


class SheetError(InputError):
    """A data sheet of a machine is wrong."""


class ExperimentError(InputError):
    """An experiment file, or an argument of a part, is wrong."""


class ProgramError(InputError):
    """An NC program or a path cannot be understood or followed."""


class LogError(InputError):
    """A log cannot be read, or lacks what was asked of it."""


class RunError(GoughError):
    """What was handed in was understood; carrying it out failed."""


class KinematicsError(RunError):
    """No pose found for these joint coordinates, or one of another assembly mode."""


class WorkspaceError(RunError):
    """A joint, a strut or the pose is outside its limits."""


class SingularityError(RunError):
    """The joints lose or gain a freedom here."""


class FollowingError(RunError):
    """A joint was too far from where it should be: the trip has switched the drives off."""


class EncoderError(RunError):
    """An encoder read what no force explains: the run was brought to rest."""


class DivergedError(RunError):
    """A number of the run is no longer finite."""


class StorageError(RunError):
    """A result could not be written or is damaged."""


def nearest(word: str, options: Iterable[str]) -> str | None:
    """The option most like `word`, or None.  Case does not count."""
    options = list(options)
    folded = {option.casefold(): option for option in options}
    found = difflib.get_close_matches(word.casefold(), folded, n=1, cutoff=0.6)
    return folded[found[0]] if found else None


def did_you_mean(word: str, options: Iterable[str]) -> str:
    """The cure for an unknown word: the nearest right one, else all of them."""
    options = list(options)
    found = nearest(word, options)
    if found:
        return f"did you mean {found}?"
    return f"there is {', '.join(options)}" if options else "there is none"
