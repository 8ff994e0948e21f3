/* @NAME@_kins: kinematics module for LinuxCNC, made by gough @VERSION@.  The maths is in @NAME@_core.c.
 * SPDX-License-Identifier: GPL-2.0-or-later
 *
 * This file uses LinuxCNC's headers and is therefore under LinuxCNC's licence.
 * Outside mm and degrees, inside m and rad.  A pose that the machine cannot take is refused, and so are joints that no
 * pose inside the limits has: the last good pose stays.
 */
#include "rtapi.h"
#include "rtapi_app.h"
#include "hal.h"
#include "kinematics.h"

#include <math.h>

#include "@NAME@_core.h"

MODULE_AUTHOR("gough");
MODULE_DESCRIPTION("kinematics of @MACHINE@");
MODULE_LICENSE("GPL");

#define PI 3.14159265358979323846

static struct data {
    hal_s32_t *status;         /* of the last forward kinematics: enum @NAME@_status */
    hal_s32_t *inverse_status; /* of the last inverse kinematics */
    hal_s32_t *iterations;
    hal_s32_t *most_iterations;
    hal_u32_t *failures; /* of forward kinematics, since LinuxCNC first stood at home */
    hal_float_t *residual; /* mm */
    hal_float_t *pose[@NAME@_AXES]; /* what forward kinematics found, mm and degrees */
} *data;

static double at[@NAME@_Z];
static int stood; /* a pose was found: before homing there is none */

static void outside(const double pose[@NAME@_AXES], EmcPose *world)
{
    double *w[9] = { &world->tran.x, &world->tran.y, &world->tran.z, &world->a, &world->b, &world->c, 0, 0, 0 };
    for (int i = 0; i < @NAME@_AXES; i++) {
        double value = i < 3 ? pose[i] * 1000.0 : pose[i] * (180.0 / PI);
        if (i >= 3) /* as many turns as before */
            value += 360.0 * floor((*w[i] - value) / 360.0 + 0.5);
        *w[i] = value;
    }
    for (int i = @NAME@_AXES; i < 6; i++) *w[i] = 0;
    world->u = world->v = world->w = 0;
}

int kinematicsInverse(const EmcPose *world, double *joint, const KINEMATICS_INVERSE_FLAGS *iflags,
    KINEMATICS_FORWARD_FLAGS *fflags)
{
    const double w[6] = { world->tran.x, world->tran.y, world->tran.z, world->a, world->b, world->c };
    double pose[@NAME@_AXES], q[@NAME@_JOINTS];
    int status;
    (void)iflags;
    (void)fflags;
    for (int i = 0; i < @NAME@_AXES; i++) pose[i] = i < 3 ? w[i] / 1000.0 : w[i] * (PI / 180.0);
    status = @NAME@_inverse(pose, q);
    *data->inverse_status = status;
    if (status != @NAME@_OK) return -1;
    for (int i = 0; i < @NAME@_JOINTS; i++) joint[i] = q[i] * 1000.0;
    return 0;
}

int kinematicsForward(const double *joint, EmcPose *world, const KINEMATICS_FORWARD_FLAGS *fflags,
    KINEMATICS_INVERSE_FLAGS *iflags)
{
    double q[@NAME@_JOINTS], pose[@NAME@_AXES], residual;
    int iterations, status;
    (void)fflags;
    (void)iflags;
    for (int i = 0; i < @NAME@_JOINTS; i++) q[i] = joint[i] / 1000.0;
    status = @NAME@_forward(q, at, pose, &residual, &iterations);
    *data->status = status;
    *data->iterations = iterations;
    *data->residual = isfinite(residual) ? residual * 1000.0 : -1.0;
    if (status != @NAME@_OK) {
        if (stood) ++*data->failures;
        return -1;
    }
    if (stood && iterations > *data->most_iterations) *data->most_iterations = iterations;
    stood = 1;
    outside(pose, world);
    *data->pose[0] = world->tran.x;
    *data->pose[1] = world->tran.y;
    *data->pose[2] = world->tran.z;
#if @NAME@_AXES > 3
    *data->pose[3] = world->a;
    *data->pose[4] = world->b;
    *data->pose[5] = world->c;
#endif
    return 0;
}

KINEMATICS_TYPE kinematicsType(void)
{
    return KINEMATICS_BOTH;
}

KINS_NOT_SWITCHABLE
EXPORT_SYMBOL(kinematicsType);
EXPORT_SYMBOL(kinematicsForward);
EXPORT_SYMBOL(kinematicsInverse);

static int id;

int rtapi_app_main(void)
{
    static const char letters[] = "xyzabc";
    int bad = 0;
    id = hal_init("@NAME@_kins");
    if (id < 0) return id;
    data = hal_malloc(sizeof *data);
    if (!data) {
        hal_exit(id);
        return -1;
    }
    bad |= hal_pin_s32_newf(HAL_OUT, &data->status, id, "@NAME@.kins.status");
    bad |= hal_pin_s32_newf(HAL_OUT, &data->inverse_status, id, "@NAME@.kins.inverse-status");
    bad |= hal_pin_s32_newf(HAL_OUT, &data->iterations, id, "@NAME@.kins.iterations");
    bad |= hal_pin_s32_newf(HAL_OUT, &data->most_iterations, id, "@NAME@.kins.most-iterations");
    bad |= hal_pin_u32_newf(HAL_OUT, &data->failures, id, "@NAME@.kins.failures");
    bad |= hal_pin_float_newf(HAL_OUT, &data->residual, id, "@NAME@.kins.residual");
    for (int i = 0; i < @NAME@_AXES; i++)
        bad |= hal_pin_float_newf(HAL_OUT, &data->pose[i], id, "@NAME@.kins.%c", letters[i]);
    if (bad) {
        hal_exit(id);
        return -1;
    }
    for (int i = 0; i < @NAME@_Z; i++) at[i] = @NAME@_z_home[i];
    hal_ready(id);
    return 0;
}

void rtapi_app_exit(void)
{
    hal_exit(id);
}
