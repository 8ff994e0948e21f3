component @NAME@_following "Following error of the joints of @MACHINE@ against gough's law of supervision.";
// SPDX-License-Identifier: GPL-2.0-or-later
// joint.N.pos-fb was read before joint.N.pos-cmd was made: it is held against the command of the period before
pin in float command-#[@JOINTS@] "joint.N.pos-cmd, mm";
pin in float velocity-#[@JOINTS@] "joint.N.vel-cmd, mm/s";
pin in float position-#[@JOINTS@] "joint.N.pos-fb, mm";
pin in bit enable = TRUE;
pin in bit reset;
pin out float error-#[@JOINTS@] "mm";
pin out float allowed-#[@JOINTS@] "mm";
pin out bit tripped "latched until reset";
pin out s32 joint = -1 "which joint tripped first";
param rw float least = @MIN_FERROR@ "allowed at rest, mm";
param rw float slope = @SLOPE@ "allowed for each mm/s of the command, s";
option singleton yes;
variable double asked[@JOINTS@];
variable double speed[@JOINTS@];
variable int started;
function _ fp;
license "GPL";
author "gough @VERSION@";
include <math.h>;
;;

FUNCTION(_)
{
    if (reset) {
        tripped = 0;
        joint = -1;
    }
    for (int i = 0; i < @JOINTS@; i++) {
        const double grown = slope * fabs(started ? speed[i] : 0.0);
        allowed(i) = grown > least ? grown : least;
        error(i) = started ? asked[i] - position(i) : 0.0;
        asked[i] = command(i);
        speed[i] = velocity(i);
        if (enable && !tripped && !(fabs(error(i)) <= allowed(i))) { /* NaN trips too */
            tripped = 1;
            joint = i;
        }
    }
    started = 1;
}
