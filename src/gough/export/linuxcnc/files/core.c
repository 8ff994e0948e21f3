/* @NAME@: see @NAME@_core.h.  Made by gough @VERSION@ from "@MACHINE@"; functions below are generated.
 * SPDX-License-Identifier: 0BSD
 */
#include "@NAME@_core.h"

#include <math.h>
#include <string.h>

extern const double @NAME@_theta_observer[];
extern const double @NAME@_state_home[@NAME@_STATE];

#define MARGINS @NM@

@FUNCTIONS@
static int finite_all(const double *x, int n)
{
    for (int i = 0; i < n; i++)
        if (!isfinite(x[i])) return 0;
    return 1;
}

static int inside(const double margins[MARGINS])
{
    for (int i = 0; i < MARGINS; i++)
        if (!(margins[i] >= 0)) return 0;
    return 1;
}

int @NAME@_inverse(const double pose[@NAME@_AXES], double joints[@NAME@_JOINTS])
{
    double q[@NAME@_JOINTS], z[@NAME@_Z], margins[MARGINS];
    if (!finite_all(pose, @NAME@_AXES)) return @NAME@_NOT_FINITE;
    inverse(@NAME@_theta, @NAME@_zero, pose, q, z, margins);
    if (!finite_all(q, @NAME@_JOINTS) || !finite_all(z, @NAME@_Z)) return @NAME@_UNREACHABLE;
    memcpy(joints, q, sizeof q);
    return inside(margins) ? @NAME@_OK : @NAME@_LIMITS;
}

int @NAME@_forward(const double joints[@NAME@_JOINTS], double z[@NAME@_Z], double pose[@NAME@_AXES], double *residual,
    int *iterations)
{
    double at[@NAME@_Z], x[@NAME@_AXES], margins[MARGINS], size;
    *residual = INFINITY;
    *iterations = 0;
    if (!finite_all(joints, @NAME@_JOINTS) || !finite_all(z, @NAME@_Z)) return @NAME@_NOT_FINITE;
    memcpy(at, z, sizeof at);
    while (*iterations < @NAME@_ITERATIONS) {
        newton(@NAME@_theta, at, joints, at, &size);
        ++*iterations;
        if (!(size > @SMALL@)) break; /* only the last digits moved */
    }
    landing(@NAME@_theta, @NAME@_zero, at, joints, x, residual, margins);
    if (!(*residual <= @RESIDUAL@) || !finite_all(x, @NAME@_AXES) || !finite_all(at, @NAME@_Z))
        return @NAME@_NO_CONVERGENCE;
    if (!(margins[MARGINS - 1] >= 0)) return @NAME@_OTHER_MODE;
    if (!inside(margins)) return @NAME@_LIMITS;
    memcpy(z, at, sizeof at);
    memcpy(pose, x, sizeof x);
    return @NAME@_OK;
}

int @NAME@_feedforward(const double q[@NAME@_JOINTS], const double qd[@NAME@_JOINTS], const double qdd[@NAME@_JOINTS],
    double z[@NAME@_Z], double force[@NAME@_JOINTS])
{
    double at[@NAME@_Z], u[@NAME@_JOINTS];
    if (!finite_all(q, @NAME@_JOINTS) || !finite_all(qd, @NAME@_JOINTS) || !finite_all(qdd, @NAME@_JOINTS))
        return @NAME@_NOT_FINITE;
    feedforward(@NAME@_theta, z, q, qd, qdd, u, at);
    if (!finite_all(u, @NAME@_JOINTS) || !finite_all(at, @NAME@_Z)) return @NAME@_NO_CONVERGENCE;
    memcpy(z, at, sizeof at);
    memcpy(force, u, sizeof u);
    return @NAME@_OK;
}

void @NAME@_observer_start(double state[@NAME@_STATE])
{
    memcpy(state, @NAME@_state_home, @NAME@_STATE * sizeof(double));
}

void @NAME@_observer_step(double state[@NAME@_STATE], const double joints[@NAME@_JOINTS],
    const double force[@NAME@_JOINTS], double good, double found[@NAME@_FOUND])
{
    observe(@NAME@_theta_observer, state, joints, force, &good, found, state);
}
