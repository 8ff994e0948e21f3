"""A hexapod whose struts and joints give way: how stiff the tool is, what swings first, and what encoders see of it.

The law believes a rigid machine.  Encoders on the motors never see the springs behind them; direct scales along the
struts do, and let the same law put the tool where it belongs.
"""

import numpy as np

import gough as gk
from gough.report import style

machine = gk.load_machine("nist-octahedral").replace(friction=None, **{"joints.friction": None})
flexible = machine.flexible()

stiffness = flexible.static_stiffness(machine.home)
print("stiffness along x, y, z, N/um:", (stiffness * 1e-6).round(1))
print("natural frequencies, Hz:", flexible.modes(machine.home).frequency.round(1))

push = np.array([0, 200, 0, 0, 0, 0.0])
sag = flexible.settled_pose(machine.home, push)[:3]
print("gravity and 200 N along y bend the tool by, um:", (1e6 * sag).round(1))
assert abs(sag[1] - 200 / stiffness[1]) < 0.01 * sag[1], "a force over a stiffness is a deflection"

ax = style.new_axes()
circle, law, mean = gk.Circle(radius=0.1, feed=0.05), gk.PID(bandwidth=4.0), {}
for encoders in ("motor", "joint"):
    plant = gk.Plant(machine=machine, flexible=True, measured=encoders, wrench=push)
    log = gk.simulate(machine, law, circle, plant=plant)
    mean[encoders] = gk.measure(log).contour_error["mean"]
    ax.plot(log.t, 1e6 * (log["x"] - log["x_r"])[:, 2], label=f"encoders at the {encoders}s")
    print(f"encoders at the {encoders}s: mean contour error {1e6 * mean[encoders]:.2f} um")

assert mean["motor"] > abs(sag[2]), "sag is across the circle, and nothing that the motors know takes it away"
assert mean["joint"] < 0.2 * mean["motor"], "behind the springs the encoders see all of it"

style.label(ax, "How far the tool hangs below its circle", "time [s]", "height error [µm]")
style.legend_above(ax)
style.save(ax, "results/09_what_gives_way.png")
