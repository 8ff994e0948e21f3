"""What a run warns of: said once when it is found, and kept for the log and its report."""

from __future__ import annotations

import warnings


class RunWarning(UserWarning):
    """Something about a run that makes its numbers mean less than they seem to."""


class StabilityWarning(RunWarning):
    """The closed loop of law, period and machine grows."""


class LawWarning(RunWarning):
    """Numbers of a law that do not go together."""


class ReachWarning(RunWarning):
    """The motion leaves the declared workspace, or comes near a singularity."""


class EffortWarning(RunWarning):
    """The drives are at their limits for much of the run."""


class EncoderWarning(RunWarning):
    """An encoder reads what no force explains."""


class Notes(list):
    """The warnings of one run, as texts in the order they were found."""

    def warn(self, text: str, category: type[RunWarning]) -> None:
        """Say a warning, unless it was said before."""
        if text not in self:
            self.append(text)
            warnings.warn(text, category, stacklevel=2)
