/* @NAME@_kins: kinematics module for LinuxCNC, made by gough @VERSION@.  The maths is in @NAME@.c and @NAME@_core.c.
 * SPDX-License-Identifier: GPL-2.0-or-later
 *
 * This file uses LinuxCNC's headers and is therefore under LinuxCNC's licence.
 * Outside mm and degrees in the frame of programs, inside m and rad in that of the machine.  A pose outside the
 * machine's limits is refused, and so are joints that no pose inside them has: the last good pose stays.
 */
#include "rtapi.h"
#include "rtapi_app.h"
#include "hal.h"
#include "kinematics.h"

#include <math.h>

#include "@NAME@.h"
#include "@NAME@_core.h"

MODULE_AUTHOR("gough");
MODULE_DESCRIPTION("kinematics of @MACHINE@");
MODULE_LICENSE("GPL");

#define AXES @AXES@
#define JOINTS @JOINTS@
#define MARGINS ((int)(sizeof @NAME@_limit_names / sizeof @NAME@_limit_names[0]))
#define DEGREE (3.14159265358979323846 / 180.0)

static struct data {
    hal_s32_t *status;         /* of the last forward kinematics: enum @NAME@_status */
    hal_s32_t *inverse_status; /* of the last inverse kinematics */
    hal_s32_t *limit;          /* which limit refused it, an index of @NAME@_limit_names; -1: none */
    hal_s32_t *evaluations;    /* that forward kinematics took */
    hal_s32_t *most;           /* since a pose was first found */
    hal_u32_t *failures;       /* likewise */
    hal_float_t *residual;     /* mm */
    hal_float_t *pose[AXES];   /* what forward kinematics found, mm and degrees */
} *data;

static double at[AXES]; /* last good pose, in the machine's frame */
static int stood;       /* a pose was found: before homing there is none */

int kinematicsInverse(const EmcPose *world, double *joint, const KINEMATICS_INVERSE_FLAGS *iflags,
    KINEMATICS_FORWARD_FLAGS *fflags)
{
    const double w[6] = { world->tran.x, world->tran.y, world->tran.z, world->a, world->b, world->c };
    double pose[AXES], q[JOINTS], margins[MARGINS];
    int status;
    (void)iflags;
    (void)fflags;
    for (int i = 0; i < AXES; i++) pose[i] = i < 3 ? w[i] / 1000.0 : w[i] * DEGREE;
    @NAME@_core_placed(pose, pose);
    status = @NAME@_inverse(pose, q);
    *data->limit = -1;
    if (status == @UPPER@_OK) {
        status = @NAME@_limits(pose, margins);
        for (int i = MARGINS; status != @UPPER@_OK && i-- > 0;)
            if (margins[i] < 0) *data->limit = i;
    }
    *data->inverse_status = status;
    if (status != @UPPER@_OK) return -1;
    for (int i = 0; i < JOINTS; i++) joint[i] = q[i] * 1000.0;
    return 0;
}

int kinematicsForward(const double *joint, EmcPose *world, const KINEMATICS_FORWARD_FLAGS *fflags,
    KINEMATICS_INVERSE_FLAGS *iflags)
{
    double *w[6] = { &world->tran.x, &world->tran.y, &world->tran.z, &world->a, &world->b, &world->c };
    double q[JOINTS], pose[AXES];
    @NAME@_report report;
    int status;
    (void)fflags;
    (void)iflags;
    for (int i = 0; i < JOINTS; i++) q[i] = joint[i] / 1000.0;
    status = @NAME@_forward(q, at, &report);
    *data->status = status;
    *data->evaluations = report.evaluations;
    *data->residual = isfinite(report.residual) ? report.residual * 1000.0 : -1.0;
    if (status != @UPPER@_OK) {
        if (stood) ++*data->failures;
        return -1;
    }
    if (stood && report.evaluations > *data->most) *data->most = report.evaluations;
    stood = 1;
    @NAME@_core_seen(at, pose);
    for (int i = 0; i < 6; i++) {
        double value = i >= AXES ? 0.0 : i < 3 ? pose[i] * 1000.0 : pose[i] / DEGREE;
        if (i >= 3 && i < AXES) value += 360.0 * floor((*w[i] - value) / 360.0 + 0.5); /* as many turns as before */
        *w[i] = value;
        if (i < AXES) *data->pose[i] = value;
    }
    world->u = world->v = world->w = 0;
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
    bad |= hal_pin_s32_newf(HAL_OUT, &data->limit, id, "@NAME@.kins.limit");
    bad |= hal_pin_s32_newf(HAL_OUT, &data->evaluations, id, "@NAME@.kins.evaluations");
    bad |= hal_pin_s32_newf(HAL_OUT, &data->most, id, "@NAME@.kins.most-evaluations");
    bad |= hal_pin_u32_newf(HAL_OUT, &data->failures, id, "@NAME@.kins.failures");
    bad |= hal_pin_float_newf(HAL_OUT, &data->residual, id, "@NAME@.kins.residual");
    for (int i = 0; i < AXES; i++)
        bad |= hal_pin_float_newf(HAL_OUT, &data->pose[i], id, "@NAME@.kins.%c", letters[i]);
    if (bad) {
        hal_exit(id);
        return -1;
    }
    for (int i = 0; i < AXES; i++) at[i] = @NAME@_home[i];
    *data->limit = -1;
    hal_ready(id);
    return 0;
}

void rtapi_app_exit(void)
{
    hal_exit(id);
}
