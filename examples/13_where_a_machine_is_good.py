"""Where a hexaglide accelerates hardest, what it can do in every direction there, and how far the edge is away."""

import json

import numpy as np

import gough as gk
from gough.plan.findings import findings, text_of
from gough.plan.maps import machine_map
from gough.report import style

machine = gk.load_machine("eth-hexaglide")
found = machine_map(machine, ["workspace", "acceleration", "gravity"], over=("x", "y", "z"), points=(21, 21, 7))
print(text_of(findings(found)))

best = found["acceleration"].where(found["declared"] == 1).argmax(...)
place = {name: float(found[name][index]) for name, index in best.items()}
x = np.array([*(place[name] for name in "xyz"), 0, 0, 0])
promised = float(found["acceleration"].isel(best))
print(f"hardest at {[round(1e3 * v) for v in x[:3]]} mm: {promised:.2f} m/s2 in any direction")

# every direction of that size is possible, and a little more is not: some drive or carriage is at its limit
d = np.random.default_rng(0).standard_normal((20_000, 3))
xdd = np.zeros((len(d), 6))
xdd[:, :3] = promised * d / np.linalg.norm(d, axis=1, keepdims=True)
still = np.zeros(6)
force = np.abs(machine.inverse_dynamics(x, still, xdd)) / machine.drive.force_limit
speedup = np.abs(machine.joint_motion(x, still, xdd)[2]) / machine.limits.acceleration
most = max(force.max(), speedup.max())
print(f"of 20 000 directions the worst takes {100 * most:.2f} % of a limit")
assert 0.999 < most <= 1 + 1e-12

# and how far that is from the edge: no direction leaves the ball, so no coordinate does
edge = gk.envelope(machine, x)
print(edge)
ball, turn = (one.radius for one in edge.balls)
assert all(way.distance >= ball - 1e-12 for way in edge.ways if way.unit == "m")
assert 0.05 < ball < 0.5 and np.radians(10) < turn < np.pi / 2
assert json.loads(found.attrs["gough"])["fixed"] == {"a": 0.0, "b": 0.0, "c": 0.0}

across = found.isel(x=best["x"])  # the rails run along x: it is the same at every x
ax = style.new_axes((8.0, 4.4))
ax.grid(False)
colours = ax.contourf(1e3 * found["y"], 1e3 * found["z"], across["acceleration"].T, levels=14, cmap="cividis")
ax.plot(*(1e3 * x[1:3]), "o", markersize=9, markerfacecolor="none", markeredgecolor="#D55E00", markeredgewidth=2)
ax.set_aspect("equal")
ax.figure.colorbar(colours, label="acceleration in any direction [m/s²]", shrink=0.85)
style.label(ax, f"{machine.name}, across its rails: the ring is where it is best", "y [mm]", "z [mm]")
style.save(ax, "results/13_where_a_machine_is_good.png")
