"""Motions against what their programs mean, by a second derivation: from samples, by differences and dense search.

By the theorem of the mean a difference never exceeds the step times the largest derivative, so limits are checked
without an error of the method: |s'_1 - s'_0| <= a h, |s'_2 - 2 s'_1 + s'_0| <= j h^2.
"""

import itertools

import numpy as np
import pytest

from gough.measure.contour import ContourMeter
from gough.program import NCProgram
from gough.program.blend import blend
from gough.program.blocks import Arc, Block, Line
from gough.program.junctions import stops
from gough.program.path import Path
from gough.program.segments import norm

from .meant import rotations, written

HOLDS = 1 + 1e-6
PROFILES = ("trapezoid", "jerk_limited")
OPTIONS = ({}, {"corner": "blend", "tolerance": 50e-6}, {"corner": "blend", "tolerance": 200e-6, "spline": True})


class Samples:
    """A motion at some 20 000 times, at most 1 ms apart, with the move that each belongs to."""

    def __init__(self, motion, moves):
        self.motion, self.moves = motion, moves
        self.Ts = Ts = min(1e-3, motion.feed.duration / 20_000)
        n = motion.count(Ts)
        self.r, self.book = motion.sample(0, n, Ts), motion.book(0, n, Ts)
        number = {move.line: k for k, move in enumerate(moves)}
        self.on = self.book.line > 0
        self.move = np.array([number[line] if line else 0 for line in self.book.line])
        self.move = np.maximum.accumulate(self.move)  # behind the end: the last
        arm = np.array([m.tool for m in moves])[self.move][:, None]
        self.length = np.array([m.length for m in moves])
        self.moving = self.on & (self.length[self.move] > 0)
        self.R = rotations(self.r.x[:, 3:])
        o = arm * self.R[:, :, 2]
        w, wd = self.r.xd[:, 3:], self.r.xdd[:, 3:]
        self.tip = self.r.x[:, :3] - o
        self.v = self.r.xd[:, :3] - np.cross(w, o)
        self.a = self.r.xdd[:, :3] - np.cross(wd, o) - np.cross(w, np.cross(w, o))

    def each(self, value):
        """`value(move)` of the move of each sample."""
        return np.array([value(m) for m in self.moves])[self.move]


def check_limits(got: Samples, jerk):
    feed, r, Ts, moving = got.motion.machine.feed, got.r, got.Ts, got.moving
    speed, sd = norm(got.v), r.sd[:, 0]
    top = got.each(lambda m: feed.rapid if m.rapid else m.feed)
    assert (speed[moving] <= top[moving] * HOLDS + 1e-12).all()
    assert (speed[got.on & ~moving] <= 1e-12).all()
    np.testing.assert_allclose(sd, speed, atol=1e-9)
    assert norm(r.xd[:, 3:]).max() <= feed.angular_rate * HOLDS
    assert norm(r.xdd[:, 3:]).max() <= feed.angular_acceleration * HOLDS
    rounding = 1e-15 * (1 + 4 * feed.acceleration * max(1, got.motion.duration))  # of a time, times the acceleration
    assert np.abs(np.diff(sd)).max() <= (feed.acceleration * Ts) * HOLDS + 2 * rounding
    going = speed > 1e-6
    T = got.v[going] / speed[going, None]
    along = (got.a[going] * T).sum(1)
    across = got.a[going] - along[:, None] * T
    assert np.abs(along).max() <= feed.acceleration * HOLDS
    assert norm(across).max() <= feed.acceleration * HOLDS
    if jerk:
        assert np.abs(np.diff(sd, 2)).max() <= feed.jerk * Ts**2 * HOLDS + 4 * rounding
        # v^3 |p'''| by the change of the curvature vector within a block of the course
        at = np.flatnonzero(going)
        block = got.motion.feed.at(at * Ts).block
        K, s = across / speed[at, None] ** 2, r.s[at, 0]
        same = (np.diff(at) == 1) & (np.diff(block) == 0) & (np.diff(s) > 1e-7)
        change = norm(np.diff(K, axis=0))[same] / np.diff(s)[same]
        assert (np.minimum(speed[at][1:], speed[at][:-1])[same] ** 3 * change).max(initial=0) <= feed.jerk * (1 + 1e-5)


def check_derivatives(got: Samples):
    """The trapezoidal rule errs by h^2 / 8 times the range of the next derivative, where that jumps; else far less."""
    r, h = got.r, got.Ts
    off = np.abs(np.diff(r.x[:, :3], axis=0) - h / 2 * (r.xd[1:, :3] + r.xd[:-1, :3])).max(1)
    assert off.max() <= h * h / 2 * norm(r.xdd[:, :3]).max() + 1e-12
    assert np.median(off) <= 1e-4 * h * np.abs(r.xd).max()
    # central differences over 20 us: most of so short a time is inside a phase
    h, off = 1e-5, []
    for t in np.random.default_rng(0).uniform(0, got.motion.feed.duration, 150):
        k = round(t / h) + 1
        x, xd, xdd = got.motion.sample(k - 1, k + 2, h)[:3]
        off.append(
            [np.abs(x[2, :3] - x[0, :3] - 2 * h * xd[1, :3]).max(), np.abs(xd[2] - xd[0] - 2 * h * xdd[1]).max()]
        )
    most = 2 * h * np.array([np.abs(r.xd).max(), np.abs(r.xdd).max()])
    assert (np.quantile(off, 0.9, axis=0) <= 1e-6 * most + 1e-15).all()
    assert not r.xd[[0, -1]].any()
    np.testing.assert_allclose(got.tip[0], got.moves[got.move[0]].p0, atol=1e-12)
    np.testing.assert_allclose(got.r.x[-1, 3:], got.moves[-1].abc1, atol=1e-12)


def on_the_path(got: Samples, rows, allowed):
    """Distance to the programmed path and angle to its axis there, sought densely about the book's place."""
    starts = np.concatenate([[0.0], np.cumsum(got.length)])
    own, tip, Z = got.move[rows], got.tip[rows], got.R[rows][:, :, 2]
    # neither a rest nor another tool may lie between
    still = got.length == 0
    part = np.cumsum(still)
    best, angle = np.full(len(rows), np.inf), np.zeros(len(rows))
    place, width = got.book.s[rows], np.maximum(40 * allowed, 1e-7)
    for _ in range(4):
        center = place.copy()
        for share in np.linspace(-1, 1, 61):
            s = np.clip(center + share * width, 0.0, starts[-1])
            k = np.clip(np.searchsorted(starts, s, "right") - 1, 0, len(still) - 1)
            k = np.where(still[own] | (part[k] != part[own]), own, k)
            p, axis = np.empty((len(rows), 3)), np.empty((len(rows), 3))
            for move in np.unique(k):
                at = np.flatnonzero(k == move)
                x = np.clip((s[at] - starts[move]) / (got.length[move] or 1.0), 0, 1)
                m = got.moves[move]
                p[at], axis[at] = m.at(x), rotations(m.abc(x))[:, :, 2]
            away = norm(p - tip)
            nearer = away < best
            turned = np.arctan2(norm(np.cross(axis, Z)), (axis * Z).sum(1))
            best, angle = np.where(nearer, away, best), np.where(nearer, turned, angle)
            place = np.where(nearer, s, place)
        width = width / 18
    return best, np.where(still[own], 0.0, angle)


def check_path(got: Samples, tolerance):
    """`tolerance` (m,) m of the junctions behind the moves."""
    moves = got.moves
    allowed = np.maximum(np.maximum(np.append(0.0, tolerance[:-1]), np.append(tolerance[:-1], 0.0)), 0.0)
    rows = np.arange(0, len(got.move), max(1, len(got.move) // 1500))
    away, angle = on_the_path(got, rows, allowed[got.move[rows]])
    # 2e-9: the reader takes an arc's end as met where it is a nanometre away
    assert (away <= allowed[got.move[rows]] * HOLDS + 2e-9).all()
    # the closest place by this search and that of the planner differ where two are about as near
    assert (angle <= allowed[got.move[rows]] / 0.1 * 1.02 + 1e-6).all()
    starts = np.concatenate([[0.0], np.cumsum(got.length)])
    s = got.book.s[got.on]
    assert (np.diff(got.move) >= 0).all() and (np.diff(got.book.s) >= -1e-15).all()
    assert (s >= starts[got.move[got.on]] - 1e-8).all() and (s <= starts[got.move[got.on] + 1] + 1e-8).all()
    fastest = norm(got.v).max()
    for k, m in enumerate(moves[:-1]):
        if m.kind == "dwell" and m.dwell:
            assert abs((got.book.line == m.line).sum() * got.Ts - m.dwell) <= 2 * got.Ts + 1e-9
        if m.length and moves[k + 1].tool == m.tool:
            # the corner is within the tolerance of the course, whose samples are chords
            near = np.argmin(norm(got.tip - m.p1))
            a, b = got.tip[[max(near - 1, 0), near]], got.tip[[near, min(near + 1, len(got.tip) - 1)]]
            sag = got.motion.machine.feed.acceleration * got.Ts**2  # of a chord, with both accelerations at their most
            away = min(distance(m.p1, *a), distance(m.p1, *b))
            assert away <= max(tolerance[k], 0) * HOLDS + 2e-9 + sag
            if tolerance[k] <= 0 or not moves[k + 1].length:
                passes_through(got, k, tolerance[k] < 0, fastest)


def distance(p, a, b):
    step = b - a
    x = np.clip((p - a) @ step / (step @ step), 0, 1) if step.any() else 0.0
    return np.linalg.norm(p - a - x * step)


def passes_through(got: Samples, k, stopping, fastest):
    """The tip is at the end of move k when the book turns to the next line; at rest, if `stopping`."""
    m, h = got.moves[k], 1e-9  # s
    last = np.flatnonzero(got.book.line == m.line)
    if not len(last):
        return
    low, high = (round(t * got.Ts / h) for t in (last[-1], last[-1] + 1))
    while high - low > 1:
        middle = (low + high) // 2
        same = got.motion.book(middle, middle + 1, h).line[0] == m.line
        low, high = (middle, high) if same else (low, middle)
    r = got.motion.sample(low, low + 1, h)
    tip = r.x[0, :3] - m.tool * rotations(r.x[:, 3:])[0, :, 2]
    assert np.linalg.norm(tip - m.p1) <= 2e-9 + h * fastest
    if stopping:
        assert r.sd[0, 0] <= 2 * h * got.motion.machine.feed.acceleration


def check(seed, profile, options, machine):
    text, moves = written(seed, 12)
    motion = NCProgram(text=text, profile=profile, **options).plan(machine)
    got = Samples(motion, moves)
    tolerance = np.array([options.get("tolerance", m.tolerance) for m in moves])
    check_limits(got, profile == "jerk_limited")
    check_derivatives(got)
    check_path(got, tolerance)


@pytest.mark.quick("trapezoid-options0", "jerk_limited-options3")
@pytest.mark.parametrize("profile, options", list(itertools.product(PROFILES, OPTIONS)))
def test_a_motion_is_what_its_program_means_within_all_limits(profile, options, machine):
    check(50 if options else 22, profile, options, machine)  # both tilt along lines and arcs with a tool offset


@pytest.mark.slow
@pytest.mark.parametrize("first", range(0, 120, 20))
def test_hundreds_of_motions_are_what_their_programs_mean_within_all_limits(first, machine):
    for seed in range(first, first + 20):
        check(seed, PROFILES[seed % 2], OPTIONS[seed % 3], machine)


def test_a_bump_of_a_blend_between_the_places_looked_at_stays_within_the_tolerance():
    """An arc of 309 degrees into a line that goes back: at 0.405 of the blend it is 3 % farther than at n / 16."""
    mm, P = 1e-3, 24.827255e-6
    arc = Arc(
        tuple(mm * np.array([11.34552675, 1.36811888, -0.3722237])),
        tuple(mm * np.array([11.34552675, 0.95861936, -7.09339814])), (1, 0, 0), -5.398826513727566, -6.053529271 * mm,
    )  # fmt: skip
    first = Path([Block(arc, feed=0.02)])
    end = first.point(np.zeros(1, int), first.length)[0]
    to = mm * np.array([4.371347, -0.136534, 1.428658])
    path = Path([Block(arc, feed=0.02), Block(Line(tuple(end), tuple(to)), feed=0.02)])
    found = blend(path, path, np.full(2, P), np.full(2, P / 0.1), True)
    zero = np.zeros(2001, int)
    p = found.curves.at(zero, np.linspace(0, 1, 2001))
    length = path.length[0] - np.linspace(0, 1.5, 40_001) * found.back[0]
    legs = [path.point(np.zeros(40_001, int), length), path.point(np.ones(40_001, int), path.length[0] - length)]
    away = distances(p, np.concatenate(legs))
    assert 0.95 * P < away.max() <= P


def distances(p, q):
    """From points p (n, 3) to the nearest of many points q, 0.1 um apart or so.  (n,)."""
    from scipy.spatial import cKDTree

    return cKDTree(q).query(p)[0]


def test_a_blend_beside_a_rapid_is_no_faster_than_the_rapid(machine):
    text = "G64 P0.2 F60000\nG0 X200\nG1 X400 Y3\nM2\n"
    motion = NCProgram(text=text).plan(machine)
    path = motion.course.path
    beside = motion.feed.speed[~path.rapid & (path.kind == 4)]
    assert len(beside)
    assert (beside <= machine.feed.rapid).all()
    assert motion.feed.speed.max() == 1.0  # the G1 itself runs at its F


def second_order_optimum(motion, n=4000):
    """Least time along the course under its caps at each place, not at the worst of each block: two passes on v^2."""
    path, a = motion.course.path, motion.machine.feed.acceleration
    assert not stops(path).any()
    caps, steps = [np.zeros(1)], []
    for i in range(len(path)):
        u = np.linspace(0, path.length[i], n + 1)
        bend = norm(path.bend(np.full(n + 1, i), u))
        cap = np.minimum(path.feed[i] ** 2, a / np.maximum(bend, 1e-300))
        caps[-1][-1] = min(caps[-1][-1], cap[0])
        caps.append(cap[1:])
        steps.append(np.full(n, u[1]))
    caps[-1][-1] = 0.0
    b, gain = np.concatenate(caps).tolist(), (2 * a * np.concatenate(steps)).tolist()
    for k in range(len(gain)):
        b[k + 1] = min(b[k + 1], b[k] + gain[k])
    for k in reversed(range(len(gain))):
        b[k] = min(b[k], b[k + 1] + gain[k])
    v = np.sqrt(b)
    return (2 * np.concatenate(steps) / (v[1:] + v[:-1])).sum()


@pytest.mark.parametrize("degrees, tolerance, feed", [(19, 0.1, 18000), (44, 0.5, 18000), (89, 0.5, 18000)])
def test_a_corner_takes_no_more_than_a_hundredth_above_the_optimum(degrees, tolerance, feed, machine):
    """The worst of a search over turns of 4 to 120 degrees, 5 um to 0.5 mm and 3 to 18 m/min: 0.6 %."""
    end = 100 + 100 * np.exp(1j * np.radians(degrees))
    text = f"G64 P{tolerance} F{feed} G1 X100\nX{end.real:.6f} Y{end.imag:.6f}\nM2\n"
    motion = NCProgram(text=text).plan(machine)
    optimum = second_order_optimum(motion)
    assert optimum * (1 - 1e-4) <= motion.feed.duration <= optimum * 1.01


@pytest.mark.quick("options0-*", "options1-trapezoid")
@pytest.mark.parametrize("profile", PROFILES)
@pytest.mark.parametrize("options", OPTIONS)
def test_a_tool_exactly_on_its_reference_has_the_contour_error_of_its_blends_alone(options, profile, machine):
    text, moves = written(11, 10)
    motion = NCProgram(text=text, profile=profile, **options).plan(machine)
    Ts = motion.duration / 3000
    n = motion.count(Ts)
    x = motion.sample(0, n, Ts).x
    found = ContourMeter(motion)(0, n, Ts, np.column_stack([x[:, :3], quaternions(x[:, 3:])]))
    most = max(options.get("tolerance", m.tolerance) for m in moves)
    assert found.contour_error.max() <= max(most, 0) * HOLDS + 1e-12
    if options:
        assert found.contour_error.max() > 0.5 * most
    sharp = NCProgram(text=text, profile=profile, corner="stop").plan(machine)
    n = sharp.count(Ts)
    x = sharp.sample(0, n, Ts).x
    found = ContourMeter(sharp)(0, n, Ts, np.column_stack([x[:, :3], quaternions(x[:, 3:])]))
    assert found.contour_error.max() <= 1e-12


def quaternions(abc):
    """w x y z of Rz(c) Ry(b) Rx(a), multiplied out.  (n, 3) -> (n, 4)."""
    (ca, cb, cc), (sa, sb, sc) = np.cos(abc.T / 2), np.sin(abc.T / 2)
    w, z = cc * cb * ca + sc * sb * sa, sc * cb * ca - cc * sb * sa
    return np.stack([w, cc * cb * sa - sc * sb * ca, cc * sb * ca + sc * cb * sa, z], 1)
