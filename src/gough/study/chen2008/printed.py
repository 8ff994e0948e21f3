"""The law to the letter of the paper: +Omega in it, and a sliding variable without the integral.

With E'' = W + G u the printed law is u = G^-1 (W + v), v = -b E' - c E - K sat(s / delta), so E'' = 2 W + v: the
sliding mode takes 2 W for a disturbance.  It holds it where 2 |W| <= K, and leaves what changes of it; it does not
hold it beyond.  The printed sigma = E' + b E + c E has no integral, and leaves E = s / (b + c) of what stays.
"""

from __future__ import annotations

from typing import Literal

from ...control.equivalent_error import EquivalentError
from ...mechanics.linear import clip


class PrintedSign(EquivalentError):
    """u = G^-1 (+W + v)."""

    kind: Literal["printed_sign"] = "printed_sign"

    def command(self, p, z, v, J, E, state):
        """G^-1 (v - W) of the law, less twice the -G^-1 W that holds E'' at 0."""
        ours = super().command(p, z, v, J, E, state)
        return ours - 2 * self.force(p, z, v, J, E, 0 * E.value, 0 * state.started)


class PrintedSliding(EquivalentError):
    """s = E' + b E + c E."""

    kind: Literal["printed_sliding"] = "printed_sliding"

    def asked(self, p, E, integral):
        s = E.rate + (p.damping + p.stiffness) * E.value
        return -p.damping * E.rate - p.stiffness * E.value - p.strength * clip(s / p.boundary, -1, 1)


def to_the_letter(cls: type[EquivalentError], law: EquivalentError) -> EquivalentError:
    """`law` with all its numbers, as one of the two above."""
    numbers = {key: getattr(law, key) for key in type(law).model_fields if key not in ("kind", "machine", "period")}
    return cls(**numbers)
