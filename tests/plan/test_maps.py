"""Maps hold what is asked of single poses, with units, and refuse what is none."""

from __future__ import annotations

import json

import numpy as np
import pytest
import xarray as xr

import gough as gk
from gough.errors import ExperimentError, RunError, WorkspaceError
from gough.log.file import save
from gough.machine.vibration import stiffness_map
from gough.machine.workspace import check_poses, condition
from gough.plan import maps
from gough.plan.abilities import feeds, forces
from gough.plan.bounds import Bounds
from gough.plan.findings import findings, text_of
from gough.plan.grid import grid_of
from gough.plan.maps import machine_map
from gough.plan.quantities import QUANTITIES, TOLD
from gough.units import unit

HYBRID = "ifma-hsm"
ALL = ["workspace", "dexterity", "feed", "acceleration", "force", "gravity"]


def kept(machine, x) -> bool:
    try:
        check_poses(machine, x[None])
    except RunError:
        return False
    return True


@pytest.mark.quick(HYBRID)
@pytest.mark.parametrize("name", [HYBRID, "nist-octahedral", "eth-hexaglide", "ccu-3prs"])
def test_inside_is_where_a_run_would_find_no_limit_exceeded(name):
    machine = gk.load_machine(name)
    rng = np.random.default_rng(0)
    reach = {"ccu-3prs": 0.3, HYBRID: 0.6}.get(name, 0.25)
    x = np.array(machine.home) + rng.uniform(-reach, reach, (60, len(machine.home)))
    margins = Bounds(machine).of(x)[0]
    found = (margins >= 0).all(-1)
    assert found.any() and not found.all()
    assert found.tolist() == [kept(machine, row) for row in x]


def test_the_values_of_a_map_are_those_of_its_poses_in_the_order_of_its_axes():
    machine = gk.load_machine(HYBRID)
    found = machine_map(machine, ALL, over=("y", "x"), at={"z": 0.1}, points=(4, 3))
    assert found["feed"].dims == ("y", "x") and found["feed"].shape == (4, 3)
    x = np.array([found["x"].values[2], found["y"].values[1], 0.1])[None]
    assert found["feed"].values[1, 2] == feeds(machine, x)[0].min()
    assert found["holding"].values[1, 2] == np.abs(forces(machine, x)[0]).max()
    assert found["condition"].values[1, 2] == pytest.approx(condition(machine, machine.jacobian(x))[0], rel=1e-12)
    assert found["holding_share"].values[1, 2] == found["holding"].values[1, 2] / machine.drive.force_limit


def test_every_variable_has_a_unit_and_a_meaning_and_the_file_holds_all(tmp_path):
    found = machine_map(gk.load_machine(HYBRID), ALL, points=3)
    for name, array in found.variables.items():
        unit(array.attrs["units"]), array.attrs["long_name"]
        assert name in TOLD or name in found.coords
    save(found, tmp_path / "map.nc")
    with xr.open_dataset(tmp_path / "map.nc", engine="h5netcdf", decode_cf=False) as again:
        xr.testing.assert_identical(again.load(), found)
    told = json.loads(found.attrs["gough"])
    assert told["machine"]["name"] == HYBRID and told["fixed"] == {"z": 0.25} and told["what"] == ALL


def test_the_bits_of_a_map_do_not_depend_on_how_its_poses_are_cut_into_chunks(monkeypatch):
    machine = gk.load_machine(HYBRID)
    whole = machine_map(machine, ["workspace", "feed"], points=9)
    monkeypatch.setattr(maps, "CHUNK", 7)
    xr.testing.assert_identical(machine_map(machine, ["workspace", "feed"], points=9), whole)


def test_outside_nothing_is_told_but_how_far_it_is():
    machine = gk.load_machine(HYBRID)
    found = machine_map(machine, ALL, over={"x": (-1.5, 1.5), "y": (0.0, 2.5)}, points=21)
    inside = found["inside"].values.astype(bool)
    assert inside.any() and not inside.all()
    for name in ("feed", "condition", "force", "holding", "acceleration"):
        assert (np.isfinite(found[name].values) == inside).all()
    assert (found["feed_limit"].values[~inside] == -1).all()
    assert (found["reserve"].values[inside] >= 0).all() and not (found["reserve"].values[~inside] >= 0).any()
    lost = found["limit"].values == -1
    assert lost.any() and np.isnan(found["reserve"].values[lost]).all()  # nearer to pivot 1 than slide 1 can be


def test_a_map_tells_the_share_of_the_workspace_that_is_reached_and_what_is_in_the_way():
    machine = gk.load_machine(HYBRID)
    short = machine.replace(limits=machine.limits.replace(travel=[[0.7, 1.6], [0.7, 2.2], [-0.12, 0.65]]))
    found = findings(machine_map(short, ["workspace", "feed"], points=15))
    assert 0 < found["reached"] < 1 and found["declared"] == 225
    assert found["inside"] == round(found["reached"] * 225)
    assert list(found["in_the_way"]) == ["slide 1: beyond the end of its travel"]
    text = text_of(found)
    assert "in the way at 100.0 % of the rest: slide 1: beyond the end of its travel" in text
    worst = found["worst"]["feed"]
    x = np.array([[worst["pose"][name] for name in "xyz"]])
    assert worst["value"] == feeds(short, x)[0].min() and worst["limit"] == "slide 1: speed"


def test_the_reserve_is_one_in_the_middle_of_a_stroke_and_falls_evenly_to_its_ends():
    found = machine_map(gk.load_machine("emps"), points=5)
    np.testing.assert_allclose(found["reserve"].values, [0, 0.5, 1, 0.5, 0], atol=1e-12)
    assert found["x"].values[[0, -1]].tolist() == [-0.05, 0.35]


def test_what_is_the_same_at_all_poses_is_told_without_a_place():
    found = findings(machine_map(gk.load_machine("emps"), "feed", points=5))
    assert found["worst"]["feed"]["everywhere"] and found["worst"]["feed"]["value"] == pytest.approx(0.3)
    assert text_of(found).splitlines()[-1].split() == [
        "feed",
        "in",
        "the",
        "worst",
        "direction",
        "least",
        "0.3",
        "m/s",
        "everywhere",
    ]


@pytest.mark.full
def test_along_the_rails_of_a_hexaglide_nothing_changes_but_the_ends_of_the_rails():
    """Rails along x: a shift of the platform along x is a shift of all carriages, and no force asks where they are."""
    found = machine_map(gk.load_machine("eth-hexaglide"), ALL, points=(7, 9))
    for name in ("condition", "feed", "turn_rate", "acceleration", "angular_acceleration", "force", "holding"):
        values = found[name].transpose("x", "y").values
        np.testing.assert_allclose(values, np.broadcast_to(values[:1], values.shape), rtol=1e-10)
    assert np.ptp(found["reserve"].transpose("x", "y").values, axis=0).min() > 0.05


@pytest.mark.full
def test_a_map_of_stiffness_is_that_of_the_elastic_machine():
    machine = gk.load_machine(HYBRID)
    found = machine_map(machine, "stiffness", points=2)
    x = grid_of(machine, points=2).poses(0, 4)
    wanted = stiffness_map(machine.flexible(), x)
    np.testing.assert_array_equal(found["stiffness_least"].values.ravel(), wanted["least"])
    along = np.stack([found[f"stiffness_{axis}"].values.ravel() for axis in "xyz"], 1)
    np.testing.assert_array_equal(along, wanted["stiffness"])


@pytest.mark.full
def test_a_hexapod_has_feeds_of_place_and_of_turn_over_its_angles():
    machine = gk.load_machine("nist-octahedral")
    found = machine_map(machine, "feed", over=("a", "b"), at={"z": 0.02}, points=5)
    x = np.array(machine.home)
    x[2:5] = 0.02, found["a"].values[1], found["b"].values[3]
    wanted = feeds(machine, x[None])[0][0].reshape(2, -1).min(-1)
    np.testing.assert_array_equal([found["feed"].values[1, 3], found["turn_rate"].values[1, 3]], wanted)
    tilted = machine.limits.workspace.tilt
    np.testing.assert_allclose(found["a"].values[[0, -1]], [-tilted, tilted])
    assert not found["declared"].values[0, 0] and found["declared"].values[2, 0]


REFUSED = [
    ({"what": "stifness"}, "what: no such map, got 'stifness'; did you mean stiffness?"),
    ({"what": []}, "what: is empty; there is " + ", ".join(QUANTITIES)),
    ({"what": "dexterity"}, "what: one axis has the same dexterity everywhere, got emps; ask for feed or force"),
    ({"what": "force"}, "what: a map of force needs a limit of the drive: drive.torque_limit or drive.force_limit, "
     "got emps has none; write it into the data sheet"),
    ({"what": "stiffness"}, "what: a map of stiffness needs [[compliance]], got emps has none; "
     "say in the data sheet what gives way: docs/flexible.md"),
    ({"over": ("y",)}, "over: the machine has no such coordinate, got 'y'; there is x"),
    ({"at": {"x": 0.1}}, "over: a map needs a coordinate that runs; give some of x"),
    ({"over": ("x",), "at": {"x": 0.1}}, "at: runs already, got x; leave x out of over, or of at"),
    ({"points": 1}, "points: at least 2 points, got 1"),
    ({"points": (3, 4)}, "points: one number for each coordinate that runs, got (3, 4); give one number, or 1"),
    ({"points": 10**9}, "points: too many poses, got 1000000000 (limit 20000000)"),
    ({"over": {"x": (0.2, 0.1)}}, "over.x: the least comes first, got 0.2 m to 0.1 m"),
    ({"over": {"x": 3}}, "over.x: a range is two numbers, got 3"),
    ({"over": {"x": (0, np.nan)}}, "over.x: must be a finite number, got nan"),
]  # fmt: skip


@pytest.mark.parametrize("asked, told", REFUSED, ids=lambda value: None if isinstance(value, str) else str(value)[:40])
def test_a_map_that_there_cannot_be_is_refused(asked, told):
    with pytest.raises(ExperimentError) as error:
        machine_map(gk.load_machine("emps"), **asked)
    assert str(error.value) == told


def test_a_machine_without_limits_of_its_joints_has_no_map_of_its_feed():
    machine = gk.load_machine("emps")
    free = machine.replace(limits=machine.limits.replace(speed=None, acceleration=None))
    with pytest.raises(ExperimentError, match="a map of feed needs limits.speed, limits.acceleration or a limit of"):
        machine_map(free, "feed")
    with pytest.raises(ExperimentError, match="the range of x is missing: ifma-hsm declares no workspace"):
        machine = gk.load_machine(HYBRID)
        machine_map(machine.replace(limits=machine.limits.replace(workspace=None)))


def test_a_slice_that_nothing_reaches_is_refused_with_the_limit_that_is_nearest():
    with pytest.raises(WorkspaceError) as error:
        machine_map(gk.load_machine(HYBRID), at={"z": 0.9}, points=3)
    assert str(error.value) == (
        "the machine can stand nowhere on this map; nearest at x = -0.35 m, y = 1.05 m, z = 0.9 m: "
        "ram: beyond the end of its travel, got 0.9 m (limit 0.65 m); move the slice (at), or run over more (over)"
    )
    with pytest.raises(WorkspaceError, match="nowhere on this map; .*: slide 1: cannot reach: misses by"):
        machine_map(gk.load_machine(HYBRID), over={"x": (-0.9, -0.8), "y": (0.0, 0.1)}, points=3)
