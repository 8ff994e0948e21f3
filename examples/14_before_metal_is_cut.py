"""A program that the tool could follow and the struts cannot: told before metal is cut, and what to do about it."""

import gough as gk
from gough.plan import fix_feed, place, preflight
from gough.program.nc import NCProgram

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
