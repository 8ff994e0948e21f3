"""Where the moves of an NC program come from: the modes in force and the run of its line that made each block."""

from __future__ import annotations

import copy
from typing import NamedTuple

from ..program.blocks import Block, Blocks
from ..program.nc import NCProgram
from ..program.ngc.flow import run
from ..program.ngc.interpreter import Interpreter
from ..program.ngc.modes import Modes
from ..program.ngc.offsets import Offsets
from ..program.ngc.parameters import Parameters


class Origin(NamedTuple):
    """Of one block: the number of the line's run that made it, its line, and what was in force."""

    run: int
    line: int
    modes: Modes
    offsets: Offsets


class _Traced(Blocks):
    """Blocks that note what was in force when they came."""

    def __init__(self):
        super().__init__()
        self.origins: list[Origin] = []
        self.run, self.interpreter = 0, None
        self._last = None  # modes and offsets are copied when they change

    def append(self, block: Block) -> None:
        super().append(block)
        machine = self.interpreter
        modes, offsets = machine.modes, machine.offsets
        key = (tuple(vars(modes).values()), offsets.shift, offsets.turned, tuple(offsets._origin), offsets._theta)
        if self._last is None or self._last[0] != key:
            self._last = key, copy.copy(modes), copy.copy(offsets)
            kept = self._last[2]
            kept._origin, kept._shift = list(offsets._origin), list(offsets._shift)
        self.origins.append(Origin(self.run, block.line, *self._last[1:]))


def trace(program: NCProgram) -> list[Origin]:
    """The origin of every block of `program.path()`, in order."""
    parameters = Parameters()
    for number, value in program.parameters.items():
        parameters.keep(number, value)
    blocks = _Traced()
    machine = blocks.interpreter = Interpreter(parameters, blocks, program.tools)

    def execute(words) -> bool:
        blocks.run += 1
        return machine.execute(words)

    run(
        program.text, execute, parameters, file=program.name, folders=[program.subroutines], steps=program.steps,
        block_delete=program.block_delete,
    )  # fmt: skip
    return blocks.origins
