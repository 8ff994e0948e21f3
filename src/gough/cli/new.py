"""gough new: files to start from, with every key explained.  `gough check` accepts them as they are."""

from __future__ import annotations

from pathlib import Path

from ..errors import ExperimentError, did_you_mean
from .end import Outcome, deliver
from .new_law import CONTROLLER

MACHINE = """\
# A hexapod of one's own: six struts between a base and a platform that carries the tool.
#
# Frames.  W is fixed in the base.  T is the tool: its origin is the tip, its third axis points from the tip to the
# spindle.  A pose is x y z a b c with R_WT = Rz(c) Ry(b) Rx(a).
# Quantities are texts with a unit, "150 kg"; arrays are { unit = "m", value = [...] }.
schema = "gough-machine-1"
name   = "my-hexapod"            # ASCII letters, digits and . _ -
kind   = "hexapod"
gravity = { unit = "m/s2", value = [0, 0, -9.81] }             # in W

[platform]                       # platform and spindle, one rigid body
mass    = "120 kg"
center  = { unit = "m", value = [0, 0, 0.30] }                 # centre of mass, in T
inertia = { unit = "kg m2", value = [[5, 0, 0], [0, 5, 0], [0, 0, 6]] }  # about it, axes of T

[joints]
base = { unit = "m", value = [    # strut 1 to 6 at the base, in W
    [-0.1455, 0.6847, 1.0],
    [0.1455, 0.6847, 1.0],
    [-0.5202, -0.4684, 1.0],
    [-0.6657, -0.2163, 1.0],
    [0.6657, -0.2163, 1.0],
    [0.5202, -0.4684, 1.0],
] }
platform = { unit = "m", value = [ # row by row the other ends of the same struts, in T
    [-0.1262, 0.1802, 0.25],
    [0.1262, 0.1802, 0.25],
    [-0.0930, -0.1994, 0.25],
    [-0.2192, 0.0192, 0.25],
    [0.2192, 0.0192, 0.25],
    [0.0930, -0.1994, 0.25],
] }
# base_axis = { unit = "1", value = [[1, 0, 0], ...] }          # axis of each universal joint that is fixed in the base
# cross = "0.02 kg m2"           # inertia of the cross of each base joint about that axis

# [joints.friction]              # of the joints at both ends of each strut; needs joints.base_axis
# coefficient     = 0.01         # torque: coefficient x radius x force in the joint
# platform_radius = "40 mm"      # of the balls
# base_radius     = "40 mm"      # of the bearings
# smoothing       = "1e-3 rad/s" # rate below which it fades

# [tool]                         # if joints and platform are measured in a frame P of the platform instead of T
# position = { unit = "m", value = [0, 0, -0.25] }             # tool tip, in P
# angles   = ["0 deg", "0 deg", "0 deg"]                       # a b c of R_PT

# [strut]                        # the guide, for friction that grows with the load
# sleeve = "0.60 m"              # mouth of the sleeve, from the base joint
# tube   = "0.65 m"              # end of the moving tube, from the platform joint

[strut.moving]                   # the part of each strut that hangs on the platform joint; leave out: no mass
mass       = "15 kg"
center     = "0.30 m"            # from the platform joint, along the strut
transverse = "0.6 kg m2"         # inertia across the strut, about its centre of mass
# axial    = "0.01 kg m2"        # about the strut's axis; needs joints.base_axis
# offset   = { unit = "m", value = [0, 0] }    # centre of mass off the axis: x, y of the strut, its y is n x base_axis
# inertia  = { unit = "kg m2", value = [[0.6, 0, 0], [0, 0.6, 0], [0, 0, 0.01]] }  # in place of transverse and axial

[strut.fixed]                    # the part that hangs on the base joint
mass       = "35 kg"
center     = "0.15 m"            # from the base joint
transverse = "0.8 kg m2"

[drive]
lead         = "20 mm"           # travel a turn of the screw
inertia      = "1.5e-3 kg m2"    # motor and screw
torque_limit = "30 N m"
encoder      = "0.5 um"          # resolution, at the joint
# noise      = "0.1 um"          # of the encoder, standard deviation
# delay      = 1                 # samples between a command and its force, 0 or 1

[friction]                       # of each strut: one value, or a list of six; leave out for none
kind    = "stribeck"             # or "lugre", with stiffness and damping of its bristles
coulomb = "150 N"
viscous = "300 N s/m"
# static    = "190 N"            # breakaway, and the speed at which it fades
# stribeck  = "2 mm/s"
# smoothing = "1 mm/s"           # speed below which friction fades, for "stribeck"
# stiffness = "1e8 N/m"          # for "lugre"
# damping   = "1e5 N s/m"        # for "lugre"
#     or, in proportion to the normal force between the tubes: "load_stribeck" and "load_lugre", where coulomb, static
#     and viscous ("0.5 s/m") are coefficients of that force, beside what remains without it:
# coulomb_offset = "20 N"
# viscous_offset = "90 N s/m"

[limits]
length    = ["0.70 m", "1.15 m"] # shortest and longest strut, joint to joint
cone      = "45 deg"             # greatest angle of a joint from its direction at home
# speed        = "30 m/min"      # greatest speed and acceleration of a strut, for programs with joint_limits = true
# acceleration = "10 m/s2"
# condition = 100                # greatest condition number of the Jacobian
# condition_warning = 50         # condition number from which a run warns
# determinant = 1e-3             # its least determinant, as a fraction of home's
workspace = { radius = "0.15 m", height = "0.2 m", tilt = "20 deg", c = "20 deg" }
#     or a box: size = ["0.3 m", "0.3 m"] instead of radius; beside home: middle = ["0 m", "0.1 m", "0 m"], from it

# [[compliance]]                 # joints that give way, one table each: in a [plant] with flexible = true
# joint     = "struts"           # or "strut 3"; drives, base joints, platform joints; docs/flexible.md
# stiffness = "400 N/um"         # of joints also three or six numbers; a full 6 x 6 is translation, rotation, coupling
# damping_ratio = 0.02           # at
# frequency     = "40 Hz"        # or damping = "2e4 N s/m", or beta = "0.1 ms": D = beta K
# center        = ["0 m", "0 m", "50 mm"]     # of joints: the spring's place from the joint

[feed]                           # what the tool is driven at when a program does not say
rapid                = "12 m/min"
acceleration         = "2 m/s2"
jerk                 = "50 m/s3"  # for programs with profile = "jerk_limited"
angular_rate         = "20 deg/s"
angular_acceleration = "200 deg/s2"

[home]
pose = ["0 mm", "0 mm", "0 mm", "0 deg", "0 deg", "0 deg"]     # x y z a b c at rest; zero of an NC program

[source]                         # where the numbers are from, for those who come later
"platform.mass" = "chosen: replace by the scale's reading"
"joints" = "chosen: replace by the drawing's numbers"
"""

EXPERIMENT = """\
# An experiment: one machine, one program, one or more controllers side by side.
#     gough check FILE      finds every mistake
#     gough run FILE        writes logs, plots and the report to results/
schema = "gough-experiment-1"

[machine]                        # what the controllers believe
use = "nist-octahedral"          # a name of `gough machines`, or a path such as "my-hexapod.toml"
# "platform.mass" = "310 kg"     # any key of the sheet, changed

[plant]                          # what is true and nobody told the controllers; leave out if all is as believed
"friction.coulomb" = "1.2 x"     # times the machine's own, or a quantity such as "360 N"
# "joints.friction" = "none"     # the machine has it, this one has not
# friction_drift = "2 %/min"     # so much of its first size all friction grows; below 0 it falls
# flexible = true                # the joints of the sheet's [[compliance]] give way,
# stiffness = 0.8                # so many times as stiff as it says;
# measured = "joint"             # encoders behind the springs, as direct scales; else at the "motor"
# payload = "20 kg"              # a point mass that the tool carries, at
# payload_center = { unit = "m", value = [0, 0, 0.3] }         # in T
# offset  = { unit = "um", value = [0, 0, 10] }              # of the tool from its first place at the start, in W
# wrench  = ["0 N", "0 N", "-200 N", "0 N m", "0 N m", "0 N m"]  # steady, on the tool tip, in W
# faults  = [{ kind = "glitch", joint = 3, start = "2 s", duration = "2 ms", size = "10 um" }]  # of encoders; also
#                                                      "stuck" and "dropout", which have no size
# [plant.cutting]                # an end mill along a wall: docs/cutting.md
# coefficients  = "A5052"        # or Al6082-T6, Al6061-T6, Al7075-T6, or a table of the six numbers
# spindle_speed = "12000 rpm"
# tool = { diameter = "12 mm", teeth = 2, helix = "30 deg" }
# wall = { axial_depth = "18 mm", places = ["40 mm", "120 mm"], radial = ["0.5 mm"] }   # along the path

[program]                        # an NC program ...
# file   = "part.ngc"            # relative to this file; or the name of a shipped piece, "cone-frustum"
# parameters = "linuxcnc.var"    # numbered parameters of the NC program: zeros of its coordinate systems
# subroutines = "subroutines"    # folder of the files that it calls, else its own
kind   = "circle"                # ... or a curve or test piece, see docs/programs.md
radius = "50 mm"
feed   = "3 m/min"
# corner    = "blend"            # rounded within the tolerance; or "stop", "constant"; else what the NC program says
# tolerance = "20 um"
# spline    = true               # short lines run as one smooth curve
# profile   = "jerk_limited"     # or "trapezoid"
# jerk      = "50 m/s3"          # else the machine's
# joint_limits = true            # slow down where a strut would exceed the machine's limits
# origin = ["0 mm", "0 mm", "0 mm", "0 deg", "0 deg", "0 deg"]  # pose of program zero in W; else the machine's home

# [tools]                        # lengths of an NC program's tools; or file = "tool.tbl", LinuxCNC's
# 1 = { length = "80 mm", diameter = "10 mm" }

[[controller]]
kind      = "pid"                # cascade of each joint, as machine tools ship it
bandwidth = "10 Hz"              # or poles = ["20 1/s", "80 1/s", "200 1/s"] of a joint, not too near one another

[[controller]]
kind      = "computed_torque"    # inverse dynamics and PID on the tool's pose
bandwidth = "10 Hz"              # or poles; or error_gains = ["400 1/s", "5e4 1/s2", "2e6 1/s3"]

# [[controller]]
# kind    = "robust_adaptive"    # learns masses, drives and friction; or "fuzzy_friction", friction without a model
# slope   = "100 1/s"            # decay of the error on the sliding surface
# damping = "200 1/s"            # how fast the surface is reached

[observer]                       # beside each controller: the force on the tool out of the drives' forces, for the log
kind        = "disturbance"      # leave the table out for none
bandwidth   = "20 Hz"            # of the low pass that the force comes through
# form      = "momentum"         # or "static", which reads inertia as force
# rest      = "1 mm/s"           # joint speed below which the direction of friction fades
# base_torque = "8 N m"          # friction torque in each base joint of a hexapod: one value, or a list of six
# greatest  = "50 kN"            # a change of force from sample to sample beyond it is none; else what the drives can

# [compensation]                 # the tool leans against the cut by the observer's force; it needs [observer]
# height    = "18 mm"            # of the wall, where the tool stays in its place
# air       = ["5 mm", "30 mm"]  # way along the path through air, on which the estimate is tared
# bandwidth = "8 Hz"             # of the tilt
# most      = "0.5 deg"          # greatest tilt

[run]
period    = "1 ms"               # of the controllers
seed      = 0                    # of the encoder's noise
# substeps  = 4                  # steps of the plant a period; else chosen from its fastest pole
# log_every = 1                  # rows of the log: one of so many samples; metrics use all
# signals   = ["x", "x_r", "contour_error", "line"]            # variables of the log; else all
# ferror     = "1 mm"            # following error that ends the run; with min_ferror at the joints' greatest speed
# min_ferror = "0.2 mm"          # the same at rest; needs the machine's limits.speed
# encoder_check = "1 kN"         # flag encoders that read what takes more unknown force on a joint: friction, cutting
# stop_ramp  = "2 m/s2"          # at a flag or following error the tool brakes along its path before the run ends

# [sweep]                        # for `gough sweep FILE`: many runs, each with other values; docs/sweeps.md
# runs   = 100                   # draws of what is varied by a distribution
# method = "random"              # or "sobol", drawn more evenly
# metric = "contour_error.max"   # what the summary is about
# [sweep.vary]
# "plant.payload" = "uniform(0, 40) kg"          # or normal, lognormal, loguniform, triangular, integers, choice
# "plant.friction.coulomb, plant.friction.static" = "normal(1.0, 0.2) x"     # one number for both
# "controller.bandwidth" = ["8 Hz", "12 Hz"]     # a list: every draw at each of its values
"""

MAP = """\
# The columns of a recorded log, for gough monitor LOG --map THIS and gough identify LOG --map THIS.
schema = "gough-log-map-1"
# machine = "okuma-pm600"        # whose log it is; another one is told

[time]
column = "t"                     # leave out: every row is a sample
unit   = "s"                     # or ms, us; "samples" for a counter
period = "1 ms"                  # from sample to sample
# jitter = "0.25 ms"             # how far a row may lie from its sample's time; else a quarter of the period

[joints]                         # what the encoders read, in the order of the machine's joints
columns = ["q1", "q2", "q3", "q4", "q5", "q6"]     # an entry of an array is "q.1" (.mat, .nc)
unit    = "mm"
# sign    = [1, 1, 1, 1, 1, 1]   # -1 where it counts the other way
# offset  = "0 mm"               # added: one, or { unit = "mm", value = [...] }

[forces]                         # what the drives gave
columns = ["i1", "i2", "i3", "i4", "i5", "i6"]
unit    = "A"                    # a force (N) or a torque (N m) needs no factor
factor  = "0.6 N m"              # what 1 A makes: the motor's torque constant; a torque becomes a force by the lead
# sign  = [1, 1, 1, 1, 1, 1]     # 1: a positive number lengthens the strut
# clip  = 40.0                   # in A: at or beyond it the record is cut off, and says nothing of the force
# acts  = "after"                # a row's force acts after its readings, or "before"

# [text]                         # of CSV
# delimiter = ","                # or ";", "|", "\\t", " "
# decimal   = "."
# header    = 1                  # lines up to and with the names; 0: columns go by their numbers from 1
# skip      = ["#"]              # lines that begin so are no samples

# [gaps]                         # what may be missing; it is told, and held over
# longest = "5 ms"               # cells that are empty or no number; 0: none
# most    = "1 %"                # of all samples

# [identify]                     # what gough identify takes where the command says nothing
# cutoff   = "20 Hz"
# friction = ["coulomb", "viscous"]     # also "offset"; "base_torque" of a hexapod
"""

TEMPLATES = {"machine": MACHINE, "controller": CONTROLLER, "experiment": EXPERIMENT, "map": MAP}


def write_template(what: str, out: Path | None, force: bool, outcome: Outcome) -> None:
    """Write a template to a file, or to stdout."""
    if what not in TEMPLATES:
        raise ExperimentError(
            "nothing of this name to start from", value=ascii(what), cure=did_you_mean(what, TEMPLATES)
        )
    if deliver(TEMPLATES[what], out, force, outcome):
        after = "python" if what == "controller" else "gough check"
        outcome.say(f"{out} is written; next: {after} {out}")
