"""A machine in C: <name>.h and <name>.c with kinematics both ways, Jacobian, limits and inverse dynamics."""

from __future__ import annotations

import re

from ...machine import workspace
from ...machine.base import Machine
from . import printer, solver_text
from .functions import CONTRACT, constant_tape, guarded, head
from .header_text import HEADER, told
from .machine_functions import closed_form, dynamic_functions, home_sign, kinematic_functions, reach, unknowns
from .names import identifier

CLOSED = 1e-9  # m; machine/tripod.py refuses a tool tip whose joints miss their planes by more

INCLUDES = "#include <float.h>\n#include <math.h>\n#include <stddef.h>\n#include <string.h>\n"

FINITE = """
static int $N_finite(const double x[], int count)
{
    int k;
    for (k = 0; k < count; ++k)
        if (!(fabs(x[k]) <= DBL_MAX))
            return 0;
    return 1;
}
"""
_LARGEST = """
static double $N_largest(const double x[], int count)
{
    double most = 0.0;
    int k;
    for (k = 0; k < count; ++k)
        if (fabs(x[k]) > most)
            most = fabs(x[k]);
    return most;
}
"""
_INVERSE = """
int $N_inverse(const double pose[$D], double joints[$J])
{
    double q[$J], gap;
    if (!$N_finite(pose, $D))
        return $U_NOT_FINITE;
    $N_inverse_of(pose, q, &gap);
    if (!$N_finite(q, $J) || !(gap <= $CLOSED))
        return $U_UNREACHABLE;
    memcpy(joints, q, sizeof q);
    return $U_OK;
}
"""
_JACOBIAN = """
int $N_jacobian(const double pose[$D], double jacobian[$J * $D])
{
    double J[$J * $D], q[$J];
    const int status = $N_inverse(pose, q); /* a pose far out has a J of zeros */
    if (status != $U_OK)
        return status;
    $N_jacobian_of(pose, J);
    if (!$N_finite(J, $J * $D))
        return $U_UNREACHABLE;
    memcpy(jacobian, J, sizeof J);
    return $U_OK;
}
"""
_LIMITS = """
int $N_limits(const double pose[$D], double margins[$L])
{
    double z[$Z], q[$J], x[$D], found[$L], residual;
    int k, status = $N_inverse(pose, q);
    if (status != $U_OK)
        return status;
    $N_coordinates_of(pose, z);
    $N_landing_of(z, q, x, &residual, found);
    if (!$N_finite(found, $L))
        return $U_UNREACHABLE;
    memcpy(margins, found, sizeof found);
    if (found[$L - 1] + $LEAST <= 0.0)
        return $U_ASSEMBLY_MODE;
    if (found[$L - 1] < 0.0)
        return $U_SINGULAR;
    for (k = 0; k < $L; ++k)
        if (found[k] < 0.0)
            return $U_OUTSIDE_LIMITS;
    return $U_OK;
}
"""
_DYNAMICS = """
int $N_inverse_dynamics(const double pose[$D], const double rate[$D], const double acceleration[$D],
    const double wrench[6], double force[$J])
{
    double u[$J], determinant;
    if (!$N_finite(pose, $D) || !$N_finite(rate, $D) || !$N_finite(acceleration, $D) || !$N_finite(wrench, 6))
        return $U_NOT_FINITE;
    $N_inverse_dynamics_of(pose, rate, acceleration, wrench, u, &determinant);
    if (!(determinant >= $LEAST))
        return determinant < $LEAST ? $U_SINGULAR : $U_UNREACHABLE;
    if (!$N_finite(u, $J))
        return $U_SINGULAR;
    memcpy(force, u, sizeof u);
    return $U_OK;
}
"""


def machine_text(name: str, machine: Machine) -> tuple[str, str]:
    """C and header text of a machine.  InputError, ExperimentError as `functions.print_functions`."""
    identifier(name)
    machine = machine.rigid
    values = _values(name, machine)
    printed = {}
    for key, one in (kinematic_functions(machine) | dynamic_functions(machine)).items():
        tape = constant_tape(one, {"theta": machine.theta})
        printed[key] = printer.function(tape, f"{name}_{key}_of", one.name_in(), one.name_out())
    parts = [FINITE, printed["coordinates"], printed["inverse"], printed["jacobian"], printed["landing"], _INVERSE]
    if closed_form(machine):
        parts += [printed["direct"], solver_text.FORWARD_HEAD + solver_text.FORWARD_DIRECT + solver_text.FORWARD_TAIL]
    else:
        step = solver_text.STEP_TWIST if machine.pose_is_state else solver_text.STEP_PLAIN
        parts += [printed["system"], printed["moved"], _LARGEST, solver_text.SOLVE, step, solver_text.SEARCH]
        parts += [solver_text.FORWARD_HEAD + solver_text.FORWARD_SEARCH + solver_text.FORWARD_TAIL]
    parts += [_JACOBIAN, _LIMITS, printed["inverse_dynamics"], _DYNAMICS]
    what = f"{machine.name}: kinematics and inverse dynamics"
    body = _filled("\n".join(part.strip("\n") + "\n" for part in parts), values)
    c = head(what) + f'#include "{name}.h"\n\n{INCLUDES}\n{CONTRACT}\n' + _tables(name, machine) + body
    return c, head(what) + guarded(name, _filled(HEADER, values | told(machine)).strip("\n"))


def limit_names(machine: Machine) -> tuple[str, ...]:
    """What each margin says when it is negative; det J is the last."""
    return workspace.space_names(machine) + machine.limit_names


def _values(name: str, m: Machine) -> dict[str, str]:
    found = {
        "N": name, "U": name.upper(), "D": len(m.task), "J": m.joints_count, "Z": m.coordinate_count,
        "L": len(limit_names(m)), "LEAST": printer.number(m.limits.determinant), "CLOSED": printer.number(CLOSED),
        "MOST": 0, "TAKE": "",
    }  # fmt: skip
    if not closed_form(m):
        n = m.joints_count
        taken = "" if m.pose_is_state else f"    memcpy(z, joints, {n} * sizeof joints[0]);\n"
        found |= {"M": unknowns(m), "MOST": solver_text.MOST, "TAKE": taken}
        found |= {"SIGN": f"{home_sign(m):.1f}", "REACH": printer.number(reach(m))}
    return {key: str(value) for key, value in found.items()}


def _filled(text: str, values: dict[str, str]) -> str:
    for key in sorted(values, key=len, reverse=True):
        text = re.sub(rf"\${key}(?![A-Z])", lambda _, key=key: values[key], text)
    return text


def _tables(name: str, m: Machine) -> str:
    home = ", ".join(printer.number(v) for v in m.home)
    lines = ",\n".join(f'    "{one}"' for one in limit_names(m))
    return (
        f"const double {name}_home[{len(m.task)}] = {{{home}}};\n\n"
        f"const char *const {name}_limit_names[{len(limit_names(m))}] = {{\n{lines}}};\n\n"
    )
