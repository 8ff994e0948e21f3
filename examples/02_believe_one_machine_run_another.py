"""Believe one machine, run another: a payload that nobody told the controller about.

Neither law knows of the 50 kg.  Both hold them, and the struts tell: they carry 490 N more, all round the circle.
"""

import numpy as np

import gough as gk
from gough.report import style

machine = gk.load_machine("nist-octahedral")
circle = gk.Circle(radius=0.05, feed=0.1)

ax = style.new_axes()
for law in (gk.PID(bandwidth=12.0), gk.ComputedTorque(bandwidth=16.0)):
    carried = {}
    for payload in (0.0, 50.0):
        plant = gk.Plant(machine=machine, payload=payload or None)
        log = gk.simulate(machine, law, circle, plant=plant)
        error = gk.measure(log).contour_error
        rms, largest = 1e6 * error["rms"], 1e6 * error["max"]
        print(f"payload {payload:2.0f} kg  {law.kind:16} {rms:5.2f} um rms {largest:5.1f} um max")
        # J' u is the force of the struts on the platform: its z, row by row
        lift = np.array([machine.jacobian(x)[:, 2] @ u for x, u in zip(log["x"], log["u"], strict=True)])
        carried[payload] = lift[(log.t > 0.5) & (log.t < 2.5)].mean()
        if law.kind == "pid":
            ax.plot(log.t, lift, label=f"{payload:.0f} kg that nobody told of" if payload else "as believed")
    weight = carried[50.0] - carried[0.0]
    print(f"the struts carry {weight:.1f} N more")
    assert abs(weight - 50 * 9.81) < 5  # N, 1 %: what of the circle is not in the same phase

style.label(ax, "What the struts carry, under PID", "time [s]", "upward force on the platform [N]")
style.legend_above(ax)
style.save(ax, "results/02_believe_one_machine_run_another.png")
