"""Elastic joints in files: the sheet's [[compliance]], the experiment's flexible = true, and what is wrong there."""

from __future__ import annotations

import re

import numpy as np
import pytest

import gough as gk
from gough.errors import InputError
from gough.machine.sheet import library

EXPERIMENT = """\
schema = "gough-experiment-1"

[machine]
use = "soft.toml"

[plant]
flexible = true
stiffness = 0.5

[program]
kind = "line"
to = ["1 mm", "0 mm", "0 mm"]
feed = "60 mm/min"

[[controller]]
kind = "pid"
bandwidth = "4 Hz"
"""


@pytest.fixture
def sheet():
    return library()["nist-octahedral"].read_text().replace('name    = "nist-octahedral"', 'name    = "soft"')


def complaints(path, load=gk.load_experiment):
    with pytest.raises(InputError) as caught:
        load(path)
    return [line.replace(str(path.parent) + "/", "") for line in str(caught.value).splitlines()]


def test_an_experiment_makes_its_plant_flexible_and_leaves_the_law_its_rigid_machine(tmp_path, sheet):
    (tmp_path / "soft.toml").write_text(sheet)
    (tmp_path / "run.toml").write_text(EXPERIMENT)
    experiment = gk.load_experiment(tmp_path / "run.toml")
    true = experiment.plant.true_machine
    assert true.rigid == experiment.machine and experiment.machine.rigid is experiment.machine
    # 200 N/um a strut, half as stiff here
    np.testing.assert_allclose(true.springs.constant, 1e-8)


def test_a_stiffness_below_0_is_told_with_the_line_of_the_sheet(tmp_path, sheet):
    (tmp_path / "soft.toml").write_text(sheet.replace('"400 N/um"', '"-400 N/um"'))
    line = sheet.splitlines().index('stiffness     = "400 N/um"') + 1
    assert complaints(tmp_path / "soft.toml", gk.load_machine) == [
        f"soft.toml:{line}: compliance.0.stiffness: a stiffness must be positive definite: every eigenvalue above 0, "
        "got least eigenvalue -4e+08 N/m; check the signs and the size of what couples; leave a rigid joint out"
    ]


def test_a_joint_that_is_not_there_is_told_with_its_line(tmp_path, sheet):
    (tmp_path / "soft.toml").write_text(sheet.replace('"base joints"', '"base joint"'))
    line = sheet.splitlines().index('joint         = "base joints"') + 1
    assert complaints(tmp_path / "soft.toml", gk.load_machine) == [
        f"soft.toml:{line}: compliance.1.joint: no joint of this machine that may give way, got 'base joint'; did you "
        "mean base joints?"
    ]


def test_a_flexible_plant_of_a_machine_that_says_nothing_is_told_at_its_key(tmp_path, sheet):
    (tmp_path / "soft.toml").write_text(sheet.split("[[compliance]]")[0])
    (tmp_path / "run.toml").write_text(EXPERIMENT)
    found = complaints(tmp_path / "run.toml")
    assert len(found) == 1
    assert found[0].startswith("run.toml:7: plant.flexible: soft has no [[compliance]]: nothing in it gives way; give")


def test_options_of_a_flexible_plant_alone_are_told_at_their_key(tmp_path, sheet):
    (tmp_path / "soft.toml").write_text(sheet)
    (tmp_path / "run.toml").write_text(EXPERIMENT.replace("flexible = true\n", ""))
    assert complaints(tmp_path / "run.toml") == [
        "run.toml:7: plant.stiffness: is for flexible machines; write flexible = true beside it"
    ]


@pytest.mark.parametrize("name", sorted(library()))
def test_every_sheet_of_the_library_is_shown_with_what_gives_way(name, gough):
    ended = gough("show", name)
    assert ended.status == 0, ended.err
    machine = gk.load_machine(name)
    for i, entry in enumerate(machine.compliance or ()):
        assert re.search(rf"compliance\.{i}\.stiffness .*{entry.joint}: one: along the joint", ended.out)
