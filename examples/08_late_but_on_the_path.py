"""A tool that is late need not leave its path: a law whose coordinates are contour errors and lag, on a 3-PRS head."""

import numpy as np

import gough as gk
from gough.report import style

machine = gk.load_machine("ccu-3prs")
machine = machine.replace(drive=machine.drive.perfect())  # encoders without steps: what is left is the laws'
circle = gk.Circle(radius=0.05, feed=0.1, start=0.3, lead_in=0.3, origin=[*machine.home, 0, 0, 0], center=[0, 0, 0])

# for 0.3 s the reference waits; the tool stands 2 mm ahead of it on the circle
ahead = 0.3 + 2e-3 / 0.05
there = machine.home + 0.05 * np.array([np.cos(ahead), np.sin(ahead), 0.0])
plant = gk.Plant(machine=machine, offset=there - circle.sample(1e-3, machine).x[0])

laws = {
    # the path's own frame where no equations of it are given; the printed b and c: poles at 20, 20 and 260 1/s
    "equivalent errors": gk.EquivalentError(),
    "computed torque": gk.ComputedTorque(poles=[20.0, 20.0, 260.0]),
}
left, back = {}, {}
ax = style.new_axes()
for name, law in laws.items():
    log = gk.simulate(machine, law, circle, plant=plant)
    waiting = log.t < 0.3
    radius = np.hypot(*(log["x"][waiting, :2] - machine.home[:2]).T)
    left[name] = np.abs(radius - 0.05).max()
    back[name] = np.abs(log["x"] - log["x_r"])[waiting][-1].max()
    lead = np.arctan2(*(log["x"][waiting, 1::-1] - machine.home[1::-1]).T) - 0.3
    ax.plot(1e3 * 0.05 * lead, 1e6 * (radius - 0.05), label=name, linewidth=1.6)
    print(f"{name:18} leaves the circle by {1e6 * left[name]:7.3f} um, after 0.3 s {1e6 * back[name]:6.2f} um away")

# 2 mm of arc are 10 um away from their chord: a law of joints cuts across, one of the path stays on it
sagitta = 2e-3**2 / (8 * 0.05)
assert left["equivalent errors"] < sagitta / 10 < sagitta / 2 < left["computed torque"]
assert max(back.values()) < 2e-3 / 20, "both come back"

style.label(ax, "The way back of a tool 2 mm ahead", "ahead along the circle [mm]", "outside the circle [µm]")
ax.invert_xaxis()
style.legend(ax)
style.save(ax, "results/08_late_but_on_the_path.png")
