component @NAME@_feedforward "Forces of the joints of @MACHINE@ for the commanded motion: inverse dynamics.";
// SPDX-License-Identifier: GPL-2.0-or-later
pin in float position-#[@N@] "joint.N.pos-cmd, mm";
pin in float velocity-#[@N@] "joint.N.vel-cmd, mm/s";
pin in float acceleration-#[@N@] "joint.N.acc-cmd, mm/s2";
pin in bit enable = TRUE;
pin out float force-#[@N@] "N, divided by gain; 0 while not enabled or without an answer";
pin out s32 status "enum @NAME@_status";
param rw float gain = 1.0 "N of a joint for each unit of the output";
option singleton yes;
option extra_setup yes;
variable double z[@NZ@];
function _ fp;
license "GPL";
author "gough @VERSION@";
include <math.h>;
include "@NAME@_core.h";
;;

FUNCTION(_)
{
    double q[@NAME@_JOINTS], qd[@NAME@_JOINTS], qdd[@NAME@_JOINTS], u[@NAME@_JOINTS], pose[@NAME@_AXES], residual;
    int iterations;
    for (int i = 0; i < @NAME@_JOINTS; i++) {
        q[i] = position(i) / 1000.0;
        qd[i] = velocity(i) / 1000.0;
        qdd[i] = acceleration(i) / 1000.0;
    }
    /* the search of forward kinematics is bounded and checked; the last digits come from the step below */
    status = @NAME@_forward(q, z, pose, &residual, &iterations);
    if (status == @NAME@_OK) status = @NAME@_feedforward(q, qd, qdd, z, u);
    for (int i = 0; i < @NAME@_JOINTS; i++) force(i) = enable && status == @NAME@_OK ? u[i] / gain : 0.0;
}

EXTRA_SETUP()
{
    (void)prefix;
    (void)extra_arg;
    for (int i = 0; i < @NAME@_Z; i++) z[i] = @NAME@_z_home[i];
    return 0;
}
