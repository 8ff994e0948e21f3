"""A data sheet and an experiment that are right, for tests to spoil."""

SHEET = """\
schema = "gough-machine-1"
name = "mine"
kind = "hexapod"

[platform]
mass = "120 kg"
center = { unit = "m", value = [0, 0, 0.3] }
inertia = { unit = "kg m2", value = [[5, 0, 0], [0, 5, 0], [0, 0, 6]] }

[joints]
base = { unit = "m", value = [
    [-0.1455, 0.6847, 1.0], [0.1455, 0.6847, 1.0], [-0.5202, -0.4684, 1.0],
    [-0.6657, -0.2163, 1.0], [0.6657, -0.2163, 1.0], [0.5202, -0.4684, 1.0],
] }
platform = { unit = "m", value = [
    [-0.1262, 0.1802, 0.25], [0.1262, 0.1802, 0.25], [-0.0930, -0.1994, 0.25],
    [-0.2192, 0.0192, 0.25], [0.2192, 0.0192, 0.25], [0.0930, -0.1994, 0.25],
] }

[drive]
lead = "20 mm"

[limits]
length = ["0.70 m", "1.15 m"]

[home]
pose = ["0 mm", "0 mm", "0 mm", "0 deg", "0 deg", "0 deg"]
"""

EXPERIMENT = """\
schema = "gough-experiment-1"

[machine]
use = "nist-octahedral"

[program]
kind = "circle"
radius = "20 mm"
feed = "6 m/min"

[[controller]]
kind = "pid"
bandwidth = "10 Hz"

[[controller]]
kind = "computed_torque"
bandwidth = "10 Hz"

[run]
period = "1 ms"
"""

CIRCLE = 'kind = "circle"\nradius = "20 mm"\nfeed = "6 m/min"'  # in EXPERIMENT
