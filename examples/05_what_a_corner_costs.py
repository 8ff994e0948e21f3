"""What a corner costs: stop at it, round it within a tolerance, or run past it and let the machine do what it can."""

import gough as gk
from gough.report import style

machine = gk.load_machine("nist-octahedral")
law = gk.ComputedTorque(bandwidth=16.0)
square = [[0, 0, 0], [0.04, 0, 0], [0.04, 0.04, 0], [0, 0.04, 0], [0, 0, 0]]

found = {}
ax = style.new_axes((5.6, 5.6))
for name, options in {
    "stop": {"corner": "stop"},
    "blend 0.4 mm": {"corner": "blend", "tolerance": 0.4e-3},
    "blend 0.8 mm": {"corner": "blend", "tolerance": 0.8e-3},
    "constant": {"corner": "constant"},
}.items():
    program = gk.Polyline(points=square, feed=0.1, profile="jerk_limited", **options)
    log = gk.simulate(machine, law, program)
    found[name] = time, error = program.plan(machine).feed.duration, gk.measure(log).contour_error["max"]
    tip = 1e3 * (log["x"] - machine.home)[:, :2] - [40.0, 0.0]  # mm, from the first corner
    ax.plot(*tip.T, label=f"{name}: {time:.2f} s", linewidth=1.4)
    print(f"{name:13} {time:6.3f} s  contour error {1e6 * error:6.1f} um")

times = [time for time, _ in found.values()]
assert times == sorted(times, reverse=True), "the less a corner is kept, the sooner the square is done"
# rounded on purpose by less than the tolerance, and by the machine's own error, as it has when it stops
for name, tolerance in (("blend 0.4 mm", 0.4e-3), ("blend 0.8 mm", 0.8e-3)):
    assert found[name][1] < tolerance + found["stop"][1]
assert found["constant"][1] > 3 * found["stop"][1], "a velocity that jumps is what no machine can follow"

ax.plot([-3, 0, 0], [0, 0, 3], color=style.INK, linestyle=":", label="as programmed")
ax.set(xlim=(-2.2, 0.8), ylim=(-0.8, 2.2), aspect="equal")
style.label(ax, "One corner of a square, four ways", "x from the corner [mm]", "y from the corner [mm]")
style.legend(ax, loc="upper left")
style.save(ax, "results/05_what_a_corner_costs.png")
