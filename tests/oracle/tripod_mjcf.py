"""A 3-PRS as an MJCF tree, loops left open: sliders, hinged links, and the platform free; sites mark the joints."""

from __future__ import annotations

import numpy as np


def _n(values) -> str:
    return " ".join(f"{v:.17g}" for v in np.ravel(values))


def tripod_mjcf(m) -> str:
    """The text.  Link frames: x along `across`, z along the hinge; all slides and hinges at zero."""
    parts = []
    for i in range(3):
        d, c = m.rails.direction[i], m.rails.across[i]
        L, m_l = m.link.length, m.link.mass
        armature = m.drive.inertia * (2 * np.pi / m.drive.lead) ** 2
        frame = f'xyaxes="{_n(c)} {_n(d)}"'  # its z is c x d, the hinge
        rod = f"{m_l * L**2 / 12:.17g}"
        parts.append(f"""
      <body name="slider {i + 1}" pos="{_n(m.rails.point[i])}" {frame}>
        <joint name="S{i + 1}" type="slide" axis="0 1 0" armature="{armature:.17g}"/>
        <inertial pos="0 0 0" mass="{m.slider.mass:.17g}" diaginertia="1e-12 1e-12 1e-12"/>
        <body name="link {i + 1}">
          <joint name="theta{i + 1}" type="hinge" axis="0 0 1"/>
          <inertial pos="{L / 2:.17g} 0 0" mass="{m_l:.17g}" diaginertia="1e-14 {rod} {rod}"/>
          <site name="end {i + 1}" pos="{L:.17g} 0 0"/>
        </body>
      </body>""")
    I = m.platform.inertia
    full = [I[0, 0], I[1, 1], I[2, 2], I[0, 1], I[0, 2], I[1, 2]]
    sites = "".join(f'<site name="seat {i + 1}" pos="{_n(m.joints.platform[i])}"/>' for i in range(3))
    return f"""<mujoco><compiler angle="radian" autolimits="false" boundmass="0" boundinertia="0"/>
  <option gravity="{_n(m.gravity)}"/>
  <worldbody>{"".join(parts)}
    <body name="platform"><freejoint name="platform"/>
      <inertial pos="{_n(m.platform.center)}" mass="{m.platform.mass:.17g}" fullinertia="{_n(full)}"/>{sites}
    </body>
  </worldbody></mujoco>"""
