"""gk.identify and gough identify: the table, the object, and what is refused."""

from __future__ import annotations

import json

import numpy as np
import pytest

import gough as gk
from gough.errors import ExperimentError, LogError
from gough.identify.fit import identify
from gough.log import Log

from .motions import fourier, log_of, machine_of, planted


def names_of(machine):
    return (*machine.parameters.names, *(f"friction.{k}[{i}]" for k in ("coulomb", "viscous") for i in range(6)))


@pytest.fixture(scope="module")
def case():
    """A log with 2 N of noise, of planted parameters; their values by name."""
    machine = machine_of("eth-hexaglide")
    names = names_of(machine)
    truth = planted(machine, names)
    log = log_of(machine, fourier(5), truth, noise=2.0, machine={"name": "eth-hexaglide"})
    return machine, log, dict(zip(names, truth, strict=True))


@pytest.fixture(scope="module")
def tip_only(case):
    """The same machine moved without turning."""
    machine, _, truth = case
    return log_of(machine, fourier(5, turn=0.0), np.array(list(truth.values())), noise=2.0)


@pytest.fixture(scope="module")
def saved(case, tip_only, tmp_path_factory):
    folder = tmp_path_factory.mktemp("logs")
    return case[1].save(folder / "turning.nc"), tip_only.save(folder / "tip.nc")


def test_a_fit_has_the_planted_values_within_its_deviations(case):
    machine, log, truth = case
    fit = gk.identify(log, machine)
    assert len(fit.names) == 23
    off = [(fit[name][0] - truth[name]) / fit[name][1] for name in fit.names]
    assert np.sqrt(np.mean(np.square(off))) < 1.6  # of 23 numbers of deviation 1: 1.6 is 4 deviations of their rms
    # white noise of 2 N at 1 kHz, behind the filter and the mean over blocks of 25 rows
    f = np.linspace(0.01, 500, 50_000)
    gain = np.sinc(f * 0.025) / (1 + (f / 20) ** 8)
    assert fit.estimate.residual_rms == pytest.approx(2 * np.sqrt(np.mean(gain**2)), rel=0.05)


def test_the_printed_table_has_every_value_with_its_deviation_and_unit(case):
    machine, log, _ = case
    fit = identify(log, machine)
    lines = str(fit).splitlines()
    assert lines[0] == "eth-hexaglide: 23 parameters from 242 rows of 6 joints, 6.05 s"
    assert lines[2].split() == ["parameter", "value", "deviation", "unit", "sheet"]
    rows = {line.split("  ")[0].strip(): line for line in lines[4:27]}
    for name, value, std, unit in zip(fit.names, fit.values, fit.std, fit.units, strict=True):
        words = rows[name].removeprefix(name).split()
        assert float(words[0]) == pytest.approx(value, abs=std)
        assert float(words[1]) == pytest.approx(std, rel=0.06)
        assert " ".join(words[2 : 2 + len(unit.split())]) == unit
    assert "residual 0." in lines[-1] or any(line.startswith("residual 0.") for line in lines)


def test_what_the_motion_does_not_show_has_no_number(case, tip_only):
    machine, _, _ = case
    fit = identify(tip_only, machine)
    inertias = tuple(f"platform.I{pair}" for pair in ("xx", "yy", "zz", "xy", "xz", "yz"))
    assert fit.unseen == inertias and fit.never == ()
    assert f"this motion does not show: {', '.join(inertias[:5])}" in str(fit).replace("\n  ", " ")
    rows = {row["name"]: row for row in fit.to_json()["parameters"]}
    for name in inertias:
        assert rows[name] == {"name": name, "value": None, "std": None, "unit": "kg m2", "seen": False}
    assert all(row["std"] > 0 for row in rows.values() if row["seen"])
    with pytest.raises(LogError, match="platform.Izz: the motion does not show it"):
        fit["platform.Izz"]


def test_notes_tell_of_another_machine_a_failed_run_and_limits(case):
    machine, log, _ = case
    info = {"machine": {"name": "another"}}
    dataset = log.dataset.assign_attrs(status="failed", reason="stopped at t = 6 s", gough=json.dumps(info))
    saturated = np.zeros((len(log), 6), np.int8)
    saturated[:60] = 1
    fit = identify(Log(dataset.assign(saturated=(("t", "joint"), saturated))), machine)
    assert fit.notes[0] == "the log is of another, the machine is eth-hexaglide"
    assert fit.notes[1] == "the run failed: stopped at t = 6 s"
    assert fit.notes[2] == "0.96 % of the forces were at the drive's limit and are left out"
    assert "note: the run failed: stopped at t = 6 s" in str(fit)


def test_arguments_that_are_none_are_refused(case):
    machine, log, _ = case
    with pytest.raises(ExperimentError, match="machine: must be a machine, got 'eth-hexaglide'"):
        identify(log, "eth-hexaglide")
    with pytest.raises(ExperimentError, match="log: must be a Log"):
        identify(3, machine)
    with pytest.raises(ExperimentError, match="friction: no such column of friction, got 'stribeck'; there is coulomb"):
        identify(log, machine, friction=("stribeck",))


# -- the command ---------------------------------------------------------------------------------------------------


def test_the_command_prints_the_table(gough, saved):
    done = gough("identify", saved[0], "--machine", "eth-hexaglide")
    assert done.status == 0 and done.err == ""
    assert done.out.startswith("eth-hexaglide: 23 parameters from 242 rows of 6 joints, 6.05 s\n")
    assert "\nplatform.m " in done.out and "kg m2" in done.out and "condition number" in done.out


def test_the_command_says_what_was_not_shown(gough, saved):
    done = gough("identify", saved[1], "-m", "eth-hexaglide")
    assert done.status == 0
    assert "this motion does not show: platform.Ixx, platform.Iyy, platform.Izz," in done.out


def test_the_object_has_what_the_contract_says(gough, saved):
    found = gough("identify", saved[0], "-m", "eth-hexaglide", "--json").json
    assert found["schema"] == "gough-identify-1" and found["status"] == "done" and found["error"] is None
    assert set(found["parameters"][0]) == {"name", "value", "std", "unit", "seen"}
    assert found["rank"] == 23 and found["condition"] > 1
    assert 0 < found["residual_rms"] <= found["held_out_rms"] < 1


def test_free_narrows_what_is_sought(gough, saved):
    found = gough("identify", saved[0], "-m", "eth-hexaglide", "--free", "carriage,friction.viscous", "--json").json
    assert [row["name"] for row in found["parameters"]] == ["carriage.m", *(f"friction.viscous[{i}]" for i in range(6))]


def test_a_file_gets_the_table_or_the_object_and_is_not_overwritten(gough, saved, tmp_path):
    table = gough("identify", saved[0], "-m", "eth-hexaglide", "-o", "fit.txt")
    assert (tmp_path / "fit.txt").read_text() == table.out
    assert gough("identify", saved[0], "-m", "eth-hexaglide", "-o", "fit.json", "--quiet").out == ""
    assert json.loads((tmp_path / "fit.json").read_text())["rank"] == 23
    again = gough("identify", saved[0], "-m", "eth-hexaglide", "-o", "fit.txt")
    assert again.status == 2
    assert again.err == "fit.txt: there is a file already; choose another name, or add --force\n"


def test_what_is_wrong_ends_with_status_2_and_one_line(gough, saved, tmp_path):
    for arguments, text in (
        (
            (saved[1], "-m", "eth-hexaglide", "--free", "platform.Izz"),
            "the motion shows none of what is sought, got platform.Izz; ",
        ),
        ((saved[0], "-m", "nist-octahedral"), "q_m: index [0]: no pose of nist-octahedral has these joints: "),
        ((saved[0], "-m", "eth-hexaglide", "--free", "masses"), "free: no such parameter, got masses; "),
        ((saved[0], "-m", "eth-hexaglide", "--cutoff", "20"), "'20' has no unit; write e.g. \"20 Hz\""),
        ((saved[0], "-m", "hexaglide"), "no machine of the library has this name, got 'hexaglide'; "),
        ((tmp_path / "none.nc", "-m", "eth-hexaglide"), f"{tmp_path / 'none.nc'}: "),
    ):
        done = gough("identify", *arguments)
        assert done.status == 2 and done.out == ""
        assert done.err.startswith(text), done.err
        assert done.err.count("\n") == 1
