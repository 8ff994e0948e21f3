"""Input shapers: what is left of a mode, and that shaping a feed moves neither its path, its stops nor its limits."""

import numpy as np
import pytest
from scipy.signal import lsim

import gough as gk
from gough.errors import ExperimentError
from gough.program import Fourier, Line, Polyline
from gough.program.blocks import Block, Rest
from gough.program.blocks import Line as Straight
from gough.program.feed import Feed
from gough.program.path import Path
from gough.program.profiles.jerk_limited import jerk_limited
from gough.program.profiles.shaped import shaped
from gough.program.profiles.trapezoid import trapezoid
from gough.program.shaper import EI, KINDS, shaper_of

from .test_feed import chain, random_path
from .test_jerk_limited import LIMITS, cells_of, check_limits

F, ZETA = 49.0, 0.02
HALF = 1 / (2 * F * np.sqrt(1 - ZETA**2))


def shaken(t, a, f, zeta=0.0):
    """Amplitude at the end, over what a = 1 bends at rest, of a mode that the acceleration a(t) drives."""
    w = 2 * np.pi * f
    x = lsim(([[0, 1], [-w * w, -2 * zeta * w]], [[0], [w * w]], np.eye(2), np.zeros((2, 1))), a, t, interp=False)[2]
    return np.hypot(x[-1, 0], x[-1, 1] / w)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("zeta", [0.0, ZETA, 0.3])
def test_the_residual_of_a_shaper_is_what_a_mode_really_does_after_its_impulses(kind, zeta):
    made = shaper_of(kind, F, zeta)
    assert made.size.sum() == pytest.approx(1, abs=1e-15)
    for f in (F, 0.9 * F, 1.3 * F):
        w, d = 2 * np.pi * f, 2 * np.pi * f * np.sqrt(1 - zeta**2)
        late = made.delay - made.time  # each impulse gives the speed A_i and then swings freely
        x = (made.size * np.exp(-zeta * w * late) * np.sin(d * late)).sum() / d
        v = (made.size * np.exp(-zeta * w * late) * (np.cos(d * late) - zeta * w / d * np.sin(d * late))).sum()
        amplitude = np.hypot(d * x, v + zeta * w * x)  # of d x(t) e^(zeta w t), 1 for one impulse at the end
        assert made.residual(f, zeta) == pytest.approx(amplitude, abs=1e-14)


def test_zv_leaves_nothing_zvd_nothing_nearby_and_ei_its_five_percent():
    zv, zvd, ei = (shaper_of(kind, F) for kind in KINDS)
    assert zv.residual(F) < 1e-15 and zvd.residual(F) < 1e-15
    assert ei.residual(F) == pytest.approx(EI, abs=1e-15)
    # of zv |cos(pi f / 2 F)|, of zvd its square: a tenth off, 15.6 % and 2.4 %
    off = 0.9 * F
    assert zv.residual(off) == pytest.approx(abs(np.cos(np.pi * 0.45)), abs=1e-14)
    assert zvd.residual(off) == pytest.approx(np.cos(np.pi * 0.45) ** 2, abs=1e-14)
    f = np.linspace(0.5 * F, 1.5 * F, 4001)
    band = [np.ptp(f[(made.residual(f) <= EI * (1 + 1e-9))]) / F for made in (zv, zvd, ei)]
    # cos y = T, cos^2 y = T, and (1 - T) / 2 + (1 + T) / 2 cos 2 y = T, y = pi f / 2 F; steps of 2.5e-4 of F
    assert band[0] == pytest.approx(4 / np.pi * np.arcsin(EI), abs=6e-4)
    assert band[1] == pytest.approx(4 / np.pi * np.arcsin(np.sqrt(EI)), abs=6e-4)
    assert band[2] == pytest.approx(2 / np.pi * np.arccos((1 - 3 * EI) / (1 + EI)), abs=6e-4)
    assert band[0] < band[1] < band[2]
    assert zv.delay == pytest.approx(0.5 / F) and zvd.delay == pytest.approx(1 / F) == pytest.approx(ei.delay)


def test_two_modes_are_both_left_at_rest():
    made = shaper_of("zv", [28.8, 39.9], ZETA)
    assert max(made.residual(28.8, ZETA), made.residual(39.9, ZETA)) < 1e-15
    assert len(made.size) == 4


@pytest.mark.quick("zv-jerk_limited", "ei-trapezoid")
@pytest.mark.parametrize("make", [trapezoid, jerk_limited])
@pytest.mark.parametrize("kind", KINDS)
def test_a_shaped_line_takes_the_delay_longer_and_shakes_the_mode_no_more(make, kind):
    made = shaper_of(kind, F, ZETA)
    cells = cells_of([0.1], 0.3, 10.0, 500.0)
    plain, profile = make(cells), shaped(make, cells, made)
    assert profile.times[-1] == pytest.approx(plain.times[-1] + made.delay, abs=1e-15)
    t = np.arange(0, profile.times[-1] + 1e-5, 1e-5)

    def pushed(one):
        at = t + 5e-6  # between the steps of the acceleration, which lsim holds
        return np.where(at < one.phases.times[-1], one.phases.at(one.phases.find(at), at)[2], 0.0)

    left = shaken(t, pushed(profile), F, ZETA) / shaken(t, pushed(plain), F, ZETA)
    # the unshaped one has longer to fade; the steps of 10 us cut the times of the impulses: 2 pi F 10 us = 3e-3
    assert left < {"zv": 3e-3, "zvd": 3e-3, "ei": 1.2 * EI}[kind]


def check_speed_and_acceleration(cells, profile):
    """check_limits of a profile whose acceleration has steps; allowances are the rounding of absolute time."""
    phases, ulp = profile.phases, 4e-16 * profile.times[-1]
    begin, end = phases.times[:-1], phases.times[1:]
    t = (begin[:, None] + (end - begin)[:, None] * np.linspace(0, 1, 9)).ravel()
    _, v, a, _ = phases.at(np.repeat(np.arange(len(begin)), 9), t)
    near = [np.clip(np.searchsorted(profile.times, t + d, "right") - 1, 0, len(cells.length) - 1)
            for d in (-1e3 * ulp, 0, 1e3 * ulp)]  # fmt: skip
    speed, acceleration = (np.max([column[c] for c in near], 0) for column in (cells.speed, cells.acceleration))
    assert (v >= -1e-9 * speed).all()
    assert (v <= speed * (1 + 1e-9) + ulp * acceleration).all()
    assert (np.abs(a) <= acceleration * (1 + 1e-9)).all()
    assert (np.diff(profile.times) >= 0).all()


@pytest.mark.parametrize("make", [trapezoid, jerk_limited])
@pytest.mark.parametrize("seed", range(6))
def test_shaped_profiles_keep_the_limits_of_every_cell(make, seed):
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 40))
    length = 10 ** rng.uniform(-4, -1, n)
    stop = rng.choice(n, rng.integers(0, n), replace=False)
    cells = cells_of(length, rng.uniform(0.01, 0.3, n), rng.uniform(1, 10, n), 200.0, stop=stop)
    profile = shaped(make, cells, shaper_of(KINDS[seed % 3], rng.uniform(20, 200), 0.05))
    if make is jerk_limited:
        check_limits(cells, profile)
    else:
        check_speed_and_acceleration(cells, profile)
    at_stops = profile.times[np.flatnonzero(cells.stop)]
    for side in (-1e-12, 1e-12):
        v = profile.phases.at(profile.phases.find(at_stops[1:-1] + side), at_stops[1:-1] + side)[1]
        assert np.abs(v).max(initial=0.0) < 1e-10  # 10 m/s2 for 1e-12 s, and the rounding of the times


def test_a_cell_of_another_limit_is_kept_from_the_speed_of_its_neighbours():
    """Without eq. (12) the mean runs through the slow cell in front of and behind its time."""
    cells = cells_of([0.05, 0.002, 0.05], [0.3, 0.02, 0.3], 10.0, 500.0)
    made = shaper_of("zvd", 30.0)
    profile = shaped(trapezoid, cells, made)
    t = np.linspace(profile.times[1], profile.times[2], 1000)
    v = profile.phases.at(profile.phases.find(t), t)[1]
    assert v.max() <= 0.02 * (1 + 1e-9)
    one = trapezoid(cells)
    knots = one.phases.times
    v = one.phases.at(one.phases.find(knots), knots)[1]
    late = np.array([np.interp(t - d, knots, v) for d in made.time])
    assert late.max() > 0.02  # the delayed copies of the unwidened profile are elsewhere by then


@pytest.mark.parametrize("profile", ["trapezoid", "jerk_limited"])
@pytest.mark.parametrize("seed", [1, 2])
def test_a_shaped_feed_visits_every_block_in_order_and_rests_at_every_stop(profile, seed):
    path = random_path(seed)
    made = shaper_of("zvd", 35.0, 0.03)
    plain, feed = (Feed(path, LIMITS, None, profile, shaper=s) for s in (None, made))
    moving = feed.extent > 0
    runs = int((feed.cells.stop[:-1] & moving).sum())  # runs that begin with a block of some length
    assert runs > 3
    assert feed.duration >= plain.duration + runs * made.delay * (1 - 1e-9) - 1e-12
    t = np.linspace(0, feed.duration, 20001)
    state = feed.at(t)
    whole = np.concatenate([[0], np.cumsum(feed.extent)])[state.block] + state.u
    assert (np.diff(whole) >= -1e-12).all()
    assert whole[-1] == pytest.approx(feed.extent.sum(), abs=1e-12)
    # the rates are those of the way: differences of fine samples, half a step of the acceleration off
    inside = (state.block[1:] == state.block[:-1]) & (np.diff(t) > 0)
    rate, mean = np.diff(whole)[inside] / np.diff(t)[inside], ((state.ud[1:] + state.ud[:-1]) / 2)[inside]
    np.testing.assert_allclose(rate, mean, atol=np.diff(t).max() * 5.0)


def test_dwells_last_as_long_as_without_a_shaper():
    blocks = [
        Block(Straight((0, 0, 0), (0.1, 0, 0)), feed=0.2),
        Block(Rest((0.1, 0, 0)), dwell=0.5),
        Block(Straight((0.1, 0, 0), (0.1, 0.1, 0)), feed=0.2),
    ]
    path = Path(blocks)
    made = shaper_of("zv", 30.0)
    for profile in ("trapezoid", "jerk_limited"):
        feed = Feed(path, LIMITS, None, profile, shaper=made)
        assert np.diff(feed.times)[1] == pytest.approx(0.5, abs=1e-12)
        assert np.diff(feed.times)[0] == pytest.approx(
            Feed(path, LIMITS, None, profile).times[1] + made.delay, abs=1e-12
        )


def test_the_jerk_time_that_is_a_period_of_the_mode_leaves_it_at_rest():
    """A ramp of the acceleration over one period is the mean over it: jerk = acceleration * frequency."""
    a = 10.0
    still = cells_of([0.4], 1.0, a, a * F)
    other = cells_of([0.4], 1.0, a, 2 * a * F)
    t = np.arange(0, 0.8, 4e-5)

    def left(cells):
        phases = jerk_limited(cells).phases
        at = t + 2e-5
        return shaken(t, np.where(at < phases.times[-1], phases.at(phases.find(at), at)[2], 0.0), F)

    assert left(still) < 1e-3 * a  # a ramp in steps of 40 us, (2 pi F 40 us)^2 / 12 = 1e-5 at each of its eight ends
    assert left(other) > 0.1 * a


def test_every_program_takes_a_shaper_and_its_path_stays(machine):
    points = np.array([[0, 0, 0], [0.05, 0, 0], [0.05, 0.05, 0]])
    plain = Polyline(points=points, feed=0.2)
    program = plain.replace(shaper="zvd", shaper_frequency=F, shaper_damping=ZETA)
    row, before = program.sample(1e-3, machine), plain.sample(1e-3, machine)
    feed = program.plan(machine).feed
    at = feed.times[1]
    assert feed.at(np.array([at])).ud[0] < 1e-12
    assert feed.at(at + np.array([-1e-9, 1e-9])).ud.max() < 1e-8  # 2 m/s2 for 1 ns
    on_x, on_y = np.abs(row.x[:, 1]), np.abs(row.x[:, 0] - 0.05)
    assert np.minimum(on_x, on_y).max() < 1e-15
    assert len(row.x) - len(before.x) == pytest.approx(2 * 2 * HALF / 1e-3, abs=1)
    assert np.abs(row.xdd).max() <= np.abs(before.xdd).max() * (1 + 1e-12)


def test_a_timed_motion_is_shaped_in_every_coordinate(machine):
    motion = Fourier(period=0.5, sine=[[0.02, 0, 0], [-0.01, 0, 0]], cosine=[[0, 0, 0], [0, 0, 0]])
    program = motion.replace(shaper="zv", shaper_frequency=F)
    made = program.shaping()
    row, plain = program.sample(1e-4, machine), motion.plan(machine)
    t = np.arange(len(row.x)) * 1e-4
    for k in (0, 1234, 5000, 5060, len(t) - 1):
        parts = [plain.poses(np.clip([t[k] - late], 0, 0.5))[0][0] for late in made.time]
        np.testing.assert_allclose(row.x[k, :3], sum(s * p for s, p in zip(made.size, parts, strict=True)), atol=1e-15)
    assert program.plan(machine).duration == pytest.approx(plain.duration + made.delay)


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"shaper": "zvd"}, "shaper_frequency: is missing"),
        ({"shaper_frequency": 49.0}, "shaper_frequency: is for a shaper"),
        ({"shaper": "zv", "shaper_frequency": [1.0] * 5}, "needs one to 4 frequencies above 0"),
        ({"shaper": "zv", "shaper_frequency": 0.0}, "must be above 0 Hz"),
    ],
)
def test_what_is_wrong_with_a_shaper_is_said(options, text):
    with pytest.raises(ExperimentError, match=text):
        Line(to=np.array([0.1, 0, 0]), feed=0.1, **options)


def test_a_line_of_uniform_limits_is_not_slowed_by_its_shaper():
    path = chain([(0, 0, 0), (0.1, 0, 0)])
    made = shaper_of("zvd", F)
    plain, feed = Feed(path, LIMITS), Feed(path, LIMITS, shaper=made)
    assert feed.duration == pytest.approx(plain.duration + made.delay, abs=1e-15)


@pytest.mark.full
@pytest.mark.parametrize("profile", ["trapezoid", "jerk_limited"])
def test_a_shaped_feed_within_the_limits_of_the_joints_keeps_them(profile):
    m = gk.load_machine("nist-octahedral")
    limits = {"limits.speed": 0.15, "limits.acceleration": 1.5}
    m = m.replace(**limits)
    way = Polyline(points=np.array([[0, 0, 0], [0.1, 0.02, 0.0], [0.1, 0.1, 0.03]]), feed=0.3, acceleration=5.0)
    program = way.replace(profile=profile, jerk=200.0, shaper="zvd", shaper_frequency=30.0, joint_limits=True)
    row = program.sample(2.5e-4, m)
    assert np.abs(row.qd).max() <= 0.15 * (1 + 1e-6)
    assert np.abs(row.qdd).max() <= 1.5 * (1 + 1e-6)
    assert max(np.abs(row.qd).max() / 0.15, np.abs(row.qdd).max() / 1.5) > 0.5  # and they bind
