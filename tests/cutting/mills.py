"""What the tests of milling cut with."""

from __future__ import annotations

import numpy as np

from gough.cutting import Coefficients, Cutting, EndMill, Wall

# all six numbers there, none equal to another
MATERIAL = Coefficients(
    tangential=700e6, radial=210e6, axial=130e6, tangential_edge=11e3, radial_edge=17e3, axial_edge=3e3
)
SHARP = MATERIAL.replace(tangential_edge=0.0, radial_edge=0.0, axial_edge=0.0)
SPEED, FEED = 12_000 * 2 * np.pi / 60, 0.1  # rad/s, m/s


def mill(teeth=2, helix=30.0, **numbers) -> EndMill:
    return EndMill(diameter=12e-3, teeth=teeth, helix=np.radians(helix), **numbers)


def cut(
    tool=None, material=MATERIAL, height=18e-3, milling="down", radial=(1e-3,), places=(0.0, 0.1), **numbers
) -> Cutting:
    wall = Wall(axial_depth=height, places=list(places), radial=list(radial), milling=milling)
    return Cutting(tool=tool or mill(), coefficients=material, wall=wall, spindle_speed=SPEED, **numbers)


def sliced(cutting, speed, depth, angle, slices=20_000):
    """F_x, F_y, F_z, M_z by adding up thin slices of edge: eqs. (1)-(3) of the theory page and nothing else.  (4,)."""
    tool, K = cutting.tool, cutting.coefficients
    dz = cutting.wall.axial_depth / slices
    z = (np.arange(slices) + 0.5) * dz
    f = speed * 2 * np.pi / (tool.teeth * cutting.spindle_speed)
    pitch, k = 2 * np.pi / tool.teeth, 2 * np.tan(tool.helix) / tool.diameter
    reach = np.arccos(1 - 2 * depth / tool.diameter)
    first, last = (np.pi - reach, np.pi) if cutting.wall.milling == "down" else (0.0, reach)
    r = tool.runout or 0.0
    radius = [r * np.cos(tool.runout_angle - j * pitch) for j in range(tool.teeth)]
    total = np.zeros(4)
    for j in range(tool.teeth):
        phi = (angle + j * pitch - k * z) % (2 * np.pi)
        s, c = np.sin(phi), np.cos(phi)
        # the wall that tooth j meets was left by the deepest of all passes before, back to its own
        h = np.min([m * f * s + radius[j] - radius[(j + m) % tool.teeth] for m in range(1, tool.teeth + 1)], axis=0)
        on = (phi >= first) & (phi <= last) & (h > 0)
        t, n, a = (on * (kc * h + ke) * dz for kc, ke in (
            (K.tangential, K.tangential_edge), (K.radial, K.radial_edge), (K.axial, K.axial_edge)
        ))  # fmt: skip
        total += [(-t * c - n * s).sum(), (t * s - n * c).sum(), a.sum(), (t * tool.diameter / 2).sum()]
    return total
