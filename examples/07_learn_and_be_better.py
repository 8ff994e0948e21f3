"""A hexaglide believed a fifth wrong: ten seconds of one motion tell its numbers, and then it keeps a circle better."""

import numpy as np

import gough as gk
from gough.identify import excite
from gough.report import style

true = gk.load_machine("eth-hexaglide")
wrong = dict.fromkeys(["platform.mass", "carriage.mass", "friction.coulomb", "friction.viscous"], "0.8 x")
believed = true.replace_from_file(wrong)

# a motion of 10 s that shows the parameters, within every limit of the machine
motion = excite(believed, period=5.0, cycles=2, harmonics=3)
log = gk.simulate(believed, gk.ComputedTorque(bandwidth=30.0), motion, plant=true)
fit = gk.identify(log, believed)
print(fit)

# the numbers found, as factors of what is believed, for the law that computes its forces from them
names, values, _ = believed.parameters_of(friction=True)
told = [fit[name][0] / value if value else 1.0 for name, value in zip(names, values, strict=True)]
law = gk.DesiredTorqueAdaptive(pole=412.0, observer_pole=1000.0, learn=[])
circle = gk.Circle(radius=0.015, feed=0.3, turns=2)

error = {}
ax = style.new_axes((6.0, 6.0))
for name, estimates in (("believed", 1.0), ("identified", told)):
    log = gk.simulate(believed, law.replace(estimates=estimates), circle, plant=true, period=3e-4)
    error[name] = log.metrics["contour_error"]["rms"]
    x, y = (log["x"] - true.home)[(log.t > 0.15) & (log.t < 0.6), :2].T
    radius, angle = np.hypot(x, y), np.arctan2(y, x)
    shown = 1e3 * (0.015 + 200 * (radius - 0.015))
    ax.plot(shown * np.cos(angle), shown * np.sin(angle), label=name, linewidth=0.9)
    print(f"{name:11} {1e6 * error[name]:5.2f} um rms")

for name, value in zip(*true.parameters_of(friction=True)[:2], strict=True):
    if value:
        assert abs(fit[name][0] / value - 1) < 0.01, name
assert error["identified"] < error["believed"] / 3

turn = np.linspace(0, 2 * np.pi, 361)
ax.plot(15 * np.cos(turn), 15 * np.sin(turn), color=style.INK, linestyle=":", label="programmed")
ax.set_aspect("equal")
style.label(ax, "Circle at 0.3 m/s, radial error × 200", "x [mm]", "y [mm]")
style.legend(ax, loc="center")
style.save(ax, "results/07_learn_and_be_better.png")
