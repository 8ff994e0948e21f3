"""Ticks, lanes, chunks and stops: machine code against the interpreter, and against itself."""

from concurrent.futures import ThreadPoolExecutor

import casadi as ca
import numpy as np
import pytest

from gough.errors import InputError
from gough.kernel import Schedule, Signal, Task, compile
from gough.kernel.noise import run_key

from .examples import pendulum, reference

GAINS = np.array(
    [[10, 1], [20, 1], [30, 0.1], [100, 0.1], [5, 3], [50, 2], [1, 1], [15, 0.5], [25, 1], [12, 2], [40, 1]]
)


def simulate(schedule, n=200, lanes=1, native=True, chunks=None, gains=GAINS, seed=3, first_run=0, start=(0.1, 0.0)):
    simulation = compile(schedule, lanes, native=native).start({"p": gains}, {"x": start}, seed, len(gains), first_run)
    table, done, rows = reference(n)["r"], 0, []
    for chunk in chunks or [n]:
        rows.append(simulation.advance(chunk, {"r": table[done : done + chunk]}))
        done += chunk
    return simulation, np.concatenate(rows)


def test_one_lane_agrees_with_the_interpreter():
    _, rows = simulate(pendulum(every=2))
    _, expected = simulate(pendulum(every=2), native=False)
    # the same operations in another order of sharing: 1e-12 a call, the pendulum under PD magnifies nothing
    np.testing.assert_allclose(rows, expected, rtol=0, atol=1e-12 * np.abs(expected).max())


@pytest.mark.parametrize("lanes", [2, 4, 8])
def test_lanes_agree_with_one_lane(lanes):
    _, rows = simulate(pendulum(every=3), lanes=lanes)
    _, expected = simulate(pendulum(every=3))
    np.testing.assert_allclose(rows, expected, rtol=0, atol=1e-12 * np.abs(expected).max())


@pytest.mark.parametrize("lanes", [1, 8])
def test_the_log_shows_a_tick_as_numpy_computes_it(lanes):
    """A second derivation of the order of a tick: sense, control, log, then the sub-steps."""
    simulation, rows = simulate(pendulum(substeps=4), n=30, lanes=lanes, gains=GAINS[:1])
    at = simulation.kernel.columns
    x, h = np.array([0.1, 0.0]), 1e-3
    for row, r in zip(rows[:, 0], reference(30)["r"][:, 0], strict=True):
        np.testing.assert_allclose(row[at["x"]], x, rtol=1e-12, atol=1e-13)
        u = GAINS[0, 0] * (r - x[0]) - GAINS[0, 1] * x[1] + 0.1 * row[at["w"]][2]
        assert row[at["u"]][0] == pytest.approx(u, rel=1e-12, abs=1e-12) and row[at["r"]][0] == r
        for _ in range(4):
            half = x + h / 2 * np.array([x[1], u - np.sin(x[0])])
            x = x + h * np.array([half[1], u - np.sin(half[0])])
    np.testing.assert_allclose(simulation.state("x")[0], x, rtol=1e-12)


@pytest.mark.parametrize("lanes", [1, 8])
def test_chunks_of_any_size_give_the_same_bits(lanes):
    schedule = pendulum(every=3)
    _, whole = simulate(schedule, lanes=lanes)
    for chunks in ([1] * 200, [7, 93, 100], [0, 199, 0, 1]):
        simulation, parts = simulate(schedule, lanes=lanes, chunks=chunks)
        assert np.array_equal(whole, parts) and simulation.tick == 200


def test_the_bits_of_a_run_depend_neither_on_neighbours_nor_on_grouping_nor_on_padding():
    schedule = pendulum(limit=1.3)
    _, together = simulate(schedule, lanes=8)
    assert np.isnan(together).any(), "a neighbour that stops is part of the test"
    for first in range(len(GAINS)):
        for count in (1, 3):
            _, alone = simulate(schedule, lanes=8, gains=GAINS[first : first + count], first_run=first)
            part = together[:, first : first + count]
            ticks = len(alone)  # the rows end where the last run does
            assert np.array_equal(alone, part[:ticks], equal_nan=True) and np.isnan(part[ticks:]).all()


def test_a_neighbour_with_infinities_changes_no_bit():
    x = ca.SX.sym("x")
    grow = ca.Function("grow", [x], [ca.exp(x * x) + ca.sin(x) + ca.tanh(x) + ca.fabs(x) ** 0.3])
    schedule = Schedule([Signal("x", 1, "state"), Signal("y", 1, "state")], Task("t", grow, "x", "y"))
    kernel = compile(schedule, lanes=8)
    calm = np.linspace(-2, 2, 8)[:, None]
    wild = calm.copy()
    wild[[1, 4, 6]] = [[1e10], [-1e300], [1e308]]
    results = []
    for start in (calm, wild):
        simulation = kernel.start(states={"x": start, "y": [0.0]}, runs=8)
        simulation.advance(1)
        results.append(simulation.state("y"))
    same = [0, 2, 3, 5, 7]
    assert np.array_equal(results[0][same], results[1][same])


def test_the_same_seed_gives_the_same_bits_and_another_seed_others():
    _, first = simulate(pendulum(), seed=5)
    _, second = simulate(pendulum(), seed=5)
    _, other = simulate(pendulum(), seed=6)
    assert np.array_equal(first, second) and not np.array_equal(first, other)


@pytest.mark.parametrize("lanes,native", [(1, True), (8, True), (1, False)])
def test_tasks_tick_at_their_own_periods_and_hold_between(lanes, native):
    k, p = ca.SX.sym("k"), ca.SX.sym("p")
    clock, take = ca.Function("clock", [k], [k + 1]), ca.Function("take", [k, p], [k + p])
    signals = [
        Signal("k", 1, "state"),
        Signal("p", 1, "parameter"),
        Signal("two", 1, "wire"),
        Signal("five", 1, "wire"),
    ]
    tasks = [
        Task("second", take, ("k", "p"), "two", 2),
        Task("fifth", take, ("k", "p"), "five", 5),
        Task("clock", clock, "k", "k"),
    ]
    kernel = compile(Schedule(signals, tasks, log=("two", "five")), lanes, native=native)
    simulation = kernel.start({"p": [100.0]}, {"k": [0.0]})
    rows = np.concatenate([simulation.advance(n) for n in (3, 4, 13)])[:, 0]
    ticks = np.arange(20)
    assert np.array_equal(rows[:, kernel.columns["two"]][:, 0], 100 + ticks // 2 * 2)
    assert np.array_equal(rows[:, kernel.columns["five"]][:, 0], 100 + ticks // 5 * 5)


@pytest.mark.parametrize("lanes,native", [(1, True), (8, True), (1, False)])
def test_a_run_that_reaches_a_limit_keeps_its_last_good_state_and_the_others_go_on(lanes, native):
    simulation, rows = simulate(pendulum(limit=1.3), lanes=lanes, native=native)
    free, all_rows = simulate(pendulum(limit=100.0), lanes=lanes, native=native)
    at = simulation.kernel.columns["x"]
    stopped = [run for run, stop in enumerate(simulation.stops) if stop]
    assert 0 < len(stopped) < len(GAINS) and list(simulation.alive) == [stop is None for stop in simulation.stops]
    for run, stop in enumerate(simulation.stops):
        if stop is None:
            assert np.array_equal(rows[:, run], all_rows[:, run]), "a neighbour's stop changes no bit"
            continue
        assert (stop.reason, stop.signal, stop.index, stop.label) == ("limit", "limits", 0, "angle within reach")
        assert stop.value < 0 and stop.time == pytest.approx(4e-3 * stop.tick)
        # row k + 1 holds the state after tick k; tick `stop.tick` failed, so the state it began with remains
        assert np.array_equal(simulation.state("x")[run], all_rows[stop.tick, run, at])
        assert np.abs(all_rows[stop.tick, run, at][0]) <= 1.3 < np.abs(all_rows[stop.tick + 1, run, at][0])
        assert (
            np.array_equal(rows[: stop.tick, run], all_rows[: stop.tick, run])
            and np.isnan(rows[stop.tick :, run]).all()
        )


@pytest.mark.parametrize("lanes", [1, 8])
def test_stops_do_not_depend_on_chunks(lanes):
    whole, rows = simulate(pendulum(limit=1.3), lanes=lanes)
    parts, pieces = simulate(pendulum(limit=1.3), lanes=lanes, chunks=[13] * 15 + [5])
    assert np.array_equal(rows, pieces, equal_nan=True)
    assert whole.stops == parts.stops and np.array_equal(whole.state("x"), parts.state("x"))


def test_the_rows_end_where_the_last_run_does():
    simulation, rows = simulate(pendulum(limit=1.3), lanes=8, gains=GAINS[[1, 3]])
    last = max(stop.tick for stop in simulation.stops)
    assert len(rows) == last == simulation.tick and not simulation.alive.any()
    assert simulation.advance(10, reference(10)).shape == (0, 2, simulation.kernel.width)


def poisoned(clip: bool) -> Schedule:
    """A torque that becomes NaN at tick 5, through a limiter that lets NaN through, or logged as it is."""
    k, u = ca.SX.sym("k"), ca.SX.sym("u")
    torque = ca.sqrt(4.5 - k)
    limited = ca.if_else(torque > 1, 1, ca.if_else(torque < -1, -1, torque))
    signals = [
        Signal("k", 1, "state"),
        Signal("v", 1, "state", ("speed",)),
        Signal("u", 1, "wire", ("torque of strut 1",)),
    ]
    tasks = [
        Task("law", ca.Function("law", [k], [limited if clip else torque]), "k", "u"),
        Task("clock", ca.Function("clock", [k], [k + 1]), "k", "k"),
    ]
    step = Task("step", ca.Function("step", [k, u], [k + 0.1 * u]), ("v", "u"), "v")
    return Schedule(signals, tasks, step, log=("k",) if clip else ("k", "u"))


@pytest.mark.parametrize("lanes,native", [(1, True), (8, True), (1, False)])
def test_nan_stops_a_run_even_through_a_torque_limit(lanes, native):
    simulation = compile(poisoned(clip=True), lanes, native=native).start(states={"k": [0.0], "v": [0.0]})
    rows = simulation.advance(20)
    (stop,) = simulation.stops
    assert (stop.tick, stop.reason, stop.signal, stop.label) == (5, "not finite", "v", "speed") and np.isnan(stop.value)
    assert len(rows) == 5 and np.isfinite(rows).all()
    assert simulation.state("k")[0, 0] == 5 and np.isfinite(simulation.state("v")).all()


@pytest.mark.parametrize("lanes,native", [(1, True), (8, True), (1, False)])
def test_a_logged_value_that_is_not_finite_is_named_as_the_cause(lanes, native):
    simulation = compile(poisoned(clip=False), lanes, native=native).start(states={"k": [0.0], "v": [0.0]})
    assert len(simulation.advance(20)) == 5
    assert (simulation.stops[0].signal, simulation.stops[0].label) == ("u", "torque of strut 1")


def test_a_limit_that_is_nan_is_not_kept():
    x = ca.SX.sym("x")
    schedule = Schedule(
        [Signal("x", 1, "state"), Signal("limits", 2, "wire", ("never", "root"))],
        Task("t", ca.Function("t", [x], [x - 1]), "x", "x"),
        limits=Task("l", ca.Function("l", [x], [ca.vertcat(1, ca.sqrt(x))]), "x", "limits"),
    )
    for lanes, native in ((1, True), (8, True), (1, False)):
        simulation = compile(schedule, lanes, native=native).start(states={"x": [3.0]})
        simulation.advance(10)
        stop = simulation.stops[0]
        assert (stop.tick, stop.reason, stop.index, stop.label) == (3, "limit", 1, "root") and np.isnan(stop.value)
        assert simulation.state("x")[0, 0] == 0.0


def test_several_functions_make_a_substep_and_equal_ones_are_compiled_once():
    x, v = ca.SX.sym("x"), ca.SX.sym("v")
    add = ca.Function("add", [x, v], [x + v])
    schedule = Schedule(
        [Signal("x", 1, "state"), Signal("v", 1, "parameter")],
        (),
        (Task("first", add, ("x", "v"), "x"), Task("second", add, ("x", "v"), "x")),
        substeps=3,
    )
    simulation = compile(schedule, lanes=8).start({"v": np.arange(8.0)[:, None]}, {"x": [0.0]}, runs=8)
    simulation.advance(10)
    assert np.array_equal(simulation.state("x")[:, 0], 60 * np.arange(8.0))
    assert simulation.kernel.operations == 6


def test_a_task_may_exchange_the_signals_it_reads():
    x, y = ca.SX.sym("x", 2), ca.SX.sym("y", 2)
    swap = Task("swap", ca.Function("swap", [x, y], [y, x]), ("x", "y"), ("x", "y"))
    for lanes, native in ((1, True), (8, True), (1, False)):
        kernel = compile(Schedule([Signal("x", 2, "state"), Signal("y", 2, "state")], swap), lanes, native=native)
        simulation = kernel.start(states={"x": [1.0, 2.0], "y": [3.0, 4.0]})
        simulation.advance(1)
        assert simulation.state("x").tolist() == [[3.0, 4.0]] and simulation.state("y").tolist() == [[1.0, 2.0]]


def test_wrong_values_are_named_before_the_first_tick():
    kernel = compile(pendulum())
    good = {"p": [1.0, 1.0]}, {"x": [0.0, 0.0]}
    for parameters, states, message in (
        ({}, good[1], "a value is missing for parameter p"),
        ({"p": [1.0, 1.0], "q": 1.0}, good[1], "no parameter is called 'q'"),
        ({"p": [1.0]}, good[1], r"parameter p: must have shape \(2,\) or \(1, 2\), got \(1,\)"),
        ({"p": [1.0, np.nan]}, good[1], "parameter p: must not be NaN, got nan for p\\[1\\] of run 0"),
        (good[0], {"x": [0.0, np.inf]}, "state x: must be finite, got inf for speed of run 0"),
        (good[0], {"x": "home"}, "state x: must be numbers"),
    ):
        with pytest.raises(InputError, match=message):
            kernel.start(parameters, states)
    simulation = kernel.start(*good)
    with pytest.raises(InputError, match=r"input r: the table must have shape \(3, 1\), got \(4, 1\)"):
        simulation.advance(3, reference(4))
    with pytest.raises(InputError, match="input r: the table must be finite, got nan in row 1, r"):
        simulation.advance(3, {"r": [0.0, np.nan, 0.0]})
    with pytest.raises(InputError, match="no state is called 'y'"):
        simulation.state("y")
    with pytest.raises(InputError, match="seed must be"):
        kernel.start(*good, seed=-1)
    with pytest.raises(InputError, match="lanes must be"):
        compile(pendulum(), lanes=3)


def test_rows_can_be_written_into_memory_of_the_caller():
    simulation, rows = simulate(pendulum(), n=50, lanes=8)
    again = simulation.kernel.start({"p": GAINS}, {"x": [0.1, 0.0]}, 3, len(GAINS))
    memory = np.empty((64, 16, again.kernel.width))
    assert np.array_equal(again.advance(50, reference(50), out=memory), rows)
    assert np.array_equal(memory[:50, : len(GAINS)], rows)
    with pytest.raises(InputError, match="out must be"):
        again.advance(50, reference(50), out=memory[:, :3])


def test_an_interrupted_chunk_is_not_continued():
    calls = []

    def law(x, r, p, w):
        calls.append(1)
        if len(calls) == 3:
            raise KeyboardInterrupt
        return r - x[:1]

    simulation = compile(pendulum(control=law), native=False).start({"p": GAINS[:1]}, {"x": [0.0, 0.0]})
    with pytest.raises(KeyboardInterrupt):
        simulation.advance(10, reference(10))
    with pytest.raises(InputError, match="left in the middle of a chunk"):
        simulation.advance(10, reference(10))
    with pytest.raises(InputError, match="left in the middle of a chunk"):
        simulation.state("x")


@pytest.mark.parametrize("lanes,native", [(8, True), (1, False)])
def test_threads_share_a_kernel(lanes, native):
    kernel = compile(pendulum(), lanes, native=native)

    def run(first):
        simulation = kernel.start({"p": GAINS[first]}, {"x": [0.1, 0.0]}, seed=first)
        return np.concatenate([simulation.advance(20, {"r": part}) for part in np.split(reference(100)["r"], 5)])

    with ThreadPoolExecutor(4) as pool:
        together = list(pool.map(run, range(len(GAINS))))
    assert all(np.array_equal(rows, run(first)) for first, rows in enumerate(together))


def test_an_exact_function_and_a_fused_one_share_a_kernel():
    """Both call sin, exp and fmod: the exact one lane by lane, the other by vectors."""
    x = ca.SX.sym("x")
    smooth = ca.sin(x) + ca.exp(-x * x) + ca.fmod(x, 0.3)
    exact = ca.Function("exact", [x], [ca.erfinv(x / 2) + smooth])
    signals = [Signal("x", 1, "parameter"), Signal("y", 1, "wire"), Signal("z", 1, "wire")]
    tasks = [Task("exact", exact, "x", "y"), Task("fused", ca.Function("fused", [x], [smooth]), "x", "z")]
    values = np.linspace(-1.9, 1.9, 8)[:, None]
    rows = {}
    for lanes in (1, 8):
        kernel = compile(Schedule(signals, tasks, log=("y", "z")), lanes)
        rows[lanes] = kernel.start({"x": values}, runs=8).advance(1)[0]
    at = kernel.columns
    assert np.array_equal(rows[1][:, at["y"]], rows[8][:, at["y"]])
    np.testing.assert_allclose(rows[8][:, at["z"]], rows[1][:, at["z"]], rtol=1e-12, atol=1e-15)


def test_keys_give_runs_the_noise_of_any_seed_and_number():
    """A batch put together in any order: run i of seed 5, and run 0 of seed 9, in one group."""
    kernel = compile(pendulum(), lanes=4)

    def rows(**options):
        simulation = kernel.start({"p": GAINS[0]}, {"x": (0.1, 0.0)}, **options)
        return simulation.advance(50, {"r": reference(50)["r"]})

    keys = [run_key(5, 2), run_key(9, 0), run_key(5, 0)]
    mixed = rows(runs=3, keys=keys)
    assert np.array_equal(mixed[:, 0], rows(runs=3, seed=5)[:, 2])
    assert np.array_equal(mixed[:, 1], rows(seed=9)[:, 0])
    assert np.array_equal(mixed[:, 2], rows(seed=5)[:, 0])
    with pytest.raises(InputError, match="3 keys of the noise are needed, got 2"):
        rows(runs=3, keys=keys[:2])
