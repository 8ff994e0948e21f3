"""How a tool gives way to the force of the cut, across its axis, along the force.

`Leaning`, the law that Okuda et al. 2006 measured on the walls they cut: under a mean normal force d the wall leans by

    theta = f(d) = c_1 |d| + c_2 d^2,  with the sign of d;     delta(z) = (R_a - z) tan theta                       (1)

about the upper edge of the wall, z = R_a; delta at the tip is their eq. (16), f their eq. (15) and fig. 10, which is
lost.  c_1 and c_2 are those whose inclinations come nearest to table 3 at its worst row, 0.4 mdeg, rounded: with them
38, 58 and 76 N give all of its commands to the printed digit.

`Beam`, a cantilever after Euler and Bernoulli of length L and stiffness E I, x = L - z, a force F at x_F = L - z_F:

    delta(z) = F x^2 (3 x_F - x) / (6 E I)  for x <= x_F,     F x_F^2 (3 x - x_F) / (6 E I)  beyond                 (2)
    slope at the tip = F x_F^2 / (2 E I),     I = pi (`core` D)^4 / 64                                              (3)

(1) is a law of means: of the wall that many teeth have made.  (2) holds at every instant, so at the instant at which a
tooth makes its bit of wall; surface.py takes each by its kind.
"""

from __future__ import annotations

from typing import ClassVar, Literal

import numpy as np

from ..declare import Part, quantity

_DEG = np.pi / 180


class Leaning(Part):
    """The measured law, eq. (1)."""

    instant: ClassVar[bool] = False

    kind: Literal["measured"] = "measured"
    linear: float = quantity("rad/N", "c_1 of the law, of a small force", default=8.93e-4 * _DEG, at_least=0)
    quadratic: float = quantity("rad/N2", "c_2 of the law, of the force squared", default=2.56e-6 * _DEG, at_least=0)

    def inclination(self, force) -> np.ndarray:
        """theta under normal forces (...) N.  (...) rad."""
        d = np.abs(force)
        return np.sign(force) * (self.linear * d + self.quadratic * d * d)

    def lateral(self, tool, force, at, z, height) -> np.ndarray:
        """delta at the heights z m under forces N that broadcast; where they act, `at`, is in the law already.  m."""
        return (height - np.asarray(z)) * np.tan(self.inclination(force))


class Beam(Part):
    """The cantilever, eqs. (2), (3); numbers are the tool's."""

    instant: ClassVar[bool] = True

    kind: Literal["beam"] = "beam"

    def stiffness(self, tool) -> float:
        """E I, N m2."""
        return tool.modulus * np.pi * (tool.core * tool.diameter) ** 4 / 64

    def slope(self, tool, force, at) -> np.ndarray:
        """Slope at the tip under a force N at the height `at` m, eq. (3).  rad."""
        return np.asarray(force) * (tool.extension - np.asarray(at)) ** 2 / (2 * self.stiffness(tool))

    def lateral(self, tool, force, at, z, height) -> np.ndarray:
        """delta at the heights z m under forces N at the heights `at` m, all broadcast, eq. (2).  m."""
        x, x_F = tool.extension - np.asarray(z, float), tool.extension - np.asarray(at, float)
        near, far = np.minimum(x, x_F), np.maximum(x, x_F)
        # eq. (2) is symmetric in x and x_F (Maxwell): the shorter one squared, thrice the longer one less it
        return np.asarray(force) * near**2 * (3 * far - near) / (6 * self.stiffness(tool))
