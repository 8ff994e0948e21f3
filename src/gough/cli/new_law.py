"""The template of a control law: a file that runs as it stands."""

CONTROLLER = '''\
"""A control law of one's own: spring and damper at every joint, beside the forces that the model asks for.

Run it:  python THIS_FILE
"""

from typing import Any, NamedTuple

import casadi as ca
import numpy as np

import gough as gk
from gough.control.base import Command, Controller
from gough.declare import quantity
from gough.mechanics.linear import solve_square_transposed


class State(NamedTuple):
    """What the law remembers from sample to sample; logged as controller.<name>."""

    q: Any  # joints of the last sample, (n,) m
    rest: Any  # forces at rest that the model did not know, (n,) N


class SpringAndDamper(Controller):
    """u = model(reference) + rest + k (q_r - q) + d (q_r' - q')"""

    kind: str = "spring_and_damper"
    # numbers of the law, with unit, meaning and bounds; checked when the law is made
    stiffness: float = quantity("N/m", "k, force for a metre of error", above=0)
    damping: float = quantity("N s/m", "d, force for a metre a second", above=0)

    def init(self, r0, u0):
        """The first state, in NumPy.  Its `rest` makes the first step give u0, what holds the machine before it."""
        still = 0 * np.ravel(r0.x)
        return State(np.ravel(r0.q), np.ravel(u0) - self.machine.inverse_dynamics(np.ravel(r0.x), still, still))

    def step(self, state, r, y, theta):
        """One sample: r the Reference (x, xd, xdd, q, qd, ...), y the Measurement (q, u), theta the law's numbers.

        Written in CasADi's operations it is compiled: ca.tanh, ca.fmin, ca.if_else, ...
        """
        p = self.at(theta)  # p.stiffness, p.damping, p.machine.* as symbols: one kernel serves every value
        speed = (y.q - state.q) / p.period  # encoders tell no speed
        u = self.model(p.machine, r) + state.rest + p.stiffness * (r.q - y.q) + p.damping * (r.qd - speed)
        return Command(u), State(y.q, state.rest)

    def model(self, p, r):
        """The joint forces (n,) that the reference motion takes, by the machine that the law believes."""
        m = self.machine
        z = m.coordinates_of(p, r.x)
        v = m.velocity_of(p, z, r.xd)
        bodies = {name: value for name, (value, _) in m.inertial(p).items()}
        force = m.inverse_force(p, bodies, z, v, m.acceleration_of(p, z, v, r.xdd))  # on the velocities v
        return solve_square_transposed(m.jacobian_of(p, z), force)  # J' u = force


if __name__ == "__main__":
    machine = gk.load_machine("nist-octahedral")
    circle = gk.Circle(radius=0.05, feed=0.05)
    for law in (SpringAndDamper(stiffness=1e7, damping=5e4), gk.PID(bandwidth=10.0)):
        log = gk.simulate(machine, law, circle)
        print(f"{law.kind}: contour error {1e6 * gk.measure(log).contour_error['max']:.1f} um at most")
'''
