"""The log of a run: labelled, self-describing, prints itself."""

from .log import Log

__all__ = ["Log"]
