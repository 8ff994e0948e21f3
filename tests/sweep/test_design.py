"""Designs: which runs there are, and that more of them go on where fewer ended."""

from __future__ import annotations

import numpy as np
import pytest

from gough.sweep.design import design_of
from gough.sweep.jobs import batches_of, experiment_key, rows_of
from gough.sweep.settings import Setter

BOTH = '"plant.payload" = "uniform(1, 40) kg", "controller.bandwidth" = ["8 Hz", "9 Hz"], "run.period" = ["1 ms"]'


def test_every_machine_is_drawn_once_and_run_at_every_point_of_the_grid(experiment):
    design = design_of(experiment(BOTH, "runs = 3"))
    runs = list(design)
    assert len(design) == len(runs) == 6
    assert [run.settings["controller.bandwidth"] for run in runs] == ["8 Hz", "9 Hz"] * 3
    assert [run.settings["plant.payload"] for run in runs[::2]] == [run.settings["plant.payload"] for run in runs[1::2]]
    assert [run.settings["run.seed"] for run in runs] == [0, 0, 1, 1, 2, 2]


def test_the_last_list_of_a_grid_runs_fastest(experiment):
    design = design_of(experiment('"run.seed" = [1, 2], "controller.bandwidth" = ["8 Hz", "9 Hz"]'))
    assert design.method == "grid" and design.draws == 1
    assert [tuple(run.settings.values()) for run in design] == [(1, "8 Hz"), (1, "9 Hz"), (2, "8 Hz"), (2, "9 Hz")]


@pytest.mark.parametrize("method", ["random", "sobol"])
def test_more_draws_begin_with_those_of_fewer(experiment, method):
    few = design_of(experiment(BOTH, f'method = "{method}"\nruns = 13'))
    many = design_of(experiment(BOTH, f'method = "{method}"\nruns = 40'))
    assert many.machines()[:13] == few.machines() and many.machines(13, 20) == many.machines()[13:20]
    assert design_of(experiment(BOTH, f'method = "{method}"\nruns = 13\nseed = 1')).machines() != few.machines()


def test_sobol_numbers_fill_the_range_more_evenly_than_chance(experiment):
    """Of 64 points of a scrambled Sobol sequence each 64th of the range has exactly one, in every factor."""
    vary = '"plant.payload" = "uniform(1, 40) kg", "plant.friction.coulomb" = "uniform(0.1, 1.0) x"'
    design = design_of(experiment(vary, 'method = "sobol"\nruns = 64'))
    u = design.quantiles(0, 64)
    assert (np.sort(np.floor(64 * u), axis=0) == np.arange(64)[:, None]).all()


def test_what_a_design_says_of_itself_describes_it(experiment, written):
    import tomli_w

    from gough.experiment import load_experiment

    base = experiment(BOTH, 'method = "sobol"\nruns = 5\nseed = 3')
    told = design_of(base).to_file()
    path = written("", "", name="again.toml")
    path.write_text(path.read_text().partition("[sweep]")[0] + tomli_w.dumps({"sweep": told}))
    assert list(design_of(load_experiment(path))) == list(design_of(base))


def test_the_id_of_a_run_hangs_on_what_makes_its_bits_alone(experiment):
    def ids(*given, lanes=8, **changes):
        base = experiment(*given, **changes)
        setter = Setter(base)
        rows = rows_of(design_of(base, setter=setter), setter, experiment_key(setter, lanes))
        return [row.job.id for row in rows]

    vary = '"plant.payload" = ["1 kg", "2 kg"]'
    base = ids(vary)
    assert len(set(base)) == 4
    assert set(ids('"plant.payload" = ["2 kg", "3 kg"]')) & set(base) == set(base[2:])  # the same run is found again
    assert ids(vary, run=("[sweep]", "[run]\nlog_every = 5\n[sweep]")) == base
    assert not set(ids(vary, lanes=4)) & set(base)
    assert not set(ids(vary, plant=("0.9 x", "0.8 x"))) & set(base)
    assert not set(ids(vary, program=("20 mm", "21 mm"))) & set(base)
    assert not set(ids(vary, run=("[sweep]", "[run]\nseed = 5\n[sweep]"))) & set(base)
    other = ids(vary, law=('torque"\nbandwidth = "10 Hz"', 'torque"\nbandwidth = "11 Hz"'))
    assert [a == b for a, b in zip(other, base, strict=True)] == [True, False, True, False]


def test_a_factor_of_one_controller_repeats_no_run_of_the_other(experiment):
    base = experiment('"controller.1.bandwidth" = ["8 Hz", "9 Hz", "10 Hz"]')
    setter = Setter(base)
    rows = rows_of(design_of(base), setter, "key")
    assert len(rows) == 6 and len({row.job.id for row in rows}) == 4


def test_batches_hold_every_job_once_and_like_with_like(experiment):
    base = experiment('"plant.payload" = "uniform(1, 40) kg", "program.radius" = ["20 mm", "21 mm"]', "runs = 50")
    jobs = [row.job for row in rows_of(design_of(base), Setter(base), "key")]
    batches = batches_of(jobs, 2)
    assert sorted(job.id for batch in batches for job in batch) == sorted(job.id for job in jobs)
    assert {len(batch) for batch in batches[:-1]} == {16}
    order = [(job.controller, job.settings["program.radius"]) for batch in batches for job in batch]
    assert order == sorted(order)
