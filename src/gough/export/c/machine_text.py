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
from .theta_text import check_way, declaration, table, threaded

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


def machine_text(name: str, machine: Machine, theta: str = "constant") -> tuple[str, str]:
    """C and header text of a machine, its numbers put in or an "argument" (theta_text.py).

    InputError, ExperimentError as `functions.print_functions`.
    """
    identifier(name)
    argument, machine = check_way(theta), machine.rigid
    values = _values(name, machine)
    printed = {}
    for key, one in (kinematic_functions(machine) | dynamic_functions(machine)).items():
        tape = constant_tape(one, {} if argument else {"theta": machine.theta})
        printed[key] = printer.function(tape, f"{name}_{key}_of", one.name_in(), one.name_out())
    body = {key: _filled(text.strip("\n") + "\n", values) for key, text in _texts(machine).items()}
    header, tables = _filled(HEADER, values | told(machine)).strip("\n"), _tables(name, machine)
    if argument:
        count = len(machine.theta)
        least = f"theta[{machine.names.index('limits.determinant')}]"
        body = {key: threaded(text.replace(values["LEAST"], least), name, count) for key, text in body.items()}
        header = declaration(name, machine) + threaded(header, name, count)
        tables += table(name, machine)
    order = [printed[key] if key in printed else body[key] for key in _order(machine)]
    what = f"{machine.name}: kinematics and inverse dynamics"
    c = head(what) + f'#include "{name}.h"\n\n{INCLUDES}\n{CONTRACT}\n' + tables + "\n".join(order)
    return c, head(what) + guarded(name, header)


def _texts(m: Machine) -> dict[str, str]:
    """The C of what is no printed function, by a name that no printed one has."""
    search = solver_text.FORWARD_DIRECT if closed_form(m) else solver_text.FORWARD_SEARCH
    return {
        "finite": FINITE,
        "largest": _LARGEST,
        "solve": solver_text.SOLVE,
        "step size": solver_text.STEP_TWIST if m.pose_is_state else solver_text.STEP_PLAIN,
        "search": solver_text.SEARCH,
        "inverse checked": _INVERSE,
        "forward": solver_text.FORWARD_HEAD + search + solver_text.FORWARD_TAIL,
        "jacobian checked": _JACOBIAN,
        "limits": _LIMITS,
        "dynamics checked": _DYNAMICS,
    }


def _order(m: Machine) -> list[str]:
    """What stands in the file, each behind what it calls."""
    found = ["direct"] if closed_form(m) else ["system", "moved", "largest", "solve", "step size", "search"]
    return [
        *("finite", "coordinates", "inverse", "jacobian", "landing", "inverse checked", *found, "forward"),
        *("jacobian checked", "limits", "inverse_dynamics", "dynamics checked"),
    ]


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
    # keys that a kind has no value for stand in texts that it does not use
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
