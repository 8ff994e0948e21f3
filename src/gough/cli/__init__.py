"""The command line, `gough`: one module a command, `end` for how a command ends."""

from .app import main

__all__ = ["main"]
