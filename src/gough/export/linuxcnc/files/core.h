/* @NAME@: kinematics and dynamics of the machine "@MACHINE@", made by gough @VERSION@.
 * SPDX-License-Identifier: 0BSD
 *
 * Plain C99: no allocation, every loop bounded, no LinuxCNC in it.  Units are SI: m, rad, s, N.
 * pose    @AXES@ of the tool tip in the program's frame: tip at (x, y, z), R = Rz(c) Ry(b) Rx(a)
 * joints  lengths of struts or places of carriages, m
 * z       the machine's own coordinates, which forward kinematics starts from
 */
#ifndef @NAME@_CORE_H
#define @NAME@_CORE_H

#define @NAME@_AXES @D@
#define @NAME@_JOINTS @N@
#define @NAME@_Z @NZ@
#define @NAME@_STATE @NS@ /* numbers that the observer remembers */
#define @NAME@_FOUND @NF@ /* what it finds: wrench (6) N, N m; what friction may hide of it (6); held (1) */
#define @NAME@_PERIOD @PERIOD@ /* s; the period that the observer is made for */
#define @NAME@_ITERATIONS @ITERATIONS@ /* most steps that forward kinematics takes */

enum @NAME@_status {
    @NAME@_OK = 0,
    @NAME@_NOT_FINITE = 1,     /* a number that was given is NaN or infinite */
    @NAME@_NO_CONVERGENCE = 2, /* no pose has these joints, or none near the start */
    @NAME@_OTHER_MODE = 3,     /* another assembly mode, or too near a singular pose */
    @NAME@_LIMITS = 4,         /* beyond strokes or cones */
    @NAME@_UNREACHABLE = 5     /* no joints have this pose */
};

extern const double @NAME@_theta[@NT@]; /* the data sheet's numbers: @NAME@_numbers.c */
extern const double @NAME@_zero[12];    /* where program zero stands in W: p (3), R by columns (9) */
extern const double @NAME@_z_home[@NAME@_Z];

/* Joints of a pose; they are left as they were unless the answer is OK or LIMITS. */
int @NAME@_inverse(const double pose[@NAME@_AXES], double joints[@NAME@_JOINTS]);

/* Pose of joints.  z: in, where the search starts; out, where it ended.  z and pose are left as they were unless the
 * answer is OK; residual (m) and iterations always say how the search ended. */
int @NAME@_forward(const double joints[@NAME@_JOINTS], double z[@NAME@_Z], double pose[@NAME@_AXES], double *residual,
    int *iterations);

/* Forces (N) of the joints that the motion q, q', q'' asks for, without friction of the joints.  z: as above, to be
 * kept between samples. */
int @NAME@_feedforward(const double q[@NAME@_JOINTS], const double qd[@NAME@_JOINTS], const double qdd[@NAME@_JOINTS],
    double z[@NAME@_Z], double force[@NAME@_JOINTS]);

/* The disturbance observer, one sample: joints as read (m), forces that the drives applied (N).  good: 0 where there is
 * no such sample. */
void @NAME@_observer_start(double state[@NAME@_STATE]);
void @NAME@_observer_step(double state[@NAME@_STATE], const double joints[@NAME@_JOINTS],
    const double force[@NAME@_JOINTS], double good, double found[@NAME@_FOUND]);

#endif
