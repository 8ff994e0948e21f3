"""Batches: runs side by side are the runs alone, and each fails alone."""

from __future__ import annotations

import csv
import re
import tracemalloc

import numpy as np
import pytest

import gough as gk
from gough.errors import ExperimentError, LogError, WorkspaceError
from gough.simulate.notes import EffortWarning

SHORT = gk.Circle(radius=0.01, feed=0.05, settle=0.05)
LAW = gk.ComputedTorque(bandwidth=16.0)


@pytest.fixture(scope="module")
def nist():
    return gk.load_machine("nist-octahedral")


@pytest.fixture(scope="module")
def plants(nist):
    """Eleven plants: one slab of eight and a rest of three, with payloads and friction of their own."""
    return [
        gk.Plant(
            machine=nist.replace(**{"friction.coulomb": 0.15 + 0.005 * i, "drive.inertia": 3e-3 - 5e-5 * i}),
            payload=None if i == 4 else 5.0 * (i + 1),
            wrench=[0, 0, 3.0 * i, 0, 0, 0],
        )
        for i in range(11)
    ]


@pytest.fixture(scope="module")
def batch(nist, plants):
    return gk.simulate(nist, LAW, SHORT, plant=plants, seed=5)


def assert_same(a, b):
    assert set(a) == set(b)
    for name in a:
        np.testing.assert_array_equal(a[name], b[name], err_msg=name)
    assert a.metrics == b.metrics and (a.status, a.reason) == (b.status, b.reason)


def test_one_lane_gives_the_single_run_to_the_last_bit(nist, plants):
    """W = 1 is the same machine code (KERNEL.md), so nothing may differ: rows, metrics, reversals."""
    runs = gk.simulate(nist, LAW, SHORT, plant=plants[3:6], lanes=1)
    for i, plant in enumerate(plants[3:6]):
        alone = gk.simulate(nist, LAW, SHORT, plant=plant)
        assert_same(runs.run(i), alone)
        assert runs.run(i).info["reversals"] == alone.info["reversals"]
        assert runs.run(i).info["plant"] == alone.info["plant"]


@pytest.mark.quick("4")
@pytest.mark.parametrize("lanes", [2, 4, 8])
def test_lanes_give_the_single_run_to_rounding(nist, lanes):
    """KERNEL.md: 1e-12 relative a call between W = 8 and W = 1.

    Without the encoder's rounding, which makes a count of a last digit, the loop is smooth and stable: a disturbance of
    every sample's states by 1e-12 of 1.7 m of strut is no more than that at the tool, times the gain of J^-1 (below 3)
    and the samples the loop needs to forget it (16 Hz: some 20).
    """
    smooth = nist.replace(**{"drive.encoder": None})
    plants = [gk.Plant(machine=smooth, payload=20.0 + i) for i in range(3)]
    runs = gk.simulate(smooth, LAW, SHORT, plant=plants, lanes=lanes)
    alone = gk.simulate(smooth, LAW, SHORT, plant=plants[1])
    one = runs.run(1)
    assert np.abs(one["x"] - alone["x"]).max() < 1e-12 * 1.7 * 3 * 20
    assert np.abs(one["q_m"] - alone["q_m"]).max() < 1e-12 * 1.7 * 20
    assert one.metrics["contour_error"]["max"] == pytest.approx(alone.metrics["contour_error"]["max"], abs=1.1e-10)


@pytest.mark.full
def test_no_bit_of_a_run_depends_on_its_neighbours_or_its_place(nist, plants, batch):
    noisy = [plant.replace(**{"machine.drive.noise": 1e-7}) for plant in plants]
    whole = gk.simulate(nist, LAW, SHORT, plant=noisy, seed=list(range(11)))
    for part in ([2, 9], [10], [9, 8, 7, 6, 5, 4, 3, 2, 1]):
        some = gk.simulate(nist, LAW, SHORT, plant=[noisy[i] for i in part], seed=part)
        for place, i in enumerate(part):
            assert_same(some.run(place), whole.run(i))
    assert_same(gk.simulate(nist, LAW, SHORT, plant=plants[:9], seed=5).run(8), batch.run(8))


@pytest.mark.full
def test_metrics_without_rows_are_those_with_rows(nist, plants, batch):
    bare = gk.simulate(nist, LAW, SHORT, plant=plants, seed=5, keep="metrics")
    assert len(bare) == 0 and "x" not in bare
    for i in range(11):
        assert bare.run(i).metrics == batch.run(i).metrics
        assert bare.run(i).info["plant"] == batch.run(i).info["plant"]
    thin = gk.simulate(nist, LAW, SHORT, plant=plants, seed=5, log_every=7, signals=["x", "q_r"])
    np.testing.assert_array_equal(thin["x"], batch["x"][::7])
    np.testing.assert_array_equal(thin["q_r"], batch["q_r"][::7])
    assert thin.run(2).metrics == batch.run(2).metrics


@pytest.mark.full
def test_forces_in_the_joints_are_logged_of_batches_too(nist, plants):
    """Asked for by `signals`, with dimensions of their own behind the run."""
    names = ["plant.reaction", "plant.normal_force", "x"]
    runs = gk.simulate(nist, LAW, SHORT, plant=plants[:3], signals=names, lanes=1)
    assert runs["plant.reaction"].shape == (len(runs), 3, 6, 3)
    assert_same(runs.run(2), gk.simulate(nist, LAW, SHORT, plant=plants[2], signals=names))


@pytest.mark.full
def test_metrics_of_a_batch_are_those_of_its_rows(batch):
    counted = batch["counted"] == 1
    worst = batch["contour_error"][counted].max(0)
    np.testing.assert_array_equal(gk.measure(batch).contour_error["max"], worst)
    np.testing.assert_array_equal(gk.measure(batch).strut_force["peak"], np.abs(batch["u"]).max((0, 2)))


@pytest.mark.full
def test_memory_without_rows_grows_neither_with_the_program_nor_much_with_the_runs(nist):
    """Flat: three times as long, the same peak, but for the kernel's own chunk; and some kB a run."""

    def peak(turns, count):
        plants = [gk.Plant(machine=nist, payload=1.0 + i) for i in range(count)]
        program = gk.Circle(radius=0.05, feed=0.2, turns=turns)
        gk.simulate(nist, LAW, program, plant=plants[:1], keep="metrics", substeps=4)
        tracemalloc.start()
        gk.simulate(nist, LAW, program, plant=plants, keep="metrics", substeps=4)
        top = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        return top

    # 3.4 s and 9.7 s, two and five chunks; rows of the second would be 9 700 x 8 x 0.7 kB = 54 MB
    short, long = peak(2, 8), peak(6, 8)
    assert long < short + 1e6
    # states and parameters in the kernel 6 kB, an accumulator with 0.4 s of contour error 8 kB, the dicts of the log
    assert peak(2, 16) < short + 8 * 40e3


@pytest.mark.full
def test_noise_of_runs_differs_with_one_seed_and_follows_the_seeds_given(nist):
    noisy = nist.replace(**{"drive.noise": 1e-6})
    one = gk.simulate(noisy, LAW, SHORT, plant=[noisy] * 3, seed=7)
    assert not np.array_equal(one["q_m"][:, 0], one["q_m"][:, 1])
    each = gk.simulate(noisy, LAW, SHORT, seed=[7, 8, 7])
    assert_same(each.run(0), each.run(2))
    assert_same(each.run(0), one.run(0))  # run 0 of one seed is the single run of that seed
    assert not np.array_equal(each["q_m"][:, 0], each["q_m"][:, 1])
    again = gk.simulate(noisy, LAW, SHORT, seed=np.array([7, 8, 7]))  # S10
    for i in range(3):
        assert_same(again.run(i), each.run(i))
    assert [run["seed"] for run in each.runs] == [7, 8, 7]


@pytest.mark.full
def test_laws_that_differ_in_numbers_run_together(nist):
    laws = [gk.PID(bandwidth=f) for f in (6.0, 9.0, 12.0)]
    runs = gk.simulate(nist, laws, SHORT, lanes=1, labels=["slow", "middle", "quick"])
    for label, law in zip(("slow", "middle", "quick"), laws, strict=True):
        assert_same(runs.run(label), gk.simulate(nist, law, SHORT))
        assert runs.run(label).info["controller"] == gk.simulate(nist, law, SHORT).info["controller"]
    error = gk.measure(runs).contour_error["rms"]
    assert error[0] > error[1] > error[2], "more bandwidth, less error"


@pytest.mark.full
def test_plants_that_need_other_sub_steps_are_stepped_as_alone(nist):
    """Their bristles' stiffness asks for 5 and 12 sub-steps; each is the single run, to the last bit."""
    plants = [nist, nist.replace(**{"friction.stiffness": 4e9}), nist]
    runs = gk.simulate(nist, gk.PID(bandwidth=12.0), SHORT, plant=plants, lanes=1)
    alone = [gk.simulate(nist, gk.PID(bandwidth=12.0), SHORT, plant=plant) for plant in plants]
    steps = [log.info["run"]["substeps"] for log in alone]
    assert steps[0] != steps[1], "otherwise the test shows nothing"
    for i in range(3):
        assert_same(runs.run(i), alone[i])
    assert runs.info["run"]["substeps"] == sorted(set(steps))


@pytest.mark.full
def test_a_run_that_fails_ends_alone(nist):
    """A push of 40 kN moves the tool until a strut is at its end; the neighbours do not notice."""
    law = gk.PID(bandwidth=12.0)
    free = nist.replace(**{"drive.torque_limit": 30.0})
    weak = nist.replace(**{"drive.torque_limit": 1.0})
    plants = [free, weak, free.replace(**{"platform.mass": 300.0})]
    with pytest.warns(EffortWarning, match="in run 1, .* %"):
        runs = gk.simulate(nist, law, SHORT, plant=plants, lanes=1)
    with pytest.warns(EffortWarning):
        alone = [gk.simulate(nist, law, SHORT, plant=plant) for plant in plants]
    assert alone[1].failed and not alone[0].failed
    for i in range(3):
        assert_same(runs.run(i), alone[i])
    assert runs.failed and runs.reason.startswith("1 of 3 runs; run 1: ") and alone[1].reason in runs.reason
    assert runs["failed"].tolist() == [0, 1, 0]
    end = len(alone[1])
    assert np.isnan(runs["x"][end:, 1]).all() and np.isfinite(runs["x"][:, [0, 2]]).all()
    assert (runs["saturated"][end:, 1] == 0).all()
    with pytest.warns(EffortWarning), pytest.raises(WorkspaceError) as caught:
        gk.simulate(nist, law, SHORT, plant=plants, on_fail="raise")
    assert caught.value.log.failed


def test_a_program_out_of_reach_ends_all_runs_at_that_sample(nist):
    far = gk.Line(to=[0.6, 0, 0], feed=0.5)
    runs = gk.simulate(nist, gk.PID(bandwidth=12.0), far, plant=[nist] * 2, lanes=1)
    alone = gk.simulate(nist, gk.PID(bandwidth=12.0), far)
    for i in range(2):
        assert_same(runs.run(i), alone)
    assert runs["failed"].tolist() == [1, 1]


def test_what_all_runs_share_is_kept_once(batch):
    dims = {name: batch.dataset[name].dims for name in batch}
    assert dims["q_r"] == ("t", "joint") and dims["s_r"] == ("t",) and dims["q"] == ("t", "run", "joint")
    assert dims["metrics.contour_error.max"] == ("run",) == dims["failed"]
    assert batch.batch and not batch.run(0).batch


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"plant": []}, r"^plant: the list is empty: a batch needs a run"),
        ({"plant": [None, 3]}, r"^plant.1: must be a Plant, got 3"),
        ({"plant": [None] * 2, "seed": [1, 2, 3]}, r"equally many runs, got 2 of plant, 3 of seed"),
        ({"seed": [1, -2]}, r"seed: .*-2"),
        ({"seed": [1, 2], "labels": ["a"]}, r"^labels: 2 labels are needed, got 1"),
        ({"seed": [1, 2], "labels": ["a", "a"]}, r"^labels: every run needs a label of its own, got 'a'"),
        ({"seed": [1, 2], "keep": "nothing"}, r'keep must be "rows" or "metrics", got \'nothing\''),
        ({"seed": [1, 2], "lanes": 3}, r'lanes must be 1, 2, 4, 8 or "auto", got 3'),
        ({"keep": "metrics"}, r'keep="metrics" is for batches; give a list'),
        ({"labels": ["a"]}, r"labels is for batches; give a list"),
        ({"controller": [gk.PID(bandwidth=9.0), LAW]}, r"^controller.1: .* got ComputedTorque; run 0 has PID"),
        (
            {"controller": [gk.ComputedTorque(poles=[1.0, 2, 3]), LAW]},
            r"^controller.1.bandwidth: runs of a batch may differ in numbers only, got a number; run 0 has none",
        ),
        ({"seed": range(30), "program": gk.Circle(radius=0.05, feed=1e-3)}, r'^run.log_every: 30 .* keep="metrics"'),
    ],
)  # fmt: skip
def test_what_does_not_fit_together_is_said(nist, arguments, message):
    whole = {"machine": nist, "controller": LAW, "program": SHORT} | arguments
    with pytest.raises(ExperimentError, match=message):
        gk.simulate(**whole)


def test_plants_of_another_structure_are_refused_by_the_key_that_differs(nist):
    with pytest.raises(ExperimentError, match=r"^plant.1.friction: .* got none; run 0 has \w+"):
        gk.simulate(nist, LAW, SHORT, plant=[nist, nist.replace(friction=None)])
    with pytest.raises(ExperimentError, match=r"^plant.2.drive.noise: .* got a number; run 0 has none"):
        gk.simulate(nist, LAW, SHORT, plant=[nist, nist, nist.replace(**{"drive.noise": 1e-7})])


# -- the log of a batch -----------------------------------------------------------------------------------------------


@pytest.mark.full
def test_a_batch_goes_to_a_file_and_back(batch, tmp_path):
    read = gk.Log.load(batch.save(tmp_path / "batch.nc"))
    assert read.dataset.identical(batch.dataset)
    assert_same(read.run(3), batch.run(3))


def test_a_batch_prints_runs_ranges_and_the_worst(batch):
    text = repr(batch)
    worst = int(np.argmax(gk.measure(batch).contour_error["max"]))
    assert text.startswith("<Log> nist-octahedral · computed_torque\n  11 runs, ")
    assert f"largest in run {worst}" in text and "one run: log.run(0)" in text
    assert "11 runs" in batch._repr_html_()


@pytest.mark.full
def test_measure_of_a_batch_prints_a_line_a_run_and_the_worst_of_many(nist, batch):
    lines = repr(gk.measure(batch)).splitlines()
    assert lines[0].split("  ")[0] == "run" and "contour max" in lines[0] and "force peak" in lines[0]
    assert [line.split()[0] for line in lines[1:]] == [str(i) for i in range(11)]
    many = gk.measure(gk.simulate(nist, LAW, SHORT, seed=list(range(25)), keep="metrics"))
    lines = repr(many).splitlines()
    assert len(lines) == 1 + 20 and lines[-1].startswith("median of 25  ")


@pytest.mark.full
def test_csv_of_a_batch_has_its_runs_below_one_another(batch, tmp_path):
    lines = batch.to_csv(tmp_path / "b.csv").read_text().splitlines()
    assert lines[1].startswith("run [1],t [s],")
    assert len(lines) == 2 + 11 * len(batch)
    found = dict(zip(*csv.reader([lines[1], lines[2 + 4 * len(batch) + 17]]), strict=True))
    assert found["run [1]"] == "4" and float(found["q.2 [m]"]) == batch["q"][17, 4, 1]
    bare = gk.Log(batch.dataset.drop_dims("t").assign_coords(t=("t", np.zeros(0))))
    lines = bare.to_csv(tmp_path / "m.csv").read_text().splitlines()
    assert len(lines) == 2 + 11 and "metrics.contour_error.max [m]" in lines[1]


def test_a_run_that_is_not_there_is_said(batch):
    for which, message in (
        (11, r"no such run, got 11 \(limit 11 runs\)"),
        ("12", "no such run, got '12'"),
        (True, "by its number or its label, got True"),
    ):
        with pytest.raises(LogError, match=message):
            batch.run(which)
    with pytest.raises(LogError, match="the log holds one run"):
        batch.run(0).run(0)


def test_reports_refuse_a_batch_and_say_how_to_pick_a_run(batch, tmp_path):
    with pytest.raises(LogError, match=r"run: holds a batch of runs; pick one: log.run\(0\)"):
        gk.report(batch, tmp_path)
    assert batch.run(2).plot.contour().lines


@pytest.mark.parametrize(
    ("laws", "said"),
    [
        (
            [gk.ComputedTorque(bandwidth=20.0), gk.ComputedTorque(bandwidth=20.0, period=2e-3)],
            "controller.1.period: laws of a batch must tick together, got 2 ms; run 0 has 1 ms; run those of one",
        ),
        (
            [gk.DesiredTorqueAdaptive(pole=300.0, model_period=p) for p in (2e-3, 2e-3, 3e-3)],
            "controller.2.model_period: runs of a batch may differ in numbers only, got 0.003; run 0 has 0.002;",
        ),
    ],
)
def test_laws_of_a_batch_tick_together_or_are_refused_by_name(laws, said):
    machine, program = gk.load_machine("eth-hexaglide"), gk.Circle(radius=0.015, feed=0.1)
    with pytest.raises(ExperimentError, match=re.escape(said)):
        gk.simulate(machine, laws, program)
