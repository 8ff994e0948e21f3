"""The header of a machine in C: what each argument is, its unit and its frame, and what each status says."""

from __future__ import annotations

from ...machine.base import Machine

HEADER = """
/* What every function returns.  Unless it is $U_OK nothing is written through the other arguments, but what is said. */
enum $N_status {
    $U_OK = 0,
    $U_NOT_FINITE = 1,     /* an argument has NaN or infinity in it */
    $U_UNREACHABLE = 2,    /* no joint coordinates have this pose, or no pose these joint coordinates */
    $U_NO_CONVERGENCE = 3, /* no pose was found in $N_MOST_EVALUATIONS evaluations */
    $U_ASSEMBLY_MODE = 4,  /* the search ran into a singularity: beyond it is another assembly mode */
    $U_OUTSIDE_LIMITS = 5, /* a pose was found, and it is outside limits or workspace */
    $U_SINGULAR = 6        /* det J is below $LEAST of home's: too near to a singularity */
};

/* A pose: $POSE.
   Frames: W is fixed in the base, T at the tool tip.$FRAMES
   Joint coordinates: $JOINTS. */

extern const double $N_home[$D];
extern const char *const $N_limit_names[$L]; /* what each margin says when it is negative; the last is det J */

/* Joint coordinates of a pose: one answer or none; limits are not looked at. */
int $N_inverse(const double pose[$D], double joints[$J]);

/* What $N_forward found out on its way; fields that it did not come to are 0, limit is -1. */
typedef struct {
    double residual;    /* m, greatest difference between joints asked for and those of the pose found */
    double determinant; /* det J at the pose found, as a fraction of home's */
    double margin;      /* the smallest margin: outside where it is negative */
    int limit;          /* whose it is: an index of $N_limit_names */
    int evaluations;    /* of the equations, $MOST at most for each of two starts */
} $N_report;

/* Pose of joint coordinates, sought from `pose`: in, the last good pose; out, the pose.
   On any status but $U_OK `pose` stays the last good one (home, if it was not finite).  An answer has
   a residual below 1e-10 m, is within limits and workspace, and det J is above $LEAST of home's; the search does
   not cross a singularity.  Bounded: at most $TWICE evaluations.  `report` may be NULL. */
#define $N_MOST_EVALUATIONS $MOST
int $N_forward(const double joints[$J], double pose[$D], $N_report *report);

/* J with q' = J $RATE, by rows: entry i * $D + k is joint i. */
int $N_jacobian(const double pose[$D], double jacobian[$J * $D]);

/* How far a pose is inside all limits: >= 0 inside.  Written also when the status is OUTSIDE_LIMITS, SINGULAR or
   ASSEMBLY_MODE. */
int $N_limits(const double pose[$D], double margins[$L]);

/* Joint forces ($FORCE) of a motion, without friction.  rate and acceleration: $RATES.
   wrench: [f; m] N, N m on the tool at its tip, in W. */
int $N_inverse_dynamics(const double pose[$D], const double rate[$D], const double acceleration[$D],
    const double wrench[6], double force[$J]);
"""

_FULL = "x y z of the tool tip in W, m, and a b c, rad"
_TWIST = "[v; w], the velocity of the tool tip, m/s, and the angular velocity, rad/s, both in W"


def told(m: Machine) -> dict[str, str]:
    """What HEADER says of a kind of machine."""
    from . import solver_text

    six = m.pose_is_state
    names = ", ".join(m.joint_names)
    return {
        "POSE": _FULL if six else f"{' '.join(name for name, _ in m.task)} of the tool tip in W, m",
        "FRAMES": "  R_WT = Rz(c) Ry(b) Rx(a)." if six else "",
        "JOINTS": f"m, {names}",
        "RATE": _TWIST if six else "the rate of the pose, m/s",
        "RATES": f"{_TWIST}, and its rate" if six else "m/s and m/s2",
        "FORCE": "N",
        "TWICE": str(2 * solver_text.MOST),
    }  # fmt: skip
