"""The same rows out of every kind of file; damaged ones are refused."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import gough as gk
from gough.errors import LogError
from gough.log.outside import Record
from outside.conftest import MAP, NAMES

pytest.importorskip("pyarrow")


def parquet(path, table):
    import pyarrow as pa
    import pyarrow.parquet as pq

    pq.write_table(pa.table(dict(zip(NAMES, table.T, strict=True))), path, row_group_size=150)


def mat(path, table):
    from scipy.io import savemat

    savemat(path, dict(zip(NAMES, table.T, strict=True)), oned_as="column")


def mat_lying(path, table):
    from scipy.io import savemat

    savemat(path, dict(zip(NAMES, table.T, strict=True)), oned_as="row")


def netcdf(path, table):
    import xarray as xr

    xr.Dataset({name: ("row", column) for name, column in zip(NAMES, table.T, strict=True)}).to_netcdf(
        path, engine="h5netcdf"
    )


def mat73(path, table):
    import h5py

    with h5py.File(path, "w", userblock_size=512) as file:
        for name, column in zip(NAMES, table.T, strict=True):
            file[name] = column[None]


WRITE = {"a.parquet": parquet, "a.mat": mat, "lying.mat": mat_lying, "a.nc": netcdf, "a.h5": netcdf, "b.mat": mat73}


@pytest.mark.parametrize("name", WRITE)
def test_the_numbers_are_those_that_were_written(tmp_path, record, truth, name):
    WRITE[name](tmp_path / name, truth.table)
    _, rows, _ = record(None, name=name)
    assert_allclose(rows.q, truth.q, rtol=0, atol=1e-15)
    assert_array_equal(rows.u[1:], truth.u[:-1])


@pytest.mark.parametrize("name", WRITE)
def test_a_missing_number_is_refused_with_its_row(tmp_path, record, truth, name):
    table = truth.table.copy()
    table[77, 3] = np.nan
    WRITE[name](tmp_path / name, table)
    with pytest.raises(LogError, match=r"q3: row 78: a number should be here, got no number"):
        record(None, name=name)


@pytest.mark.parametrize("name", ["a.parquet", "a.mat", "a.nc"])
def test_a_file_cut_anywhere_is_refused_or_whole(tmp_path, record, truth, name):
    path = tmp_path / name
    WRITE[name](path, truth.table)
    data = path.read_bytes()
    for length in np.linspace(1, len(data) - 1, 12).astype(int):
        path.write_bytes(data[:length])
        try:
            _, rows, _ = record(None, name=name)
        except LogError:
            continue
        assert_allclose(rows.q, truth.q, rtol=0, atol=1e-15)


def test_texts_in_a_parquet_column_are_refused(tmp_path, record, truth):
    import pyarrow as pa
    import pyarrow.parquet as pq

    columns = dict(zip(NAMES, truth.table.T, strict=True)) | {"q4": [str(v) for v in truth.q[:, 3]]}
    pq.write_table(pa.table(columns), tmp_path / "a.parquet")
    with pytest.raises(LogError, match="q4: a column of numbers is needed, got string"):
        record(None, name="a.parquet")


def test_packed_numbers_are_refused_not_taken_as_they_stand(tmp_path, record, truth):
    import xarray as xr

    data = xr.Dataset({name: ("row", column) for name, column in zip(NAMES, truth.table.T, strict=True)})
    data.to_netcdf(tmp_path / "a.nc", engine="h5netcdf", encoding={"q2": {"dtype": "i4", "scale_factor": 1e-6}})
    with pytest.raises(LogError, match=r"q2: is packed \(scale_factor\); write it as plain numbers"):
        record(None, name="a.nc")


@pytest.mark.parametrize("suffix", ["nc", "csv", "mat", "parquet"])
def test_a_log_of_goughs_needs_no_map(tmp_path, okuma, suffix):
    log = gk.simulate(okuma, gk.PID(bandwidth=10.0), gk.Circle(radius=0.005, feed=0.05))
    path = tmp_path / f"log.{suffix}"
    {"nc": log.save, "csv": log.to_csv, "mat": log.to_mat, "parquet": log.to_parquet}[suffix](path)
    parts = list(Record(path, okuma).parts())
    assert_array_equal(np.concatenate([p.q for p in parts]), log["q_m"])
    assert_array_equal(np.concatenate([p.u for p in parts])[1:], log["u"][:-1])


def test_a_file_nobody_described_names_its_columns(tmp_path, okuma):
    path = tmp_path / "log.csv"
    path.write_text("time,a,b\n0,1,2\n")
    with pytest.raises(LogError, match=r"nobody says what its columns are, got time, a, b; give a map: --map map.toml"):
        Record(path, okuma)


@pytest.mark.parametrize(
    ("name", "message"), [("log.xlsx", "is no log that gough reads, got '.xlsx'"), ("none.csv", "no such file")]
)
def test_another_kind_of_file_is_refused_by_name(tmp_path, okuma, name, message):
    if name == "log.xlsx":
        (tmp_path / name).write_text("x")
    with pytest.raises(LogError, match=message):
        Record(tmp_path / name, okuma)


def test_columns_of_other_lengths_are_refused(tmp_path, record, truth):
    from scipy.io import savemat

    columns = dict(zip(NAMES, truth.table.T, strict=True)) | {"u2": truth.u[:-3, 1]}
    savemat(tmp_path / "a.mat", columns, oned_as="column")
    with pytest.raises(LogError, match="columns must have equally many rows"):
        record(None, name="a.mat")


def test_entries_of_a_table_are_columns(tmp_path, okuma, truth):
    from scipy.io import savemat

    text = MAP.replace('["q1", "q2", "q3", "q4", "q5", "q6"]', str([f"Q.{i}" for i in range(1, 7)]).replace("'", '"'))
    (tmp_path / "map.toml").write_text(text)
    columns = {"t": truth.t, "Q": truth.q * 1e3} | {f"u{i + 1}": truth.u[:, i] for i in range(6)}
    savemat(tmp_path / "a.mat", columns, oned_as="column")
    from gough.log.outside import load_map

    parts = list(Record(tmp_path / "a.mat", okuma, load_map(tmp_path / "map.toml")).parts())
    assert_allclose(np.concatenate([p.q for p in parts]), truth.q, rtol=0, atol=1e-15)
