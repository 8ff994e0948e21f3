"""The chains of a hybrid machine: frames that turn and slide one after the other, each with its motion.

A frame F stands at p_WF with axes R_WF, moves with v_F and turns with w, all in W; what follows F in a chain is

    turned by an angle about its third axis:   R <- R R_z(angle),   w <- w + R e_z angle'                           (1)
    shifted by o along its own axes:           p <- p + R o,        v <- v + w x R o + R o'                         (2)

and, where a slide gives way by d = [o; r], shifted by o and turned by r, about its first, second and third axis in this
order.  Velocities are linear in the rates, so that bodies, tool and closure can be differentiated.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import casadi as ca


class Frame(NamedTuple):
    """A frame in W, and how it moves."""

    R: Any  # R_WF (3, 3)
    p: Any  # p_WF (3,) m
    v: Any  # (3,) m/s in W
    w: Any  # (3,) rad/s in W

    @property
    def twist(self):
        """[v; w].  (6,)."""
        return ca.vertcat(self.v, self.w)


def fixed(p) -> Frame:
    """A frame at rest at p (3,) m, with the axes of W."""
    return Frame(ca.SX.eye(3), ca.SX(p), ca.SX.zeros(3), ca.SX.zeros(3))


def turned(frame: Frame, angle, rate) -> Frame:
    """Eq. (1)."""
    c, s = ca.cos(angle), ca.sin(angle)
    x, y = frame.R[:, 0], frame.R[:, 1]
    R = ca.horzcat(c * x + s * y, c * y - s * x, frame.R[:, 2])
    return Frame(R, frame.p, frame.v, frame.w + frame.R[:, 2] * rate)


def shifted(frame: Frame, o, rate) -> Frame:
    """Eq. (2); o and o' are (3,) m and m/s in the frame's own axes."""
    arm = frame.R @ ca.SX(o)
    return Frame(frame.R, frame.p + arm, frame.v + ca.cross(frame.w, arm) + frame.R @ ca.SX(rate), frame.w)


def flexed(frame: Frame, d, rate) -> Frame:
    """Shifted by d[:3] m and turned by the small angles d[3:] rad; `rate` (6,) is d'."""
    moved = shifted(frame, d[:3], rate[:3])
    for i in range(3):
        moved = _cycled(turned(_cycled(moved, i + 1), d[3 + i], rate[3 + i]), -i - 1)
    return moved


def _cycled(frame: Frame, steps: int) -> Frame:
    """The frame with its axes named in another order, the axis `steps` places on as the third: x y z -> y z x."""
    order = [(steps + k) % 3 for k in range(3)]
    return frame._replace(R=ca.horzcat(*[frame.R[:, k] for k in order]))


class Chains(NamedTuple):
    """All frames of the machine at its coordinates."""

    arm_1: Frame  # at its pivot, second axis along the arm
    slide_1: Frame  # motor side of the slide, at A_2 on arm 1
    link_2: Frame  # at A_2
    tool: Frame  # T, at the tip of the ram
    arm_6: Frame  # at its pivot
    slide_6: Frame  # motor side, at A_5 on arm 6
    link_5: Frame  # at A_5
    passive: Frame  # on link 2 at s54: where link 5 must be


def chains(p, z, zd, flex=None) -> Chains:
    """From the pivots to the tool and to both sides of the passive slide: eqs. (1), (2) and those of hybrid.py.

    `p` a view of the machine, z and zd (6,) coordinates and rates (s21, s65, s32, s54, phi10, phi60).  `flex` ((6,),
    (6,)) twice: what slides 1 and 6 give way between motor and link, and its rate.
    """
    b, overhang = p.base.half_width, p.base.overhang
    arm_1 = turned(fixed(ca.vertcat(-b, 0, -overhang)), z[4], zd[4])
    slide_1 = shifted(arm_1, ca.vertcat(0, z[0], 0), ca.vertcat(0, zd[0], 0))
    link_2 = slide_1 if flex is None else flexed(slide_1, *flex[0])
    tool = shifted(link_2, ca.vertcat(b, 0, z[2] + overhang), ca.vertcat(0, 0, zd[2]))
    passive = shifted(link_2, ca.vertcat(z[3], 0, 0), ca.vertcat(zd[3], 0, 0))
    arm_6 = turned(fixed(ca.vertcat(b, 0, -overhang)), z[5], zd[5])
    slide_6 = shifted(arm_6, ca.vertcat(0, z[1], 0), ca.vertcat(0, zd[1], 0))
    link_5 = slide_6 if flex is None else flexed(slide_6, *flex[1])
    return Chains(arm_1, slide_1, link_2, tool, arm_6, slide_6, link_5, passive)
