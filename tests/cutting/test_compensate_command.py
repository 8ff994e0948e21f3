"""gough compensate: from a program and the log of its run to the program that leans, and to the wall it cuts."""

from __future__ import annotations

import numpy as np
import pytest

import gough as gk
from cutting.mills import cut, mill
from gough.cutting import Leaning
from gough.cutting.surface import Ran, cut_wall

pytestmark = pytest.mark.full  # simulates the part twice

PART = "G21 G90 G94 G61\nG0 X0 Y0 Z0\nS12000 M3\nG1 Y-90 F6000\nM5\nM2\n"
CUT = cut(mill(2, 30.0), "A5052", places=[0.03, 0.08], radial=[0.9e-3], deflection=Leaning())
ASKED = ["--height", "18 mm", "--air", "12 mm..28 mm"]


def machine():
    return gk.load_machine("okuma-pm600").frictionless()


@pytest.fixture(scope="module")
def logs(tmp_path_factory):
    """The log of the part being cut, and of the part in air."""
    folder = tmp_path_factory.mktemp("logs")
    (folder / "part.ngc").write_text(PART)
    program = gk.load_program(folder / "part.ngc")
    observer = gk.DisturbanceObserver(bandwidth=10.0)
    for name, cutting in (("cut", CUT), ("air", None)):
        plant = gk.Plant(machine=machine(), cutting=cutting)
        gk.simulate(machine(), gk.PID(bandwidth=20.0), program, plant, observer=observer).save(folder / f"{name}.nc")
    return folder


@pytest.fixture
def part(write):
    return write("part.ngc", PART)


def test_the_corrected_program_is_written_beside_the_original(gough, part, logs):
    done = gough("compensate", part, "--log", logs / "cut.nc", *ASKED)
    assert done.status == 0, done.err
    assert part.read_text() == PART
    corrected = part.with_name("part-compensated.ngc").read_text()
    assert "; was: G1 Y-90 F6000\nG64 P0.002\nG1 Y" in corrected
    assert "1 line of part.ngc changed" in done.out and "G1 Y-90 F6000" in done.out


def test_json_tells_force_tilt_and_shift_of_every_line(gough, part, logs):
    found = gough("compensate", part, "--log", logs / "cut.nc", *ASKED, "-o", "new.ngc", "--json").json
    (line,) = found["lines"]
    mean = CUT.mean_forces(0.1, 0.9e-3)[1]
    assert line["line"] == 4 and line["was"] == "G1 Y-90 F6000"
    assert abs(line["force"] / mean - 1) < 0.05  # the greatest of means over 4 mm, 16 teeth
    assert abs(line["shift"] - 18e-3 * np.tan(line["tilt"])) < 1e-12


def test_the_original_is_never_overwritten(gough, part, logs):
    link = part.with_name("linked.ngc")
    link.hardlink_to(part)
    for target in (part, part.parent / "." / "part.ngc", link):
        done = gough("compensate", part, "--log", logs / "cut.nc", *ASKED, "-o", target, "--force")
        assert done.status == 2
        assert "--out: would overwrite the original program" in done.err
    assert part.read_text() == PART


def test_the_log_and_the_map_are_not_overwritten_either(gough, part, logs, recorded):
    copy = part.with_name("copy.nc")
    copy.write_bytes((logs / "cut.nc").read_bytes())
    done = gough("compensate", part, "--log", copy, *ASKED, "-o", "copy.nc", "--force")
    assert done.status == 2 and "--out: would overwrite the log, got copy.nc; choose another name" in done.err
    assert copy.read_bytes() == (logs / "cut.nc").read_bytes()
    given = ["--map", "map.toml", "-m", "okuma-pm600", "--force"]
    done = gough("compensate", part, "--log", recorded(), *given, *ASKED, "-o", "map.toml")
    assert done.status == 2 and "--out: would overwrite the map, got map.toml" in done.err
    assert part.with_name("map.toml").read_text() == MAP


def test_a_file_that_is_there_stays(gough, part, logs, write):
    write("new.ngc", "mine")
    done = gough("compensate", part, "--log", logs / "cut.nc", *ASKED, "-o", "new.ngc")
    assert done.status == 2 and "there is a file already; choose another name, or add --force" in done.err


def test_a_log_whose_force_never_rises_is_told(gough, part, logs):
    done = gough("compensate", part, "--log", logs / "air.nc", *ASKED)
    assert done.status == 2
    assert "air.nc: the force never rises: there is nothing to compensate, got at most" in done.err
    assert not part.with_name("part-compensated.ngc").exists()


def test_the_log_of_another_program_is_refused(gough, write, logs):
    done = gough("compensate", write("part.ngc", PART + "(more)\n"), "--log", logs / "cut.nc", *ASKED)
    assert done.status == 2 and "cut.nc: is the log of another program, got part.ngc; run part.ngc and" in done.err


def test_a_correction_that_leaves_the_limits_is_told_with_line_and_amount(gough, part, logs):
    """A law that leans by 50 deg: beyond the cones of the joints."""
    done = gough("compensate", part, "--log", logs / "cut.nc", *ASKED, "--linear", "0.5 deg/N", "--height", "1 mm")
    assert done.status == 1
    assert "NC line " in done.err and "beyond its cone" in done.err and "(limit 45 deg)" in done.err
    assert not part.with_name("part-compensated.ngc").exists()


MAP = """schema = "gough-log-map-1"
[time]
period = "1 ms"
[joints]
columns = ["q1", "q2", "q3", "q4", "q5", "q6"]
unit = "mm"
[forces]
columns = ["u1", "u2", "u3", "u4", "u5", "u6"]
unit = "N"
"""


@pytest.fixture
def recorded(logs, write):
    """What a control would have recorded of the run: readings and forces, and nothing of a program."""

    def wrote(name="cut.csv", source="cut.nc", rows=slice(None)):
        log = gk.Log.load(logs / source)
        head = ",".join([f"q{i}" for i in range(1, 7)] + [f"u{i}" for i in range(1, 7)])
        table = np.concatenate([1e3 * log["q_m"], log["u"]], 1)[rows]
        return write(name, "\n".join([head, *(",".join(f"{x:.7f}" for x in row) for row in table)]) + "\n")

    write("map.toml", MAP)
    return wrote


def test_a_log_that_a_control_recorded_leads_to_the_same_program(gough, part, logs, recorded):
    own = gough("compensate", part, "--log", logs / "cut.nc", *ASKED, "-o", "own.ngc", "--json").json
    given = ["--map", "map.toml", "-m", "okuma-pm600"]
    outside = gough("compensate", part, "--log", recorded(), *given, *ASKED, "-o", "outside.ngc", "--json").json
    (a,), (b,) = own["lines"], outside["lines"]
    assert b["line"] == 4
    # the command believes the sheet's friction, 8 N a strut; the run had none: little of it acts across the feed
    assert abs(a["force"] - b["force"]) < 5
    assert abs(a["tilt"] - b["tilt"]) < np.radians(0.008)


def test_a_recorded_log_of_another_part_or_an_end_cut_off_is_refused(gough, part, write, recorded):
    given = ["--map", "map.toml", "-m", "okuma-pm600", *ASKED]
    half = gough("compensate", part, "--log", recorded("half.csv", rows=slice(0, 600)), *given)
    assert half.status == 2
    assert "half.csv: the tool leaves this program's path, or the log ends before it, got" in half.err
    assert "(limit 90 mm); is it the log of this program?" in half.err
    other = write("other.ngc", "G21 G90 G94 G61\nG0 X40 Y40 Z0\nG1 Y-90 F6000\nM2\n")
    done = gough("compensate", other, "--log", recorded(), *given)
    assert done.status == 2
    assert "cut.csv: the tool is never where this program's first feed begins, got " in done.err


def test_a_recorded_log_needs_its_machine_and_one_period(gough, part, recorded):
    done = gough("compensate", part, "--log", recorded(), "--map", "map.toml", *ASKED)
    assert done.status == 2 and "--machine: is missing: a recorded log does not say which; gough machines" in done.err


@pytest.mark.parametrize(
    "options, message",
    [
        (
            ["--air", "30 mm..10 mm"],
            '--air: must go from a place to one behind it, got 30 mm..10 mm; write "5 mm..30 mm"',
        ),
        (["--height", "18"], "--height: '18' has no unit"),
        (["--height", "0 mm"], "--height: must be above 0 m, got 0 mm"),
        (["--fine", "-1 deg"], "--fine: must be above 0 rad, got -1 deg"),
        (["--least", "-5 N"], "--least: must be above 0 N, got -5 N"),
        (["--bandwidth", "0 Hz"], "--bandwidth: must be above 0 Hz, got 0 Hz"),
        (["--linear", "-1 deg/N"], "--linear: must be at least 0 rad/N, got -1 deg/N"),
        (["--quadratic", "1 mm"], "--quadratic: '1 mm' is not a quantity in rad/N2"),
        (["--air", "30"], "--air: '30' has no unit"),
        (["--air", "0.5 m..0.6 m"], "--air: no row of the log lies in the air cut at an even speed"),
    ],
)
def test_options_that_cannot_be_are_refused(gough, part, logs, options, message):
    done = gough("compensate", part, "--log", logs / "cut.nc", *ASKED, *options)
    assert done.status == 2 and message in done.err


def test_the_corrected_program_cuts_an_upright_wall(gough, part, logs):
    gough("compensate", part, "--log", logs / "cut.nc", *ASKED)
    program = gk.load_program(part.with_name("part-compensated.ngc"))
    nominal = gk.load_program(part).plan(machine()).path
    walls = []
    for one in (gk.load_program(part), program):
        log = gk.simulate(machine(), gk.PID(bandwidth=20.0), one, gk.Plant(machine=machine(), cutting=CUT))
        walls.append(cut_wall(CUT, nominal, Ran(log.t, log["x"], log["s_r"]), np.arange(0.045, 0.075, 1e-4)))
    before, after = (wall.deviation(0.045, 0.075) for wall in walls)
    assert after < before / 10
    assert abs(walls[1].slope(0.045, 0.075)) < walls[0].slope(0.045, 0.075) / 10
