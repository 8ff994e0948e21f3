"""Named functions and a schedule in, machine code out: simulations side by side.  It knows nothing of machines.

schedule = Schedule(signals, tasks, substep, substeps=4, limits=limits, log=("x", "u"), period=1e-3)
kernel = compile(schedule, lanes=1)
simulation = kernel.start(parameters={...}, states={...}, seed=0)
rows = simulation.advance(1000, inputs={"reference": table})        # (ticks, runs, width)
"""

from .kernel import Kernel, KernelWarning, compile
from .rows import Rows, compile_rows
from .schedule import Schedule, Signal, Task, period_ticks
from .simulation import Simulation, Stop

__all__ = [
    "Kernel", "KernelWarning", "Rows", "Schedule", "Signal", "Simulation", "Stop", "Task", "compile", "compile_rows",
    "period_ticks",
]  # fmt: skip
