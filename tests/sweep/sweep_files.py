"""What the tests of sweeps share."""

from __future__ import annotations

FILE = """\
schema = "gough-experiment-1"
[machine]
use = "nist-octahedral"
[plant]
"friction.coulomb" = "0.9 x"
[program]
kind = "circle"
radius = "20 mm"
feed = "6 m/min"
turns = 0.2
settle = "0.01 s"
[[controller]]
kind = "pid"
bandwidth = "10 Hz"
[[controller]]
kind = "computed_torque"
bandwidth = "10 Hz"
[sweep]
vary = {{ {vary} }}
{more}
"""


def runs_of(folder):
    """id -> bytes of every run's file of a store."""
    return {path.stem: path.read_bytes() for path in (folder / "runs").glob("*/*.json")}
