"""A machine that sags by 0.35 mm and swings at 29 Hz: where its tool is, by three laws and two feeds of one time."""

import numpy as np

import gough as gk
from gough.control.flexible_feedforward import FlexibleFeedforward
from gough.control.gravity_compensation import GravityCompensation
from gough.report import style

machine = gk.load_machine("ifma-hsm")
flexible = machine.flexible()
target = np.array([-0.315, 1.83, 0.55])
mode = flexible.modes(target)
print(f"at the target: sag {1e6 * (flexible.settled_pose(target)[1] - target[1]):.0f} um, {mode.frequency[0]:.1f} Hz")

law = gk.ComputedTorque(bandwidth=12.0)
laws = {"rigid model": law, "gravity": GravityCompensation(law=law), "flexible": FlexibleFeedforward(law=law)}
way = target - machine.home
cycle, speed = 0.75, 1.8  # s, m/s: what is left of the time is for ramps
spare = cycle - np.linalg.norm(way) / speed
line = gk.Line(to=way, feed=speed, lead_in=0.25, settle=0.4)
smooth = speed / (spare - 1 / mode.frequency[0])  # one period of the mode for a ramp of the acceleration
feeds = {
    "steps": line.replace(acceleration=speed / spare),
    "jerk": line.replace(acceleration=smooth, profile="jerk_limited", jerk=smooth * mode.frequency[0]),
}

error = {}
ax = style.new_axes((8.0, 4.4))
for feed, name in (("steps", "rigid model"), *(("jerk", name) for name in laws)):
    log = gk.simulate(machine, laws[name], feeds[feed], plant=gk.Plant(machine=machine, flexible=True), period=1e-4)
    gap = np.linalg.norm((log["x"] - log["x_r"])[:, :3], axis=1)
    ax.plot(log["t"], 1e6 * (log["x"] - log["x_r"])[:, 1], label=f"{feed}, {name}")
    on, behind = (log["t"] > 0.25) & (log["t"] < 0.25 + cycle), log["t"] > 0.25 + cycle
    error[feed, name] = found = gap[on].max(), np.ptp(log["x"][behind, 1]), gap[-1]
    way_, swing, rest = (f"{1e6 * value:5.1f} um" for value in found)
    print(f"{feed:6} {name:12} {way_} on its way, {swing} swing behind, {rest} at rest")

assert error["jerk", "rigid model"][2] > 300e-6
assert error["jerk", "gravity"][2] < 1e-6
assert error["jerk", "flexible"][0] < error["jerk", "gravity"][0] / 10
assert error["jerk", "rigid model"][1] < error["steps", "rigid model"][1] / 4

ax.axvspan(0.25, 0.25 + cycle, color="#f0f2f4", linewidth=0, zorder=0)
style.label(ax, "Height error of the tip; grey: on its way", "time [s]", "error along y [µm]")
style.legend(ax, loc="lower left")
style.save(ax, "results/10_a_machine_that_gives_way.png")
