"""A log keeps what it was given, says its units, and a damaged file never loads as right."""

import json
import os
import shutil

import numpy as np
import pytest
import xarray as xr

from gough.errors import LogError, StorageError
from gough.log import Log
from gough.log import export as log_export
from gough.log import file as log_file
from gough.log.build import SCHEMA, VARIABLES, LogBuilder

TASK = (("x", "m"), ("y", "m"), ("z", "m"), ("a", "rad"), ("b", "rad"), ("c", "rad"))


def build(n=50, status="done", reason="", info=None, **extra):
    rng = np.random.default_rng(0)
    values = {
        "x": rng.standard_normal((n, 6)),
        "xd": rng.standard_normal((n, 6)),
        "q": rng.standard_normal((n, 6)),
        "u": 500 * rng.standard_normal((n, 6)),
        "saturated": rng.integers(0, 2, (n, 6)),
        "wrench": np.zeros((n, 6)),
        "line": np.arange(n) // 10,
        "counted": np.arange(n) >= 10,
        "contour_error": 1e-6 * np.arange(n),
        "controller.integral": rng.standard_normal((n, 6)),
        "plant.quaternion": rng.standard_normal((n, 4)),
        "observer.bias": rng.standard_normal(n),
    } | extra
    info = {"machine_name": "m", "controller_kind": "pid", "program": {"name": "p.ngc"}, "run": {"period": 1e-3}} | (
        info or {}
    )
    t = 1e-3 * np.arange(n)
    return Log.build(t, values, task=TASK, joints=6, info=info, status=status, reason=reason)


@pytest.fixture(scope="module")
def saved(tmp_path_factory):
    path = tmp_path_factory.mktemp("log") / "a.nc"
    log = build(400)
    log.save(path)
    return log, path


# -- contents -----------------------------------------------------------------------------------------------------


def test_what_is_saved_is_loaded_bit_for_bit(tmp_path):
    x = np.random.default_rng(1).standard_normal((50, 6))
    x[3, 2], x[4, 1], x[5, 0] = np.nan, np.inf, -0.0
    log = build(x=x, info={"text": '(é µ \\ " \0 \ud800)\n' * 20_000})  # longer than the 64 KiB of a plain attribute
    log.save(tmp_path / "a.nc")
    again = Log.load(tmp_path / "a.nc")
    assert again.dataset.identical(log.dataset)
    assert again["x"].tobytes() == log["x"].tobytes()
    assert {name: again[name].dtype for name in again} == {name: log[name].dtype for name in log}
    assert again.info == log.info


def test_a_log_without_rows_survives_saving(tmp_path):
    log = build(0, "failed", "first sample")
    log.save(tmp_path / "a.nc")
    again = Log.load(tmp_path / "a.nc")
    assert again.dataset.identical(log.dataset)
    assert again.failed and again.reason == "first sample"


def test_any_netcdf_reader_opens_it(saved):
    log, path = saved
    with xr.open_dataset(path) as dataset:
        assert dataset.identical(log.dataset)
        assert list(dataset.coords) == ["t"]


def test_every_variable_says_unit_and_meaning_and_none_is_named_like_a_dimension(saved):
    log, _ = saved
    for name, array in log.dataset.variables.items():
        assert array.attrs["units"] and array.attrs["long_name"], name
    assert not set(log.dataset.dims) & set(log)
    assert log.dataset.attrs["schema"] == SCHEMA


@pytest.mark.parametrize(
    ("name", "dims", "units"),
    [
        ("x_r", ("t", "task"), "m, rad"),
        ("xd", ("t", "twist"), "m/s, rad/s"),
        ("q_m", ("t", "joint"), "m"),
        ("u_c", ("t", "joint"), "N"),
        ("friction", ("t", "joint"), "N"),
        ("saturated", ("t", "joint"), "1"),
        ("wrench_hat", ("t", "wrench_axis"), "N, N m"),
        ("s_r", ("t",), "m"),
        ("line", ("t",), "1"),
        ("contour_error", ("t",), "m"),
        ("orientation_error", ("t",), "rad"),
        ("lag", ("t",), "m"),
        ("circle", ("t",), "1"),
        ("radial_error", ("t",), "m"),
        ("counted", ("t",), "1"),
        ("block", ("t",), "1"),
    ],
)  # the table of CONTRACT.md 3; its dimension wrench is wrench_axis, because a variable is named wrench
def test_variables_have_the_dimensions_and_units_of_the_contract(name, dims, units):
    builder = LogBuilder(np.arange(3.0), TASK, 6)
    builder.add(name, np.zeros((3, 6) if len(dims) == 2 else 3))
    log = builder.build({})
    assert log.dataset[name].dims == dims
    assert log.units(name) == units


def test_whole_numbers_have_the_types_of_the_contract():
    kinds = {name: VARIABLES[name].dtype for name in ("saturated", "counted", "circle", "line", "block")}
    assert kinds == {"saturated": "i1", "counted": "i1", "circle": "i2", "line": "i4", "block": "i4"}


def test_units_follow_the_task_coordinates():
    log = Log.build(np.arange(2.0), {"x": np.zeros((2, 3)), "xd": np.zeros((2, 3))}, task=TASK[:3], joints=3, info={})
    assert (log.units("x"), log.units("xd")) == ("m", "m/s")
    assert log.dataset["xd"].attrs["components"] == "vx, vy, vz"


def test_states_have_dimensions_of_their_own_unless_of_joint_or_task_size():
    builder = LogBuilder(np.arange(2.0), TASK[:3], 6)
    for name, size in (("controller.z", (6,)), ("controller.w", (3,)), ("plant.q", (4,)), ("observer.P", (2, 2))):
        builder.add(name, np.zeros((2, *size)))
    builder.add("observer.e", np.zeros((2, 6)), dims=("twist_hat",), units="m/s")
    data = builder.build({}).dataset
    assert data["controller.z"].dims == ("t", "joint")
    assert data["controller.w"].dims == ("t", "task")
    assert data["plant.q"].dims == ("t", "plant_q_i")
    assert data["observer.P"].dims == ("t", "observer_P_i", "observer_P_j")
    assert data["observer.e"].dims == ("t", "twist_hat")


def test_a_batch_has_the_dimension_run_behind_t():
    log = Log.build(
        np.arange(2.0), {"x": np.zeros((2, 5, 6)), "lag": np.zeros((2, 5))}, task=TASK, joints=6, info={}, runs=5
    )
    assert log.dataset["x"].dims == ("t", "run", "task")
    assert log.dataset["lag"].dims == ("t", "run")
    assert "5 runs" in repr(log)


def test_nan_never_becomes_a_whole_number():
    with pytest.raises(LogError, match="line: .*must be finite"):
        build(line=np.full(50, np.nan))


def test_a_wrong_shape_is_refused_with_the_right_one():
    with pytest.raises(LogError, match=r"x: the shape is wrong, got \(50, 5\) \(limit \(50, 6\)\)"):
        build(x=np.zeros((50, 5)))


@pytest.mark.parametrize("name", ["contour_eror", "controler.z", "controller.", "controller.a/b", "plant.=1+1", "t"])
def test_an_unknown_name_is_refused(name):
    with pytest.raises(LogError, match="no such variable"):
        build(**{name: np.zeros(50)})


def test_an_unknown_variable_is_answered_with_the_nearest():
    with pytest.raises(LogError, match="did you mean contour_error"):
        build()["contour_eror"]


def test_info_is_strict_json_and_numbers_that_are_not_finite_are_null():
    log = build(info={"a": np.float64(np.nan), "b": np.arange(2), "c": (np.int8(1), np.inf), "d": np.bool_(True)})
    text = log.dataset.attrs["gough"]
    json.loads(text, parse_constant=lambda name: pytest.fail(f"{name} is no JSON"))
    assert [log.info[key] for key in "abcd"] == [None, [0, 1], [1, None], True]


def test_a_broken_info_is_an_error_with_its_key(saved):
    data = saved[0].dataset.assign_attrs(gough="{")
    with pytest.raises(LogError, match="gough: is not JSON"):
        _ = Log(data).info


def test_a_failure_must_give_its_reason():
    with pytest.raises(LogError, match="reason"):
        build(status="failed")


# -- files that are not right -------------------------------------------------------------------------------------


def test_a_truncated_file_never_loads(saved, tmp_path):
    whole = saved[1].read_bytes()
    cuts = [len(whole) * k // 10 for k in range(10)] + [len(whole) - k for k in (1, 20, 47, 48, 49)] + [1, 4, 8]
    for size in cuts:
        path = tmp_path / "cut.nc"
        path.write_bytes(whole[:size])
        with pytest.raises(LogError, match="cut.nc: (is truncated|is damaged|lacks its checksum|is empty)"):
            Log.load(path)


def test_a_flipped_bit_never_loads(saved, tmp_path):
    whole = saved[1].read_bytes()
    rng = np.random.default_rng(2)
    places = {0, 8, len(whole) - 1, len(whole) - 40, len(whole) - 48, *rng.integers(0, len(whole), 200).tolist()}
    for place in places:
        broken = bytearray(whole)
        broken[place] ^= 1 << int(rng.integers(8))
        path = tmp_path / "flip.nc"
        path.write_bytes(broken)
        with pytest.raises(LogError):
            Log.load(path)


def test_bytes_put_behind_or_taken_out_are_found(saved, tmp_path):
    whole = saved[1].read_bytes()
    for broken in (whole + b"\0", whole[:1000] + whole[1001:], whole + whole[-48:]):
        (tmp_path / "b.nc").write_bytes(broken)
        with pytest.raises(LogError):
            Log.load(tmp_path / "b.nc")


def test_another_schema_is_refused_with_both_versions(saved, tmp_path):
    log_file.save(saved[0].dataset.assign_attrs(schema="gough-log-7"), tmp_path / "new.nc")
    with pytest.raises(LogError, match=f"new.nc: .*'gough-log-7' .*{SCHEMA}.*update gough"):
        Log.load(tmp_path / "new.nc")


def test_what_is_no_log_is_said_to_be_none(saved, tmp_path):
    (tmp_path / "a.csv").write_text("t,x\n0,1\n")
    xr.Dataset({"a": ("k", [1.0])}).to_netcdf(tmp_path / "foreign.nc", engine="h5netcdf")
    saved[0].dataset.to_netcdf(tmp_path / "again.nc", engine="h5netcdf")
    shutil.copy(saved[1], tmp_path / "good.nc")
    for name, words in (
        ("a.csv", "not a log of gough"),
        ("foreign.nc", "is NetCDF, but not a log"),
        ("again.nc", "lacks its checksum"),
        ("none.nc", "no such file"),
        (".", "is a folder, not a log; name the file, e.g. again.nc"),
    ):
        with pytest.raises(LogError, match=words) as found:
            Log.load(tmp_path / name)
        assert found.value.problems[0].file == str(tmp_path / name)


def test_a_failed_save_leaves_the_old_file_whole(saved, tmp_path, monkeypatch):
    log, path = saved
    shutil.copy(path, tmp_path / "a.nc")

    def full(file):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(StorageError):
        build(5).save(tmp_path / "a.nc")
    assert Log.load(tmp_path / "a.nc").dataset.identical(log.dataset)
    assert [p.name for p in tmp_path.iterdir()] == ["a.nc"]


# -- text -----------------------------------------------------------------------------------------------------------


def test_a_log_prints_what_ran_and_its_contour_error():
    text = repr(build(q=np.linspace(0.5, 0.75, 300).reshape(50, 6)))
    lines = text.splitlines()
    assert lines[0] == "<Log> m · pid · p.ngc"
    assert lines[1] == "  0.049 s at 1000 Hz, 50 samples"
    assert "  q                 (6,)   m            +0.5 ... +0.75" in lines
    # over rows 10 to 49 of 0, 1, 2, ... um: rms = sqrt((sum of squares to 49 - to 9) / 40) = sqrt((40425 - 285) / 40)
    assert lines[-2] == "  contour error   rms 31.7 um   max 49 um at t = 0.049 s (line 4)"


@pytest.mark.parametrize(("period", "rate"), [(5e-4, " at 2000 Hz"), ("0.5 ms", " at 2000 Hz"), ("fast", ""), ([], "")])
def test_the_sampling_rate_is_read_as_number_or_quantity(period, rate):
    assert f"0.049 s{rate}, 50 samples" in repr(build(info={"run": {"period": period}}))


def test_the_contour_error_printed_is_that_of_the_metrics_where_there_are_any():
    metrics = {"contour_error": {"max": 2e-6, "rms": 1e-6, "mean": 1e-6, "at": 0.02, "line": 7}, "samples": 500}
    text = repr(build(info={"metrics": metrics}))
    assert "rms 1 um   max 2 um at t = 0.02 s (line 7)" in text
    assert "500 samples, 50 rows kept" in text


def test_a_failure_is_the_first_thing_said():
    log = build(status="failed", reason="strut 3 is too long <b>")
    assert repr(log).startswith("<Log> FAILED: strut 3 is too long <b>\n")
    html = log._repr_html_()
    assert html.index("FAILED: strut 3 is too long &lt;b&gt;") < html.index("p.ngc")
    assert "<b>" not in html


def test_values_that_are_not_finite_are_counted_in_print():
    u = np.ones((50, 6))
    u[2:, :] = np.nan
    assert "+1 ... +1   (288 values not finite)" in repr(build(u=u))
    assert "not finite" in repr(build(u=np.full((50, 6), np.nan)))


# -- other programs -------------------------------------------------------------------------------------------------


def test_csv_gives_the_same_numbers_back(tmp_path):
    log = build()
    log.to_csv(tmp_path / "a.csv")
    lines = (tmp_path / "a.csv").read_text().splitlines()
    header = lines[1].split(",")
    assert header[:5] == ["t [s]", "x.x [m]", "x.y [m]", "x.z [m]", "x.a [rad]"] and header[7] == "xd.vx [m/s]"
    assert {"wrench.mz [N m]", "u.6 [N]", "controller.integral.1 [1]", "contour_error [m]"} <= set(header)
    table = np.loadtxt(tmp_path / "a.csv", delimiter=",", skiprows=2)
    np.testing.assert_array_equal(table[:, header.index("u.6 [N]")], log["u"][:, 5])
    np.testing.assert_array_equal(table[:, header.index("x.c [rad]")], log["x"][:, 5])


def test_csv_says_a_failure_in_its_first_line_and_no_text_becomes_a_cell_of_its_own(tmp_path):
    log = build(status="failed", reason='bad,=cmd()\n"x"', info={"machine_name": "a,b\r=1"})
    log.to_csv(tmp_path / "a.csv")
    first, second = (tmp_path / "a.csv").read_text().splitlines()[:2]
    assert first.startswith("# gough log") and "FAILED: bad =cmd()" in first
    assert "," not in first and '"' not in first
    assert second.startswith("t [s],")


@pytest.mark.parametrize("text", ["=1+1", "+a", "-a", "@a", "\ta"])
def test_a_text_a_spreadsheet_would_run_is_quoted(text):
    assert log_export.cell(text) == "'" + text
    assert log_export.cell("a" + text) == "a" + text


def test_matlab_gets_the_same_numbers_with_units(tmp_path):
    from scipy.io import loadmat

    log = build()
    log.to_mat(tmp_path / "a.mat")
    data = loadmat(tmp_path / "a.mat", simplify_cells=True)
    np.testing.assert_array_equal(data["u"], log["u"])
    np.testing.assert_array_equal(data["controller_integral"], log["controller.integral"])
    assert data["units"]["u"] == "N" and data["status"] == "done"
    assert json.loads(data["gough"]) == log.info


def test_parquet_without_pyarrow_says_what_to_install(tmp_path, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "pyarrow", None)
    with pytest.raises(LogError, match=r"pip install 'gough\[logs\]'"):
        build().to_parquet(tmp_path / "a.parquet")
    assert not list(tmp_path.iterdir())


def test_parquet_gives_the_same_numbers_with_units(tmp_path):
    pq = pytest.importorskip("pyarrow.parquet")
    log = build()
    log.to_parquet(tmp_path / "a.parquet")
    table = pq.read_table(tmp_path / "a.parquet")
    np.testing.assert_array_equal(table["u.6"].to_numpy(), log["u"][:, 5])
    assert table.schema.field("u.6").metadata[b"units"] == b"N"
    assert table.schema.metadata[b"status"] == b"done"
