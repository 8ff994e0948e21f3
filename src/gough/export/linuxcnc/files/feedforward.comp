component @NAME@_feedforward "Forces of the joints of @MACHINE@ for the commanded motion: inverse dynamics.";
// SPDX-License-Identifier: GPL-2.0-or-later
pin in float position-#[@JOINTS@] "joint.N.pos-cmd, mm";
pin in float velocity-#[@JOINTS@] "joint.N.vel-cmd, mm/s";
pin in float acceleration-#[@JOINTS@] "joint.N.acc-cmd, mm/s2";
pin in bit enable = TRUE;
pin out float force-#[@JOINTS@] "N, divided by gain; 0 while not enabled or without an answer";
pin out s32 status "enum @NAME@_status of @NAME@.h";
param rw float gain = 1.0 "N of a joint for each unit of the output";
option singleton yes;
option extra_setup yes;
variable double pose[@AXES@];
function _ fp;
license "GPL";
author "gough @VERSION@";
include <math.h>;
include "@NAME@.h";
include "@NAME@_core.h";
;;

FUNCTION(_)
{
    double q[@JOINTS@], qd[@JOINTS@], qdd[@JOINTS@], u[@JOINTS@];
    int sound;
    for (int i = 0; i < @JOINTS@; i++) {
        q[i] = position(i) / 1000.0;
        qd[i] = velocity(i) / 1000.0;
        qdd[i] = acceleration(i) / 1000.0;
    }
    status = @NAME@_forward(q, pose, 0);
    sound = enable && status == @UPPER@_OK;
    if (sound) @NAME@_core_feedforward(pose, qd, qdd, u);
    for (int i = 0; i < @JOINTS@; i++) sound = sound && isfinite(u[i]);
    for (int i = 0; i < @JOINTS@; i++) force(i) = sound ? u[i] / gain : 0.0;
}

EXTRA_SETUP()
{
    (void)prefix;
    (void)extra_arg;
    for (int i = 0; i < @AXES@; i++) pose[i] = @NAME@_home[i];
    return 0;
}
