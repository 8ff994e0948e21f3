"""A program that the tool could follow and the struts cannot: told before metal is cut, and what to do about it."""

import numpy as np

import gough as gk
from gough.plan import fix_feed, place, preflight
from gough.program.nc import NCProgram
from gough.report import style

PART = """G21 G90 G94 G61
N10 G1 X-200 F5000
N20 G1 X200 Y40 F40000
N30 G2 X200 Y-60 I0 J-50 F20000
N40 G1 X-200
M2
"""

machine = gk.load_machine("nist-octahedral")
program = NCProgram(text=PART, name="part.ngc")

found = preflight(machine, program)
print(found)
worst = found.findings[0]
assert not found.passed and worst.line == 3 and worst.kind == "speed"

fixed = fix_feed(machine, program)
print(f"\n{fixed.before.duration:.2f} s before, {fixed.after.duration:.2f} s with feeds that every strut can follow:")
for change in fixed.changes:
    print(f"-{change.was}", *(f"+{line}" for line in change.now), sep="\n")
assert fixed.after.passed and 0.999 < fixed.after.peaks[0].use <= 1
assert fixed.after.duration < 1.25 * fixed.before.duration

best = place(machine, fixed.program, poses_only=True)
print(f"\nstroke, cones and singularity leave {best.before:.3f} at home, at best {best.margin:.3f}: {best.table}")
assert best.margin > best.before

panels = style.new_panels(2, (8.0, 5.0))
told = {"As written": program, "With feeds that every strut can follow": fixed.program}
for ax, (title, one) in zip(panels, told.items(), strict=True):
    motion = one.plan(machine)
    rows = motion.sample(0, motion.count(1e-3), 1e-3)
    for strut in range(6):
        ax.plot(1e-3 * np.arange(len(rows.qd)), abs(rows.qd[:, strut]), label=f"strut {strut + 1}")
    ax.axhline(machine.limits.speed, color=style.INK, linestyle="--")
    style.label(ax, title, "", "speed [m/s]")
style.legend_above(panels[0])
panels[1].set_xlabel("time [s]")
style.save(panels[0], "results/14_before_metal_is_cut.png")
