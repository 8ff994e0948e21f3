"""A hybrid machine as an MJCF tree, its loop left open: arm 1, link 2, passive slide and ram; arm 6 and link 5."""

from __future__ import annotations

import numpy as np


def _n(values) -> str:
    return " ".join(f"{v:.17g}" for v in np.ravel(values))


def _body(body, at=(0.0, 0.0, 0.0)) -> str:
    I = body.inertia
    full = [I[0, 0], I[1, 1], I[2, 2], I[0, 1], I[0, 2], I[1, 2]]
    return f'<inertial pos="{_n(body.center + np.array(at))}" mass="{body.mass:.17g}" fullinertia="{_n(full)}"/>'


LIGHT = 1e-9  # kg, kg m2: MuJoCo wants a mass in every body that moves, and inertias that some body has


def _arm(m, name, x, inside) -> str:
    a, s = m.arm, m.slide
    bar, block = (_n([I / 2, I, I]) for I in (a.inertia, s.inertia))  # only the third axis matters
    return f"""
    <body name="{name}" pos="{_n([x, 0, -m.base.overhang])}">
      <joint name="phi {name}" type="hinge" axis="0 0 1"/>
      <inertial pos="0 {a.center:.17g} 0" mass="{a.mass:.17g}" diaginertia="{bar}"/>
      <body name="motor {name}">
        <joint name="s {name}" type="slide" axis="0 1 0"/>
        <inertial pos="0 0 0" mass="{s.mass:.17g}" diaginertia="{block}"/>
        {inside}
      </body>
    </body>"""


def hybrid_mjcf(m) -> str:
    """The text.  Frames have the axes of link 2 at its zero; joints phi1 s21 s32 s54 | phi6 s65."""
    light = f'<inertial pos="0 0 0" mass="{LIGHT:g}" diaginertia="{LIGHT:g} {LIGHT:g} {LIGHT:g}"/>'
    one = f"""<body name="link 2">{_body(m.link2)}
          <body name="ram" pos="{_n([m.base.half_width, 0, m.base.overhang])}">
            <joint name="s32" type="slide" axis="0 0 1"/>{_body(m.ram)}<site name="tip"/>
          </body>
          <body name="passive"><joint name="s54" type="slide" axis="1 0 0"/>{light}<site name="seat"/></body>
        </body>"""
    six = f'<body name="link 5">{_body(m.link5)}<site name="end"/></body>'
    return f"""<mujoco><compiler angle="radian" autolimits="false" boundmass="0" boundinertia="0"/>
  <option gravity="{_n(m.gravity)}"/>
  <worldbody>{_arm(m, "1", -m.base.half_width, one)}{_arm(m, "6", m.base.half_width, six)}
  </worldbody></mujoco>"""
