/* @NAME@: the numbers of the data sheet "@MACHINE@", in the order of gough's theta, and of the observer that believes it.
 * SPDX-License-Identifier: 0BSD
 *
 * They are a file of their own so that the compiler computes nothing of them beforehand: results stay those of gough.
 */
#include "@NAME@_core.h"

#include <math.h>

extern const double @NAME@_theta_observer[];
extern const double @NAME@_state_home[@NAME@_STATE];

const double @NAME@_theta[@NT@] = {
@THETA@
};

const double @NAME@_zero[12] = {
@ZERO@
};

const double @NAME@_z_home[@NAME@_Z] = {
@ZHOME@
};

const double @NAME@_theta_observer[] = {
@THETAOBS@
};

const double @NAME@_state_home[@NAME@_STATE] = {
@STATEHOME@
};
