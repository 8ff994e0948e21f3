"""C text of the safe forward kinematics: Newton's method on SO(3) with a step that is held back.

    K(z) d = r(z),   z <- z + s d,   s = min(1, reach / |d_v|, 0.3 / |d_w|), halved until                           (1)
    |r| has become smaller and det K has the sign that it has at home                                             (2)

machine/forward.py takes the same step but asks (2) of the answer only; here every step keeps it, so that the search
cannot leave the assembly mode through a singularity, nor run away.  It ends when the step to be taken is below 1e-7:
Newton squares it, and the residual of the answer is looked at anyhow.  At most MOST times K is worked out.
"""

from __future__ import annotations

MOST = 60  # evaluations of (K, r); a servo cycle takes two or three

SOLVE = """
/* d with K d = r, K by columns, by elimination with partial pivoting; K and r are lost.  det K, 0 where singular. */
static double $N_solve(double K[$M * $M], double r[$M])
{
    double det = 1.0;
    int i, j, k;
    for (k = 0; k < $M; ++k) {
        int best = k;
        for (i = k + 1; i < $M; ++i)
            if (fabs(K[i + $M * k]) > fabs(K[best + $M * k]))
                best = i;
        if (best != k) {
            double kept = r[k];
            r[k] = r[best];
            r[best] = kept;
            for (j = k; j < $M; ++j) {
                kept = K[k + $M * j];
                K[k + $M * j] = K[best + $M * j];
                K[best + $M * j] = kept;
            }
            det = -det;
        }
        det *= K[k + $M * k];
        if (!(fabs(det) > 0.0))
            return 0.0; /* NaN too */
        for (i = k + 1; i < $M; ++i) {
            const double share = K[i + $M * k] / K[k + $M * k];
            for (j = k + 1; j < $M; ++j)
                K[i + $M * j] -= share * K[k + $M * j];
            r[i] -= share * r[k];
        }
    }
    for (i = $M - 1; i >= 0; --i) {
        for (j = i + 1; j < $M; ++j)
            r[i] -= K[i + $M * j] * r[j];
        r[i] /= K[i + $M * i];
    }
    return det;
}
"""

SEARCH = """
/* z of joints, sought from z.  At most $N_MOST_EVALUATIONS evaluations. */
static int $N_search(const double joints[$J], double z[$Z], int *evaluations)
{
    double at[$Z], d[$M], K[$M * $M], r[$M], size = 0.0, share = 1.0;
    int k, turned = 0;
    memcpy(at, z, sizeof at);
    memset(d, 0, sizeof d);
    for (*evaluations = 1; *evaluations <= $N_MOST_EVALUATIONS; ++*evaluations) {
        double now, det, most, limit;
        $N_system_of(at, joints, K, r);
        now = $N_largest(r, $M);
        det = $SIGN * $N_solve(K, r);
        if (!(det > 0.0) || !$N_finite(r, $M) || (*evaluations > 1 && !(now < size || now < 1e-12))) {
            if (*evaluations == 1)
                return $U_ASSEMBLY_MODE; /* the start is not in the assembly mode of home */
            turned = !(det > 0.0);
            share *= 0.5;
            if (share < 1e-6)
                break;
        } else {
            memcpy(z, at, sizeof at);
            memcpy(d, r, sizeof d);
            size = now;
            turned = 0;
            most = $N_step_size(d);
            share = 1.0;
            if (most > 1.0)
                for (k = 0; k < $M; ++k)
                    d[k] /= most;
            limit = $N_largest(d, $M);
            if (limit < 1e-7) { /* the next step is below 1e-13: the last digits */
                $N_moved_of(z, d, at);
                memcpy(z, at, sizeof at);
                return $U_OK;
            }
        }
        for (k = 0; k < $M; ++k)
            r[k] = share * d[k];
        $N_moved_of(z, r, at);
    }
    return turned ? $U_ASSEMBLY_MODE : $U_NO_CONVERGENCE;
}
"""

STEP_TWIST = """
/* How many times too long a twist increment is: beyond $REACH m or 0.3 rad. */
static double $N_step_size(const double d[$M])
{
    const double v = sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]) / $REACH;
    const double w = sqrt(d[3] * d[3] + d[4] * d[4] + d[5] * d[5]) / 0.3;
    return v > w ? v : w;
}
"""

STEP_PLAIN = """
/* How many times too long a step of the dependent coordinates is: beyond 0.3 rad. */
static double $N_step_size(const double d[$M])
{
    return $N_largest(d, $M) / 0.3;
}
"""

FORWARD_HEAD = """
int $N_forward(const double joints[$J], double pose[$D], $N_report *report)
{
    double z[$Z], x[$D], margins[$L];
    $N_report own;
    int k, status, worst = 0;
    if (report == NULL)
        report = &own;
    memset(report, 0, sizeof *report);
    report->limit = -1;
    if (!$N_finite(pose, $D)) { /* no last good pose */
        memcpy(pose, $N_home, sizeof $N_home);
        return $U_NOT_FINITE;
    }
    if (!$N_finite(joints, $J))
        return $U_NOT_FINITE;
"""

FORWARD_SEARCH = """    $N_coordinates_of(pose, z);
    if (!$N_finite(z, $Z))
        $N_coordinates_of($N_home, z);
$TAKE    status = $N_search(joints, z, &report->evaluations);
    if (status == $U_ASSEMBLY_MODE && report->evaluations == 1) { /* no good start: from home */
        $N_coordinates_of($N_home, z);
$TAKE        status = $N_search(joints, z, &report->evaluations);
    }
    if (status != $U_OK)
        return status;
"""

FORWARD_DIRECT = """    $N_direct_of(joints, z);
    if (!$N_finite(z, $Z))
        return $U_UNREACHABLE;
    status = $U_OK;
"""

FORWARD_TAIL = """    $N_landing_of(z, joints, x, &report->residual, margins);
    if (!$N_finite(x, $D) || !$N_finite(margins, $L) || !(report->residual <= 1e-10))
        return $U_NO_CONVERGENCE;
    for (k = 1; k < $L; ++k)
        if (margins[k] < margins[worst])
            worst = k;
    report->limit = worst;
    report->margin = margins[worst];
    report->determinant = margins[$L - 1] + $LEAST;
    if (!(report->determinant > 0.0))
        return $U_ASSEMBLY_MODE;
    if (margins[$L - 1] < 0.0) {
        report->limit = $L - 1;
        report->margin = margins[$L - 1];
        return $U_SINGULAR;
    }
    if (report->margin < 0.0)
        return $U_OUTSIDE_LIMITS;
    memcpy(pose, x, sizeof x);
    return status;
}
"""
