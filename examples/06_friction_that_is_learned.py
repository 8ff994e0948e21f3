"""Friction that nobody told the law: computed torque leaves a mark at every reversal, adaptive laws learn it away."""

import numpy as np

import gough as gk
from gough.report import style

machine = gk.load_machine("nist-octahedral").replace(**{"drive.encoder": 1e-6})
# what is believed is a fifth too light and too smooth
wrong = ["platform.mass", "strut.moving.mass", "strut.fixed.mass", "drive.inertia"]
wrong += ["friction.coulomb", "friction.static", "friction.viscous", "friction.viscous_offset"]
believed = machine.replace_from_file(dict.fromkeys(wrong, "0.8 x"))
circle = gk.Circle(radius=0.2, feed=0.05, start=np.radians(240.0))  # one turn: every strut reverses twice

laws = {
    "computed torque": gk.ComputedTorque(poles=[100.0, 100.0, 200.0]),
    "robust adaptive": gk.RobustAdaptive(slope=150.0, damping=370.0),
    "fuzzy friction": gk.FuzzyFriction(slope=150.0, damping=370.0),
}
error = {}
panels = style.new_panels(3, (8.0, 6.0))
for ax, (name, law) in zip(panels, laws.items(), strict=True):
    log = gk.simulate(believed, law, circle, plant=machine)
    second_half = log["t"] > 12.0  # what is learned is learned in the first
    error[name] = log["contour_error"][second_half & (log["t"] < 25.0)].max()
    ax.plot(log["t"], 1e6 * log["contour_error"], color=style.COLOURS[panels.index(ax)])
    style.label(ax, name.capitalize(), "", "contour error [µm]")
    print(f"{name:15} {1e6 * error[name]:5.1f} um")
    if "controller.coulomb" in log.dataset:
        learned = machine.friction.coulomb / believed.friction.coulomb
        print(f"{'':15} Coulomb factors {np.round(log['controller.coulomb'][-1], 2)}, true {learned:.2f}")

assert error["robust adaptive"] < error["computed torque"] / 2
assert error["fuzzy friction"] < error["computed torque"] / 2

for ax in panels:
    ax.set(xlim=(0, 25), ylim=(0, 14))
panels[-1].set_xlabel("time [s]: one turn, every strut reverses twice")
style.save(panels[0], "results/06_friction_that_is_learned.png")
