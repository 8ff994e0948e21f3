"""`gough preflight EXPERIMENT.toml --loop`: what the experiment's own law, at its sample time, asks of the drives."""

from __future__ import annotations

import json

import numpy as np
import pytest

import gough as gk
from gough.cli.end import Outcome
from gough.cli.preflight import Asked, preflight_file
from gough.errors import ExperimentError
from gough.plan import preflight
from gough.plan.loop import closed_loop

TOML = """schema = "gough-experiment-1"
[machine]
use = "eth-hexaglide"
[program]
file = "part.ngc"
[[controller]]
kind = "computed_torque"
bandwidth = "12 Hz"
[[controller]]
kind = "pid"
bandwidth = "12 Hz"
[run]
period = "1 ms"
"""
# the first lines of zigzag: steps of the acceleration that take up to 93 % of the force
HEAD = "G17 G21 G90 G94 G61\nG0 Z10\nG0 X-80 Y-80\nM2\n"


@pytest.fixture
def experiment(tmp_path):
    def write(text=TOML, program=None):
        if program is None:
            from gough.program.load import pieces

            program = "\n".join([*pieces()["zigzag"].read_text().splitlines()[:11], "M2\n"])  # 3 s of it
        (tmp_path / "part.ngc").write_text(program)
        (tmp_path / "part.toml").write_text(text)
        return tmp_path / "part.toml"

    return write


@pytest.mark.full
def test_the_law_of_the_experiment_is_at_the_limit_where_its_own_run_is(experiment, tmp_path):
    """zigzag at 1 ms: the motion takes 93 %, computed torque more than all behind steps, a PID not."""
    file = experiment()
    outcome = Outcome("preflight", True)
    preflight_file(file, None, Asked(loop=True, out=tmp_path / "out"), True, outcome)
    read = gk.load_experiment(file)
    assert preflight(read.machine, read.program).passed
    log = gk.simulate(read.machine, gk.ComputedTorque(bandwidth=12.0), read.program, period=1e-3)
    line, hit = log["line"], log["saturated"].astype(bool)
    expected = {(int(n), read.machine.joint_names[j]): int((hit[:, j] & (line == n)).sum())
                for j in range(6) for n in np.unique(line[hit[:, j]])}  # fmt: skip
    torque, pid = outcome.data["loops"]
    assert expected and {(h["line"], h["joint"]): h["samples"] for h in torque["hits"]} == expected
    assert pid["passed"] and not pid["hits"] and 0.9 < pid["use"] < 1
    assert outcome.data["status"] == "failed" and not outcome.data["passed"]
    told = outcome.data["error"]["problems"][0]
    assert told["rule"] == "the drive is at its limit under computed_torque" and told["limit"] == "2500 N"
    kept = json.loads((tmp_path / "out" / "preflight.json").read_text())
    assert kept["loops"] == json.loads(json.dumps(outcome.data["loops"])) and kept["passed"] is False


@pytest.mark.full
def test_without_steps_of_the_acceleration_the_loop_asks_for_what_was_told(experiment):
    """Bounded jerk: the greatest force of both laws is the preflight's to 1 % of the limit."""
    read = gk.load_experiment(experiment(TOML.replace("[program]", '[program]\nprofile = "jerk_limited"')))
    found = preflight(read.machine, read.program)
    force = max(peak.use for peak in found.peaks if peak.kind == "force")
    for loop in closed_loop(read, found):
        assert loop.passed and loop.use == pytest.approx(force, abs=0.01)
        assert str(loop).startswith(f"closed loop, {loop.law} at 1 ms: no drive reaches its limit; at most 8")


def test_a_loop_is_asked_of_an_experiment_as_it_is(experiment, tmp_path):
    file = experiment(program=HEAD)
    with pytest.raises(ExperimentError, match="--loop: needs a law and its sample time; give an experiment"):
        preflight_file(tmp_path / "part.ngc", "eth-hexaglide", Asked(loop=True), True, Outcome("preflight", True))
    with pytest.raises(ExperimentError, match="--loop: is for a program as it is; write the program first"):
        preflight_file(file, None, Asked(loop=True, place=True), True, Outcome("preflight", True))
