"""A law of your own: a sliding surface on every strut, smoothed.  It is compiled like those that come with gough."""

from typing import Any, NamedTuple

import casadi as ca
import numpy as np

import gough as gk
from gough.control.base import Command, Controller
from gough.declare import quantity
from gough.report import style


class State(NamedTuple):
    q: Any  # joints of the last sample, m
    u0: Any  # forces at rest, N


class SlidingMode(Controller):
    """u = u0 + f tanh(s / phi),   s = q_r' - q' + lam (q_r - q)"""

    kind: str = "sliding_mode"
    lam: float = quantity("1/s", "slope of the sliding surface", above=0)
    phi: float = quantity("m/s", "width of the boundary layer", above=0)
    force: float = quantity("N", "switching force", above=0)

    def init(self, r0, u0):
        return State(np.ravel(r0.q), np.ravel(u0))

    def step(self, state, r, y, theta):
        p = self.at(theta)
        s = r.qd - (y.q - state.q) / p.period + p.lam * (r.q - y.q)
        return Command(state.u0 + p.force * ca.tanh(s / p.phi)), State(y.q, state.u0)


machine = gk.load_machine("nist-octahedral")
circle = gk.Circle(radius=0.05, feed=0.05)
error = {}
ax = style.new_axes()
for width in (0.01, 0.04):
    law = SlidingMode(lam=40.0, phi=width, force=3000.0)
    log = gk.simulate(machine, law, circle, period=2.5e-4)
    error[width] = gk.measure(log).contour_error["rms"]
    print(f"layer {1e3 * width:.0f} mm/s: {1e6 * error[width]:.1f} um rms")
    ax.plot(log.t, 1e6 * log["contour_error"], label=f"layer of {1e3 * width:.0f} mm/s")

assert log.dataset.attrs["status"] == "done"
assert error[0.01] < error[0.04]  # a thinner layer is a higher gain

style.label(ax, "A circle: the thinner the layer, the nearer the tool", "time [s]", "contour error [µm]")
style.legend(ax)
style.save(ax, "results/03_a_law_of_your_own.png")
