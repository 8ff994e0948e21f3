"""The rigid half of the claims: the misprints, computed torque that errs by nothing, centres of mass that are off."""

from __future__ import annotations

import numpy as np

from ...machine.sheet import load_machine
from ..claims import Claim
from . import checks
from .experiments import Results
from .setup import LOW, PRINTED, machine

MM = 1e-3
CTC, PID = "computed torque", "PID"
PUBLISHED = {"low": '"higher than 0.8 mm"', "high": '"about 0.1 mm"'}  # errors of s21 under PID
SIDE = "arm 1 was put at +x, where the sheet has arm 6, so that slide 1 errs like that"


def rigid_claims(found: Results) -> list[Claim]:
    """Misprints, then both laws on the machine they know, then on machines they do not know, then forces."""
    return [*_misprints(found), *_known(found), *_unlike(found), *_forces(found)]


def _misprints(found: Results) -> list[Claim]:
    e = found.elimination
    where = f"{checks.POSES} random states of the workspace"
    swings = found.unlike["printed", CTC].swinging.max(0)[0] / found.unlike["low", CTC].swinging.max(0)[0]
    return [
        Claim(
            "C_S with the lost factor Phi_phi^-1: error over the forces it gives", e.repaired / e.largest, "1",
            (0, 1e-12), note=f"{where}, against the machine's own equations",
        ),
        Claim(
            "C_S as printed: the same", e.printed / e.largest, "1", (0.1, None),
            note=f"up to {e.printed / 1e3:.0f} kN off where centrifugal forces are {e.largest / 1e3:.0f} kN at most",
        ),
        Claim(
            "low gains with k_p = 2.25e4: k_p^2 over 4 k_d k_i", checks.cascade_share(LOW), "1", (1, None),
            note="from 1 on a cascade of P and PI has the same poles, which the paper says it has",
        ),
        Claim(
            "low gains as printed, k_p = 2.25e3: the same", checks.cascade_share(PRINTED), "1", (None, 1),
            note="no cascade has them; (600, 9e4, 3e6) at half the pace is (300, 2.25e4, 3.75e5)",
        ),
        Claim(
            "low gains as printed: damping of the slow pair", checks.damping(), "1", (0.046, 0.048),
            note="at 35.6 1/s; without swinging with 2.25e4",
        ),
        Claim(
            "computed torque, printed over repaired low gains: s21 from 0.2 s behind the move on", float(swings), "1",
            (10, None), note="centres of mass off by 20 %: what the printed gains do",
        ),
    ]  # fmt: skip


def _known(found: Results) -> list[Claim]:
    out = []
    for key in ("low", "high"):
        zero = float(np.abs(found.continuous[key, CTC].e).max())
        out.append(Claim(
            f"rigid, {key} gains, computed torque in continuous time: error", zero, "m", (0, 1e-12), published=0.0,
            note='"strictly zeros"; what rounding and the integration leave',
        ))  # fmt: skip
        sampled = float(found.known[key, CTC].largest.max())
        out.append(Claim(
            f"rigid, {key} gains, computed torque at 50 us: error", sampled, "m", (None, 10e-6), shown="um",
            note="speeds of the sample's mean, forces held",
        ))  # fmt: skip
    for key in ("low", "high"):
        whole, sampled = np.abs(found.continuous[key, PID].e).max(0)[0], found.known[key, PID].largest[0]
        out.append(Claim(
            f"rigid, {key} gains, PID: error of s21", float(sampled), "m", (0.97 * whole, 1.03 * whole), shown="mm",
            note=f"band: 3 % about {whole / MM:.3g} mm in continuous time, by another law and another integrator; the "
            f"paper has {PUBLISHED[key]} of its flexible machine; {SIDE}",
        ))  # fmt: skip
    other = found.other_side["low"].largest[0]
    out.append(Claim(
        "rigid, low gains, PID, arm 1 where the sheet has it: error of s21", float(other), "m", (None, 0.2 * MM),
        shown="mm", note="the other slide then errs by as much as s21 does above: it hangs on which arm is 1, and that "
        "is lost with Fig. 1",
    ))  # fmt: skip
    return out


def _unlike(found: Results) -> list[Claim]:
    out = []
    for key in ("low", "high"):
        pid, ctc = (found.unlike[key, name].largest.max(0)[0] for name in (PID, CTC))
        out.append(Claim(
            f"centres of mass off by 20 %, {key} gains: error of s21, PID over computed torque", float(pid / ctc), "1",
            (5, None),
            note=f'"negligible": {1e6 * ctc:.0f} um against {1e6 * pid:.0f} um, each the worst of 16; the band is ours',
        ))  # fmt: skip
    return out


def _forces(found: Results) -> list[Claim]:
    limit = load_machine("ifma-hsm").drive.force_limit
    known, off = (np.max([c.force for c in of.values()], axis=0) for of in (found.known, found.unlike))
    off = off.max(0)
    told = ", ".join(f"{joint} {force / 1e3:.1f} kN" for joint, force in zip(machine().joint_names, known, strict=True))
    return [
        Claim(
            "greatest force of a motor in all rigid runs", float(off.max()), "N", (None, limit), shown="kN",
            calibrated="the motors of the sheet are made for more than the move asks for; the paper prints no number",
            note=f'"remain acceptable and less than the maximal values"; on the machine that is known {told}',
        )
    ]  # fmt: skip
