"""The fastest rise of speed from a node, where the acceleration is zero, under caps that come one after the other.

A climb starts at distance 0 with speed n and acceleration 0 and rises with the jerk +J up to the acceleration A, which
it holds.  A cap bends it: from a switch on it runs with -J (a *taper*).  The climb is a stack of pieces of constant
jerk, each known by its start (d, v, a).  Along it the *level*

    v + a^2 / 2 J                                                                                                  (5)

is the speed at which a taper would arrive with a = 0; it rises along pieces of +J and 0 and stays along pieces of -J.
`reach(w)` is the distance at which the climb, tapered from its level w, runs at w with a = 0.

Two climbs that part at one state, one with -J and the other with any jerk: with da/ds = j / v the first has the lower
a and the lower v at every distance behind.  So bending a climb earlier breaks no cap that it already kept, and a new
cap needs one switch, found from the top of the stack down.  docs/theory/feed.md, section 4.
"""

from __future__ import annotations

from bisect import bisect_right
from math import sqrt

_STEPS = 260  # of a root: a quarter of them bisections, which alone would do


class Climb:
    """One climb under way.  `start`, `limit`, `extend` and then `beneath`, `reach`, `touch` for each cap, in order."""

    __slots__ = ("A", "J", "hold", "levels", "speed", "stack")

    def start(self, speed: float, A: float, J: float) -> None:
        """Begin at distance 0 at `speed`, with a = 0; `A` holds from there on."""
        self.speed, self.A, self.J = speed, A, J
        self.stack, self.levels = [(0.0, speed, 0.0, J)], [speed]
        self._find_hold()

    def _push(self, d, v, a, j):
        self.stack.append((d, v, a, j))
        self.levels.append(v + a * a / (2 * self.J))

    def _pop(self):
        self.stack.pop()
        self.levels.pop()

    def _find_hold(self):
        """The distance at which the last piece, of +J, comes to A."""
        d, v, a, _ = self.stack[-1]
        t = (self.A - a) / self.J
        self.hold = d + t * (v + t * (a / 2 + self.J * t / 6)) if t > 0 else d

    def limit(self, D: float, A: float) -> None:
        """From the distance D, where the climb is now, the acceleration may not be above A."""
        d, v, a, j = self.stack[-1]
        J, old, self.A = self.J, self.A, A
        if old < A:
            if j == 0:
                if d < D:
                    self._push(D, sqrt(v * v + 2 * a * (D - d)), a, J)
                else:
                    self.stack[-1] = (d, v, a, J)
            self._find_hold()
        elif old > A:
            if j > 0:
                self._find_hold()
                if self.hold >= D and a <= A:
                    return
            self._ease(D, A)

    def _ease(self, D, A):
        """Bend the climb so that a = A at D."""
        J = self.J
        while True:
            d, v, a, j = self.stack[-1]
            if a <= A or d + _taper(v, a, (a - A) / J, J) <= D:
                break
            self._pop()
        if j > 0:  # how far up to z before it comes down to A: the distance grows with z

            def excess(z):
                t = (z - a) / J
                v1, back = v + t * (a + z) / 2, (z - A) / J
                return D - d - t * (v + t * (a / 2 + J * t / 6)) - _taper(v1, z, back, J)

            low = max(a, A)
            high = 2 * low
            while excess(high) > 0:
                high *= 2
            z = _root(excess, low, high)
            t = (z - a) / J
            d, v, a = d + t * (v + t * (a / 2 + J * t / 6)), v + t * (a + z) / 2, z
        elif j == 0:  # hold on for t: a quadratic
            back = (a - A) / J
            left = D - d - _taper(v, a, back, J)
            w = v + a * back
            t = 2 * left / (w + sqrt(w * w + 2 * a * left)) if left > 0 else 0.0
            d, v = d + t * (v + a * t / 2), v + a * t
        if a > A:
            self._push(d, v, a, -J)
            v += (a * a - A * A) / (2 * J)
        self._push(D, v, A, 0.0)

    def extend(self, D: float) -> None:
        """Carry the climb on to the distance D."""
        if self.hold < D and self.stack[-1][3] > 0:
            _, v, a, _ = self.stack[-1]
            if a < self.A:
                self._push(self.hold, v + (self.A * self.A - a * a) / (2 * self.J), self.A, 0.0)
            else:
                d, v, a, _ = self.stack[-1]
                self.stack[-1] = (d, v, a, 0.0)

    def beneath(self, D: float, w: float) -> bool:
        """Whether the climb, carried on to D, is not faster than w there."""
        d, v, a, j = self.stack[-1]
        if w < v:
            return False
        if j == 0:
            return v * v + 2 * a * (D - d) <= w * w
        t = 2 * (w - v) / (sqrt(a * a + 2 * self.J * (w - v)) + a) if w > v else 0.0
        return d + t * (v + t * (a / 2 + self.J * t / 6)) >= D

    def reach(self, w: float) -> float:
        """Distance at which the climb tapered to the speed w >= its first runs at w with a = 0."""
        J = self.J
        d, v, a, j = self.stack[bisect_right(self.levels, w) - 1]
        z, t = _switch(v, a, j, w, J)
        v1, t2 = v + t * (a + z) / 2, z / J
        return d + t * (v + t * (a / 3 + z / 6)) + t2 * (v1 + z * t2 / 3)

    def touch(self, D: float, w: float) -> None:
        """Bend the climb so that it passes D at the speed w, with a > 0: where it is neither beneath nor reaches w."""
        J = self.J
        end = None  # acceleration with which the climb passes w if it bends at the end of the piece
        while True:
            d, v, a, j = self.stack[-1]
            y = a * a - 2 * J * (w - v)
            if y <= 0 or d + _taper(v, a, (a - sqrt(y)) / J, J) >= D:
                break
            end = sqrt(y)
            self._pop()
        low = sqrt(y) if y > 0 else 0.0
        if j < 0:
            low_root = low
        elif j > 0:
            q = a * a + 2 * J * (w - v)
            high = sqrt(q) if end is None else end

            def excess(y):
                z = sqrt((y * y + q) / 2)
                t, t2 = (z - a) / J, (z - y) / J
                v1 = v + t * (a + z) / 2
                return d + t * (v + t * (a / 3 + z / 6)) + _taper(v1, z, t2, J) - D

            low_root = _root(excess, low, high)
            z = sqrt((low_root * low_root + q) / 2)
            t = (z - a) / J
            d, v, a = d + t * (v + t * (a / 3 + z / 6)), v + t * (a + z) / 2, z
        else:
            high = a if end is None else end

            def excess(y):
                v1 = w - (a * a - y * y) / (2 * J)
                return d + (v1 * v1 - v * v) / (2 * a) + _taper(v1, a, (a - y) / J, J) - D

            low_root = _root(excess, low, high)
            v1 = w - (a * a - low_root * low_root) / (2 * J)
            d, v = d + (v1 * v1 - v * v) / (2 * a), v1
        if j >= 0:
            self._push(d, v, a, -J)
        self._push(D, w, low_root, J)
        self._find_hold()


def _taper(v, a, t, J):
    """Distance in the time t from the state (v, a) with the jerk -J."""
    return t * (v + t * (a / 2 - J * t / 6))


def _switch(v, a, j, w, J):
    """From (v, a) with the jerk j: acceleration z and time t at which the level is w."""
    if j > 0:
        z = sqrt(max(a * a / 2 + J * (w - v), a * a))
        return z, (z - a) / J
    if j == 0:
        return a, max((w - a * a / (2 * J) - v) / a, 0.0)
    return a, 0.0


def _root(f, low, high):
    """The zero of a falling function between low, where f >= 0, and high: the last number found with f >= 0."""
    f_low, f_high = f(low), f(high)
    if f_high >= 0:
        return high
    if f_low <= 0:
        return low
    side = 0
    for step in range(_STEPS):
        # false position, with the halving of Illinois; every fourth step a bisection
        x = low + (high - low) * f_low / (f_low - f_high) if step % 4 < 3 else (low + high) / 2
        if not low < x < high:
            x = (low + high) / 2
            if not low < x < high:
                break
        fx = f(x)
        if fx >= 0:
            low, f_low = x, fx
            if side > 0:
                f_high /= 2
            side = 1
        else:
            high, f_high = x, fx
            if side < 0:
                f_low /= 2
            side = -1
        if fx == 0:
            break
    return low
