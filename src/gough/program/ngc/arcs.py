"""Arcs in a plane: from a start, an end and either the centre or the radius, to a centre and a sweep.

The plane's two axes come in the order that makes the third a right-handed one: X Y (G17), Z X (G18), Y Z (G19); G3
turns from the first to the second.  Tolerances are LinuxCNC's: the distances of the two ends from the centre may differ
by 0.1 % of the radius, but 0.028 mm are always allowed (2 sqrt(2) times the 0.01 mm to which CAM systems round; in inch
programs 2 sqrt(2) times 0.001 in) and more than a hundred times that never; an arc has a radius of 1.27 um at least; R
may be as much too small to reach.
The path is a true arc through both ends: the centre is moved to where both are equally far, along the chord.  Where
the ends nearly coincide that would move it too far; the arc then keeps its centre, and ends beside its end by no more
than the tolerance (tip.py adds the line that is missing).
"""

from __future__ import annotations

import math

from ...errors import ProgramError
from .modes import INCH, MM

PLANES = {170: (0, 1, 2), 180: (2, 0, 1), 190: (1, 2, 0)}  # first, second, and the axis that is the normal
MOST_TURNS = 1000
LARGEST_RADIUS = 1e6  # m
NEAR = 1e-9  # m; ends as near as that are one point, as everywhere in this package
_SMALLEST = 1.27e-6  # m
_ROUNDED = {MM: 2 * 0.01e-3 * math.sqrt(2), INCH: 2 * 0.001 * 0.0254 * math.sqrt(2)}  # m, by unit of length
_RELATIVE = 1e-3
_AXIS = {"I": "X", "J": "Y", "K": "Z"}
_CLOSED = 1e-6  # rad, a smaller sweep is a full turn


def by_center(start, end, center, clockwise, unit, letters="IJ", relative=True):
    """Centre (2,) m and sweep rad, > 0 counter-clockwise, of an arc about a given centre; (2,) m each.

    `letters` and `relative` (G91.1) are those of the words of the centre, for messages.

    Raises
    ------
    ProgramError
        without radius, or ends that do not lie on one circle.
    """
    both = " and ".join(letters)
    first, last = math.dist(start, center), math.dist(end, center)
    if first < _SMALLEST or last < _SMALLEST:
        raise ProgramError("an arc of radius zero", value=_mm(min(first, last)), cure=f"check {both}")
    if not max(first, last) < LARGEST_RADIUS:
        raise _too_large(max(first, last))
    error, allowed = abs(first - last), _ROUNDED[unit]
    counted = f"; {both} count from the start of the arc" if relative else ""
    if error > 100 * allowed or (error > allowed and error / max(first, last) > _RELATIVE):
        raise ProgramError(
            "the ends of an arc must lie on one circle",
            value=f"radius {_mm(first)} at the start, {_mm(last)} at the end",
            cure=f"check {', '.join(_AXIS[i] for i in letters)}, {both}{counted}",
        )
    chord = math.dist(start, end)
    if chord > 0:
        # how far along the chord the centre is from being equally far from both ends
        shift = (first * first - last * last) / (2 * chord)
        if abs(shift) <= max(allowed, _RELATIVE * first):
            center = tuple(c - shift * (b - a) / chord for c, a, b in zip(center, start, end, strict=True))
    return center, _sweep(start, end, center, clockwise)


def by_radius(start, end, radius, clockwise):
    """Centre (2,) m and sweep rad of an arc with a given radius; radius < 0: the arc of more than half a turn.

    Raises
    ------
    ProgramError
        the ends coincide, or the radius is too small to reach from one to the other.
    """
    chord = math.dist(start, end)
    if chord <= NEAR:
        raise ProgramError("an arc with R cannot end where it starts", cure="write a full circle with its centre")
    if chord / 2 - abs(radius) > _SMALLEST:
        raise ProgramError(
            "the radius is too small to reach the end", value=_mm(abs(radius)), cure=f"at least {_mm(chord / 2)}"
        )
    if not abs(radius) < LARGEST_RADIUS:
        raise _too_large(abs(radius))
    half = chord / 2
    size = max(abs(radius), half)
    height = math.sqrt((size - half) * (size + half))
    # the centre of a short counter-clockwise arc lies to the left of the chord
    left = height if (radius > 0) != clockwise else -height
    along = ((end[0] - start[0]) / chord, (end[1] - start[1]) / chord)
    center = (
        (start[0] + end[0]) / 2 - left * along[1],
        (start[1] + end[1]) / 2 + left * along[0],
    )
    sweep = 2 * math.asin(half / size)  # not from the ends' directions: on a huge circle they are one
    if radius <= 0:
        sweep = 2 * math.pi - sweep
    return center, -sweep if clockwise else sweep


def turns(sweep, count):
    """The sweep with count - 1 whole turns more."""
    return sweep + math.copysign(2 * math.pi * (count - 1), sweep)


def end(start, center, sweep):
    """Where an arc ends.  (2,) m."""
    c, s = math.cos(sweep), math.sin(sweep)
    x, y = start[0] - center[0], start[1] - center[1]
    return center[0] + c * x - s * y, center[1] + s * x + c * y


def _sweep(start, end, center, clockwise):
    begin = math.atan2(start[1] - center[1], start[0] - center[0])
    finish = math.atan2(end[1] - center[1], end[0] - center[0])
    turn = (begin - finish if clockwise else finish - begin) % (2 * math.pi)
    if turn < _CLOSED:
        turn += 2 * math.pi
    return -turn if clockwise else turn


def _too_large(radius):
    return ProgramError("the radius of an arc is too large", value=_mm(radius), cure="write a line: G1")


def _mm(value):
    return f"{value * 1e3:.4f} mm"
