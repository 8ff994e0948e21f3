"""Damaged logs: the numbers that were written, with what was found told, or a LogError; no crash, no hang (C2).

How many and from which seed: GOUGH_FUZZ and GOUGH_FUZZ_SEED.
"""

import os
import struct
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from gough.errors import LogError
from gough.log.outside import Record, load_map
from outside.conftest import MAP, NAMES

ROOT = Path(__file__).parents[2]
SEED = os.environ.get("GOUGH_FUZZ_SEED", "1")
pytest.importorskip("pyarrow")
pytest.importorskip("h5py")


def fuzz(count, seconds):
    # a process of its own: it has no threads, so that it can make children, and its memory is that of the readers
    command = [sys.executable, "-m", "tests.outside.fuzz", str(count), SEED]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=seconds)
    assert done.returncode == 0, done.stdout[-4000:] + done.stderr[-2000:]
    return done.stdout


def test_damaged_logs_are_read_right_or_refused():
    assert fuzz(os.environ.get("GOUGH_FUZZ", 60), 300).endswith(" s\n")


@pytest.mark.full
def test_hundreds_of_damaged_logs_are_read_right_or_refused():
    fuzz(os.environ.get("GOUGH_FUZZ", 200), 600)


@pytest.mark.slow
def test_many_damaged_logs_are_read_right_or_refused():
    fuzz(os.environ.get("GOUGH_FUZZ", 100_000), 7200)


# -- what the fuzzer has found ----------------------------------------------------------------------------------------


def hdf5(path, table, **more):
    import h5py

    with h5py.File(path, "w") as file:
        for name, column in zip(NAMES, table.T, strict=True):
            file.create_dataset(name, data=column, **more)


def test_a_file_that_is_written_anew_at_its_place_is_read_anew(tmp_path, record, truth, okuma):
    """HDF5 knows open files by their inode: one still open would give old numbers among the new ones."""
    hdf5(tmp_path / "a.h5", truth.table)
    _, first, _ = record(None, name="a.h5")
    held = Record(tmp_path / "a.h5", okuma, load_map(tmp_path / "map.toml"))
    hdf5(tmp_path / "other.h5", truth.table * np.where(np.arange(13) > 6, 2, 1), compression="gzip")
    (tmp_path / "a.h5").write_bytes((tmp_path / "other.h5").read_bytes())
    _, second, _ = record(None, name="a.h5")
    assert (second.u[1:] == 2 * first.u[1:]).all()
    assert np.array_equal(np.concatenate([part.u for part in held.parts()])[1:], second.u[1:])


def test_a_matlab_file_that_says_a_thousand_million_columns_is_refused_at_once(record):
    header = struct.pack("<5i", 0, 0, 1 << 30, 0, 2)  # of MATLAB 4: a table of 0 rows, "a"
    with pytest.raises(LogError, match="the file has no such column, got 'q1'; there is none"):
        record(header + b"a\0", name="log.mat")


def test_a_matlab_file_of_which_scipy_is_not_sure_is_refused(record):
    header = struct.pack("<5i", 3000, 1, 1, 0, 2)  # numbers of a Cray
    with pytest.raises(LogError, match="cannot be read as MATLAB, got We do not support byte ordering 'VAX|'Cray"):
        record(header + b"a\0" + bytes(8), name="log.mat")


def test_a_table_between_other_delimiters_is_refused_with_the_right_one(record, truth):
    text = "\t".join(NAMES) + "\n" + "\n".join("\t".join(map(repr, map(float, row))) for row in truth.table) + "\n"
    with pytest.raises(LogError) as caught:
        record(text, MAP)
    assert str(caught.value).endswith(
        "log.csv: the file has no such column, got 'q1'; write delimiter = \"\\t\" in [text]"
    )


def test_a_page_with_a_wrong_checksum_is_refused(tmp_path, record, truth):
    import pyarrow as pa
    import pyarrow.parquet as pq

    columns = pa.table(dict(zip(NAMES, truth.table.T, strict=True)))
    options = {"compression": "none", "use_dictionary": False}
    pq.write_table(columns, tmp_path / "a.parquet", write_page_checksum=True, **options)
    data = bytearray((tmp_path / "a.parquet").read_bytes())
    at = data.index(truth.table[200, 3].tobytes())
    data[at + 5] ^= 1  # the number is one still
    (tmp_path / "a.parquet").write_bytes(data)
    with pytest.raises(LogError, match=r"cannot be read as Parquet, got .*CRC"):
        record(None, name="a.parquet")


def test_a_time_beyond_all_times_breaks_the_record_off(record, truth):
    table = truth.table.copy()
    table[300:, 0] = 1e300
    with pytest.raises(LogError, match=r"log.csv:303: two rows of one time differ, got 1e\+300 s"):
        record(table)
