"""What a corner costs: stop at it, round it within a tolerance, or run past it and let the machine do what it can."""

import gough as gk

machine = gk.load_machine("nist-octahedral")
law = gk.ComputedTorque(bandwidth=16.0)
square = [[0, 0, 0], [0.04, 0, 0], [0.04, 0.04, 0], [0, 0.04, 0], [0, 0, 0]]

found = {}
for name, options in {
    "stop": {"corner": "stop"},
    "blend 0.4 mm": {"corner": "blend", "tolerance": 0.4e-3},
    "blend 0.8 mm": {"corner": "blend", "tolerance": 0.8e-3},
    "constant": {"corner": "constant"},
}.items():
    program = gk.Polyline(points=square, feed=0.1, profile="jerk_limited", **options)
    log = gk.simulate(machine, law, program)
    found[name] = time, error = program.plan(machine).feed.duration, gk.measure(log).contour_error["max"]
    print(f"{name:13} {time:6.3f} s  contour error {1e6 * error:6.1f} um")

times = [time for time, _ in found.values()]
assert times == sorted(times, reverse=True), "the less a corner is kept, the sooner the square is done"
# rounded on purpose by less than the tolerance, and by the machine's own error, as it has when it stops
for name, tolerance in (("blend 0.4 mm", 0.4e-3), ("blend 0.8 mm", 0.8e-3)):
    assert found[name][1] < tolerance + found["stop"][1]
assert found["constant"][1] > 3 * found["stop"][1], "a velocity that jumps is what no machine can follow"
