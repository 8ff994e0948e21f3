"""The FMU of a plant: valid, the same bytes every time, and what the kernel computes, sample by sample."""

from __future__ import annotations

import re
import shutil
import subprocess
import zipfile
from types import SimpleNamespace

import numpy as np
import pytest

import gough as gk
from gough.errors import ExperimentError
from gough.export.fmu.archive import fmu
from gough.export.fmu.model import model_of

fmpy = pytest.importorskip("fmpy", reason="fmpy (extra fmi) is not installed")
pytestmark = pytest.mark.skipif(shutil.which("gcc") is None, reason="gcc is not installed")
PATHS = {"emps": gk.Polyline(points=[[0, 0, 0], [0.1, 0, 0], [0.02, 0, 0]], feed=0.1)}


class Slave:
    """An instance of an FMU, stepped by hand."""

    def __init__(self, path, folder, **start):
        self.description = fmpy.read_model_description(str(path))
        from fmpy.fmi2 import FMU2Slave

        self.said = []
        self.vr = {v.name: v.valueReference for v in self.description.modelVariables}
        self.start = {v.name: v.start for v in self.description.modelVariables}
        self.fmu = FMU2Slave(
            guid=self.description.guid, unzipDirectory=fmpy.extract(str(path), str(folder)),
            modelIdentifier=self.description.coSimulation.modelIdentifier, instanceName="one",
        )  # fmt: skip
        self.fmu.instantiate()
        self.fmu.setupExperiment(startTime=0.0)
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()
        self.period = float(self.description.defaultExperiment.stepSize)
        self.k = 0

    def get(self, name: str, count: int) -> np.ndarray:
        return np.array(self.fmu.getReal([self.vr[f"{name}[{i}]"] for i in range(1, count + 1)]))

    def step(self, u_c) -> None:
        self.fmu.setReal([self.vr[f"u_c[{i}]"] for i in range(1, len(u_c) + 1)], [float(u) for u in u_c])
        self.fmu.doStep(currentCommunicationPoint=self.k * self.period, communicationStepSize=self.period)
        self.k += 1

    def close(self) -> None:
        self.fmu.terminate()
        self.fmu.freeInstance()


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """The FMU of a library machine or experiment, made once."""
    known = {}

    def make(name, what=None):
        if name not in known:
            path = tmp_path_factory.mktemp("fmu") / f"{name}.fmu"
            path.write_bytes(fmu(gk.load_machine(name) if what is None else what))
            known[name] = path
        return known[name]

    return make


@pytest.mark.full("ccu-3prs", "emps")
@pytest.mark.parametrize("name", ["nist-octahedral", "ccu-3prs", "emps", "okuma-pm600", "eth-hexaglide", "ifma-hsm"])
def test_fmpy_finds_nothing_wrong_and_runs_it(made, name):
    from fmpy.validation import validate_fmu

    assert validate_fmu(str(made(name))) == []
    result = fmpy.simulate_fmu(str(made(name)), stop_time=0.02, output=["q[1]", "u[1]"])
    machine = gk.load_machine(name)
    rest, force = machine.at_rest(np.asarray(machine.home))
    q = machine.inverse_kinematics(machine.home)[0]
    assert abs(result["q[1]"] - q).max() < 1e-7  # it stands, but for friction's first microns
    assert result["u[1]"][-1] == pytest.approx(force[0], abs=1e-9)


@pytest.mark.full
def test_the_same_bytes_come_out_every_time():
    machine = gk.load_machine("emps")
    assert fmu(machine) == fmu(machine)


PROGRAMS = {
    "okuma-pm600": 'payload = "20 kg"\n[program]\nkind = "circle"\nradius = "50 mm"\nfeed = "2.2 m/min"',
    "ccu-3prs": 'payload = "2 kg"\n[program]\nkind = "circle"\nradius = "10 mm"\nfeed = "0.4 m/min"',
    "emps": 'payload = "5 kg"\n[program]\nkind = "polyline"\npoints = { unit = "mm", value = '
    '[[0,0,0],[200,0,0],[20,0,0],[200,0,0],[20,0,0]] }\nfeed = "5 m/min"',
}


@pytest.mark.full("okuma-pm600", "emps")
@pytest.mark.parametrize("name", PROGRAMS)
def test_a_loop_closed_outside_is_the_loop_that_gough_closes(made, tmp_path, name):
    """10 s, encoder steps and friction included: an axis PD in NumPy on the FMU, and in gk.simulate."""
    sheet = tmp_path / "job.toml"
    sheet.write_text(
        f'schema = "gough-experiment-1"\n[machine]\nuse = "{name}"\n[plant]\n{PROGRAMS[name]}\n'
        '[[controller]]\nkind = "axis_pd"\nstiffness = "4 N/um"\n'
    )
    job = gk.load_experiment(sheet)
    log = gk.simulate(job.machine, job.controllers[0].law, job.program, job.plant)
    samples = min(len(log), 10_000)
    slave = Slave(made(f"{name}-job", job), tmp_path / "out")
    law = job.controllers[0].law.on(job.machine, slave.period)
    n = job.machine.joints_count
    rest = np.array([float(slave.start[f"u_c[{i}]"]) for i in range(1, n + 1)])
    before = np.zeros(n)
    worst = worst_tool = 0.0
    pose = [f"pose.{key}" for key, _ in job.machine.task]
    for k in range(samples):
        worst = max(worst, np.abs(slave.get("q", n) - log["q"][k]).max())
        found = np.array(slave.fmu.getReal([slave.vr[key] for key in pose]))
        worst_tool = max(worst_tool, np.abs(found - log["x"][k]).max())
        e = log["q_r"][k] - slave.get("q_m", n)
        slave.step(rest + law.stiffness * e + law.damping * (e - before) / slave.period)
        before = e
    slave.close()
    assert samples >= 5000
    assert worst < 1e-9 and worst_tool < 1e-9
    assert np.abs(np.diff(log["q"][:samples], axis=0)).max() > 1e-6  # it moved


@pytest.mark.full("nist-octahedral", "emps")
@pytest.mark.parametrize("name", ["nist-octahedral", "ccu-3prs", "emps"])
def test_forces_from_a_log_give_its_motion(made, tmp_path, name):
    machine, path = gk.load_machine(name), PATHS.get(name, gk.Circle(radius=0.01, feed=0.02))
    log = gk.simulate(machine, gk.PID(bandwidth=10.0), path)
    job = SimpleNamespace(machine=machine, plant=None, program=path, run=SimpleNamespace(period=1e-3, substeps=None))
    slave = Slave(made(f"{name}-path", job), tmp_path / "out")
    n, worst = machine.joints_count, 0.0
    for k in range(min(len(log), 3000)):
        worst = max(worst, np.abs(slave.get("q", n) - log["q"][k]).max())
        slave.step(log["u_c"][k])
    slave.close()
    assert worst < 1e-9


@pytest.mark.full
def test_nothing_of_python_is_in_it_and_nothing_is_needed(made, tmp_path):
    with zipfile.ZipFile(made("emps")) as archive:
        names = archive.namelist()
        archive.extractall(tmp_path)
    assert {name.rpartition(".")[2] for name in names} == {"xml", "c", "h", "so"}
    library = next(tmp_path.rglob("*.so"))
    needed = re.findall(
        r"NEEDED.*\[(.*?)\]", subprocess.run(["readelf", "-d", library], capture_output=True, text=True).stdout
    )
    assert set(needed) <= {"libm.so.6", "libc.so.6"}
    assert b"Py_" not in library.read_bytes()
    wanted = subprocess.run(["nm", "-D", "--undefined-only", library], capture_output=True, text=True).stdout
    assert not re.search(r" (malloc|calloc|realloc|printf|system|fopen)\b", wanted)


@pytest.mark.full
@pytest.mark.parametrize("compiler", ["gcc", "clang"])
@pytest.mark.parametrize("name", ["nist-octahedral", "ccu-3prs"])
def test_the_sources_compile_without_a_warning(made, tmp_path, name, compiler):
    if shutil.which(compiler) is None:
        pytest.skip(f"{compiler} is not installed")
    with zipfile.ZipFile(made(name)) as archive:
        archive.extractall(tmp_path)
    source = next(p for p in (tmp_path / "sources").glob("*.c") if p.name != "fmi2.c")
    flags = ["-std=c99", "-Wall", "-Wextra", "-Werror", "-O1", "-fPIC", "-shared", "-ffp-contract=off"]
    done = subprocess.run([compiler, *flags, "-o", tmp_path / "x.so", source, "-lm"], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[:2000]


@pytest.fixture()
def slave(made, tmp_path):
    slave = Slave(made("emps"), tmp_path / "out")
    yield slave
    slave.fmu.freeInstance()


@pytest.mark.full
def test_wrong_calls_are_errors_and_change_nothing(slave):
    before = slave.get("q", 1)
    for now, size in ((0.0, 0.4e-3), (0.0, 0.0), (0.0, -1e-3), (0.0, float("nan")), (0.5, 1e-3)):
        with pytest.raises(Exception, match="fmi2DoStep|status"):
            slave.fmu.doStep(currentCommunicationPoint=now, communicationStepSize=size)
    for place, value in ((slave.vr["q[1]"], 1.0), (10**6, 1.0), (slave.vr["u_c[1]"], float("nan"))):
        with pytest.raises(Exception, match="fmi2SetReal|status"):
            slave.fmu.setReal([place], [value])
    with pytest.raises(Exception, match="fmi2SetupExperiment|status"):
        slave.fmu.setupExperiment(startTime=0.0)
    assert slave.get("q", 1) == before
    slave.step([0.0])


@pytest.mark.full
def test_a_step_that_leaves_the_limits_is_undone_and_the_instance_fails(slave):
    with pytest.raises(Exception, match="fmi2DoStep|status"):
        for _ in range(20_000):
            slave.step([2000.0])
    stood = slave.get("q", 1)[0]
    assert stood <= gk.load_machine("emps").limits.travel[1]
    assert stood > gk.load_machine("emps").limits.travel[1] - 0.01
    with pytest.raises(Exception, match="fmi2DoStep|status"):
        slave.step([0.0])
    slave.fmu.reset()
    assert slave.get("q", 1)[0] == pytest.approx(0.0, abs=1e-12)


@pytest.mark.full
def test_a_state_that_was_kept_goes_on_as_before(slave):
    def run():
        found = []
        for k in range(200):
            slave.step([30.0 * np.sin(0.05 * k)])
            found.append(slave.get("q", 1)[0])
        return found

    run()
    state, k = slave.fmu.getFMUstate(), slave.k
    first = run()
    slave.fmu.setFMUstate(state)
    slave.k = k
    assert run() == first
    slave.fmu.freeFMUstate(state)


@pytest.mark.parametrize(
    "change, key",
    [
        ({"friction_drift": 0.01}, "plant.friction_drift"),
        ({"faults": [{"joint": 1, "kind": "stuck", "start": 1.0}]}, "plant.faults"),
    ],
)
def test_what_an_fmu_has_not_is_refused_by_name(change, key):
    machine = gk.load_machine("emps")
    job = SimpleNamespace(
        machine=machine, plant=gk.Plant(machine=machine, **change), program=PATHS["emps"],
        run=SimpleNamespace(period=1e-3, substeps=None),
    )  # fmt: skip
    with pytest.raises(ExperimentError, match=key):
        model_of(job)


@pytest.mark.full
def test_the_command_writes_it_whole_or_says_why_not(tmp_path):
    from typer.testing import CliRunner

    from gough.cli.app import app

    def gough(*arguments):
        done = CliRunner().invoke(app, [str(a) for a in arguments], standalone_mode=False)
        return done.return_value, done.output

    out = tmp_path / "axis.fmu"
    assert gough("export", "emps", "-t", "fmu", "-o", out) == (
        0, f"{out} is written: an FMU (FMI 2.0, co-simulation) of emps\n",
    )  # fmt: skip
    assert zipfile.is_zipfile(out)
    for arguments, text in (
        (["-o", out], "there is a file already"), (["-o", tmp_path], "a folder is there"), ([], "add -o FILE.fmu"),
        (["-o", tmp_path / "x.fmu", "--name", "2x"], "begins with a letter"),
    ):  # fmt: skip
        status, said = gough("export", "emps", "-t", "fmu", *arguments)
        assert status == 2 and text in said
    assert sorted(p.name for p in tmp_path.iterdir()) == ["axis.fmu"]


@pytest.mark.full
def test_without_a_compiler_the_command_says_that_sources_are_all_there_is(gough, tmp_path, monkeypatch):
    (tmp_path / "empty").mkdir()
    monkeypatch.setenv("PATH", str(tmp_path / "empty"))
    done = gough("export", "emps", "-t", "fmu", "-o", "axis.fmu")
    assert done.status == 0 and done.out.startswith("axis.fmu is written: ")
    assert done.err == (
        "warning: no C compiler (cc, gcc) is here: the FMU holds its sources only, and few importers compile them; "
        "install gcc and export again\n"
    )
    names = zipfile.ZipFile(tmp_path / "axis.fmu").namelist()
    assert "sources/emps.c" in names and not any("binaries" in name for name in names)
