"""Believe one machine, run another: a payload that nobody told the controller about."""

import gough as gk

machine = gk.load_machine("nist-octahedral")
circle = gk.Circle(radius=0.05, feed=0.1)

for payload in (None, 50.0):
    plant = gk.Plant(machine=machine, payload=payload)
    for law in (gk.PID(bandwidth=12.0), gk.ComputedTorque(bandwidth=16.0)):
        log = gk.simulate(machine, law, circle, plant=plant)
        error = gk.measure(log).contour_error
        rms, largest = 1e6 * error["rms"], 1e6 * error["max"]
        print(f"payload {payload or 0:2.0f} kg  {law.kind:16} {rms:5.2f} um rms {largest:5.1f} um max")


# at rest the struts carry the payload's weight from the first sample on: J' u is the force on the platform
def lift(plant):
    log = gk.simulate(machine, gk.PID(bandwidth=12.0), gk.Line(to=[0, 0, 0.01], feed=0.1, lead_in=0.1), plant=plant)
    return machine.jacobian(machine.home)[:, 2] @ log["u"][90]


weight = lift(gk.Plant(machine=machine, payload=50.0)) - lift(gk.Plant(machine=machine))
print(f"the struts carry {weight:.1f} N more")
assert abs(weight - 50 * 9.81) < 5  # N; the encoder's last digit moves the forces by that much
