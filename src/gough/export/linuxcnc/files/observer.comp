component @NAME@_observer "Wrench on the tool of @MACHINE@, out of joint positions and drive forces.";
// SPDX-License-Identifier: GPL-2.0-or-later
pin in float position-#[@JOINTS@] "joints as the encoders read them, mm";
pin in float drive-#[@JOINTS@] "what the drives apply: current, torque or force, times gain a force";
pin in bit good = TRUE "FALSE where there is no such sample";
pin out float wrench-#[6] "on the tool at its tip, N and N m in the machine's frame W";
pin out float hidden-#[6] "what friction may hide of it";
pin out bit held "the wrench is that of an earlier sample";
pin out s32 status "enum @NAME@_wrench_status of @NAME@_wrench.h";
pin out bit wrong-period "the thread's period is not that of the observer";
param rw float gain = 1.0 "N of a joint for each unit of its drive";
option singleton yes;
option extra_setup yes;
variable @NAME@_wrench_state state;
function _ fp;
license "GPL";
author "gough @VERSION@";
include <math.h>;
include "@NAME@_wrench.h";
;;

FUNCTION(_)
{
    double q[@JOINTS@], u[@JOINTS@], found[13];
    wrong_period = fabs(fperiod - @PERIOD@) > 0.01 * @PERIOD@;
    for (int i = 0; i < @JOINTS@; i++) {
        q[i] = position(i) / 1000.0;
        u[i] = drive(i) * gain;
    }
    status = @NAME@_wrench_step(&state, q, u, good, found);
    if (status == @UPPER@_WRENCH_NO_NUMBER) { /* what was found stays */
        held = 1;
        return;
    }
    for (int i = 0; i < 6; i++) {
        wrench(i) = found[@UPPER@_WRENCH_FOUND_WRENCH_HAT + i];
        hidden(i) = found[@UPPER@_WRENCH_FOUND_HIDDEN + i];
    }
    held = found[@UPPER@_WRENCH_FOUND_HELD] != 0;
}

EXTRA_SETUP()
{
    (void)prefix;
    (void)extra_arg;
    @NAME@_wrench_start(&state);
    return 0;
}
