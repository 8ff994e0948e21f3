"""gough map and gough envelope from the command line: files, JSON, exit statuses."""

from __future__ import annotations

import json

import pytest
import xarray as xr

from gough.cli import main


def run(capsys, *arguments):
    with pytest.raises(SystemExit) as end:
        main([str(one) for one in arguments])
    out, err = capsys.readouterr()
    return end.value.code, out, err


def test_a_map_of_one_axis_is_written_in_a_moment(tmp_path, capsys):
    status, out, _ = run(capsys, "map", "emps", "--what", "feed", "-o", tmp_path / "map", "--points", "3")
    assert status == 0 and out.splitlines()[0] == "3 of 3 poses are within all limits of the machine"
    assert (tmp_path / "map" / "feed.png").read_bytes().startswith(b"\x89PNG") and (
        tmp_path / "map" / "map.nc"
    ).exists()


@pytest.mark.full
def test_a_map_is_written_as_netcdf_figures_and_numbers(tmp_path, capsys):
    place = ["--at", "z=100 mm", "--points", "7,5", "--over", "x=-100 mm..100 mm,y"]
    status, out, err = run(capsys, "map", "ifma-hsm", "--what", "workspace,gravity", *place, "-o", tmp_path / "map")
    assert status == 0 and not err
    assert {path.name for path in (tmp_path / "map").iterdir()} >= {
        "map.nc",
        "map.json",
        "workspace.png",
        "gravity.png",
    }
    with xr.open_dataset(tmp_path / "map" / "map.nc", engine="h5netcdf") as found:
        assert found["holding"].shape == (7, 5) and float(found["x"][-1]) == pytest.approx(0.1)
    assert "of the declared workspace (35 poses) 100 % is reached" in out and "drive force of the weight" in out
    # a second time into the same folder, as JSON
    status, out, _ = run(capsys, "map", "ifma-hsm", *place, "-o", tmp_path / "map", "--json")
    told = json.loads(out)
    assert (status, told["schema"], told["status"], told["reached"]) == (0, "gough-map-1", "done", 1.0)
    assert told["files"][0].endswith("map.nc") and told["worst"]["reserve"]["pose"]["z"] == pytest.approx(0.1)


@pytest.mark.parametrize(
    "arguments, told",
    [
        (["--what", "feeed"], "--what: no such map, got 'feeed'; did you mean feed?"),
        (["--at", "x"], "--at: is NAME=VALUE, got 'x'; write \"x=50 mm\""),
        (["--at", "x=1"], "--at x: '1' has no unit; write e.g. \"1 m\""),
        (["--at", "u=1 m"], "--at: the machine has no such coordinate, got 'u'; there is x"),
        (["--over", "x=1 m"], "--over: a range is FROM..TO, got 'x=1 m'; write \"x=-0.1 m..0.1 m\""),
        (["--over", "y"], "--over: the machine has no such coordinate, got 'y'; there is x"),
        (["--points", "many"], "--points: whole numbers, got 'many'; write 41, or 41,41,5"),
        (["--points", "1"], "--points: at least 2 points, got 1"),
    ],
)
def test_wrong_options_are_told_by_their_names(arguments, told, tmp_path, capsys):
    status, _, err = run(capsys, "map", "emps", *arguments, "-o", tmp_path / "map")
    assert (status, err.strip()) == (2, told)
    assert not list(tmp_path.iterdir())


def test_a_slice_out_of_reach_is_a_failed_run_that_leaves_nothing(tmp_path, capsys):
    status, out, err = run(capsys, "map", "ifma-hsm", "--at", "z=2 m", "-o", tmp_path / "map", "--json")
    assert status == 1 and "nowhere on this map" in err and not list(tmp_path.iterdir())
    assert json.loads(out)["error"]["code"] == "WorkspaceError"


def test_an_envelope_is_printed_and_drawn(tmp_path, capsys):
    status, out, _ = run(capsys, "envelope", "emps", "--at", "x=100 mm", "-o", tmp_path / "e.png")
    assert status == 0 and (tmp_path / "e.png").read_bytes().startswith(b"\x89PNG")
    assert out.splitlines()[1].split(None, 1) == ["X+", "250 mm  carriage: beyond the end of its rail"]
    status, _, err = run(capsys, "envelope", "emps", "-o", tmp_path / "e.png")
    assert status == 2 and "there is a file already" in err
    status, out, _ = run(capsys, "envelope", "emps", "--json")
    told = json.loads(out)
    assert (told["schema"], [way["sense"] for way in told["ways"]]) == ("gough-envelope-1", [1, -1])


@pytest.mark.parametrize(
    "arguments, status, told",
    [
        (["--at", "x=1 m"], 1, "the pose itself is outside: carriage: beyond the end of its rail, got 1 m "
         "(limit 0.35 m); give a pose inside: home is one"),
        (["--at", "y=1 m"], 2, "--at: the machine has no such coordinate, got 'y'; there is x"),
        (["--wrench", "5 N"], 2, "--wrench: three forces, or three forces and three moments, got '5 N'; "
         'write "0 N,0 N,-500 N"'),
        (["-o", "e.doc"], 2, "--out: is no figure, got e.doc; end it in .png, .svg, .pdf"),
    ],
)  # fmt: skip
def test_wrong_poses_and_options_are_told(arguments, status, told, capsys):
    found, _, err = run(capsys, "envelope", "emps", *arguments)
    assert (found, err.strip()) == (status, told)
