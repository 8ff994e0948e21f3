"""A log for other programs: CSV, MATLAB, Parquet.  All are written at once or not at all, all say the units."""

from __future__ import annotations

import csv
import io
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import LogError
from ..files import write_atomic
from .text import title

if TYPE_CHECKING:
    from .log import Log

_CHUNK = 4096  # rows of CSV in memory at a time


def columns(log: Log) -> list[tuple[str, str, np.ndarray]]:
    """(name, unit, values (n,)) of every scalar column: "x.a" in rad, "u.3", "controller.integral.1"; t comes first.

    Entries are numbered from 1; task coordinates go by their names.  Of a batch the rows of its runs follow one
    another, and the first column is the number of the run, from 0; without rows a row is a run and its metrics.
    """
    if log.batch:
        return _columns_of_runs(log)
    out = [("t", "s", log.t)]
    for name in log:
        array = log.dataset[name].transpose("t", ...)
        flat = array.values.reshape(len(log), int(np.prod(array.shape[1:])))
        names, units = _attribute(array, "components"), _attribute(array, "component_units")
        for i, index in enumerate(np.ndindex(array.shape[1:])):
            entry = [str(k + 1) for k in index]
            unit = str(array.attrs.get("units", "1"))
            if entry and len(names) == len(units) == array.shape[-1]:
                entry[-1], unit = names[index[-1]], units[index[-1]]
            out.append((".".join([name, *entry]), unit, flat[:, i]))
    return out


def _columns_of_runs(log: Log) -> list[tuple[str, str, np.ndarray]]:
    count = log.dataset.sizes["run"]
    if not len(log):
        numbers = [(name, log.units(name), log[name]) for name in log if log.dataset[name].dims == ("run",)]
        return [("run", "1", np.arange(count)), *numbers]
    tables = [columns(log.run(i)) for i in range(count)]
    run = np.repeat(np.arange(count), [len(table[0][2]) for table in tables])
    joined = [
        (name, unit, np.concatenate([table[k][2] for table in tables])) for k, (name, unit, _) in enumerate(tables[0])
    ]
    return [("run", "1", run), *joined]


def to_csv(log: Log, path: str | Path) -> Path:
    """Write CSV: a line that begins with # and says what it is and whether it failed, a header with units, the rows.

    Numbers are written so that reading gives the same binary number.  Texts that a spreadsheet would take for a
    formula are preceded by an apostrophe.

    Raises
    ------
    StorageError
        the file could not be written.
    """
    table = columns(log)
    status = f"FAILED: {log.reason}" if log.failed else log.status
    note = f"# gough log; {title(log)}; {status}"
    # a separator in the note would start a cell of its own in a spreadsheet
    note = "".join(" " if char in ',"\t\r\n' else char for char in note)

    def write(temporary: Path) -> None:
        with temporary.open("w", newline="", encoding="utf-8") as file:
            file.write(note + "\n")
            csv.writer(file, lineterminator="\n").writerow([cell(f"{name} [{unit}]") for name, unit, _ in table])
            for start in range(0, len(table[0][2]), _CHUNK):
                texts = [map(repr, values[start : start + _CHUNK].tolist()) for _, _, values in table]
                file.writelines(",".join(row) + "\n" for row in zip(*texts, strict=True))

    return write_atomic(path, write)


def cell(text: str) -> str:
    """A text that no spreadsheet takes for a formula."""
    return f"'{text}" if text[:1] in ("=", "+", "-", "@", "\t", "\r") else text


def to_mat(log: Log, path: str | Path) -> Path:
    """Write a MATLAB 5 file: variables by name (dots become underscores), structs `units` and `long_name`, and texts
    `status`, `reason` and `gough` (JSON).

    Raises
    ------
    LogError
        two names become one.
    StorageError
        the file could not be written.
    """
    from scipy.io import savemat

    content: dict[str, Any] = {"t": log.t}
    units, meanings = {"t": "s"}, {"t": "time"}
    for name in log:
        key = name.replace(".", "_")
        if key in content or len(key) > 63:  # 63: the longest name of MATLAB
            raise LogError("has no name of its own in a MATLAB file", key=name, cure="leave it out of the dataset")
        content[key] = log[name]  # of a batch (n, runs, ...), or (runs,)
        units[key] = log.units(name)
        meanings[key] = str(log.dataset[name].attrs.get("long_name", ""))
    content |= {"units": units, "long_name": meanings, "status": log.status, "reason": log.reason}
    content["gough"] = str(log.dataset.attrs.get("gough", "{}"))
    buffer = io.BytesIO()
    savemat(buffer, content, long_field_names=True, do_compression=True, oned_as="column")
    return write_atomic(path, buffer.getvalue())


def to_parquet(log: Log, path: str | Path) -> Path:
    """Write Parquet: one column a scalar, its unit in the metadata of the column, attributes in those of the file.

    Raises
    ------
    LogError
        pyarrow is not installed.
    StorageError
        the file could not be written.
    """
    try:
        import pyarrow as pa
        import pyarrow.parquet as pq
    except ImportError:
        raise LogError("Parquet needs pyarrow", cure="pip install 'gough[logs]'") from None
    table = columns(log)
    fields = [pa.field(name, pa.from_numpy_dtype(x.dtype), metadata={"units": unit}) for name, unit, x in table]
    attrs = {str(key): str(value) for key, value in log.dataset.attrs.items()}
    data = pa.table([pa.array(values) for _, _, values in table], schema=pa.schema(fields, metadata=attrs))
    return write_atomic(path, lambda temporary: pq.write_table(data, temporary))


def _attribute(array: Any, name: str) -> list[str]:
    text = str(array.attrs.get(name, ""))
    return [entry.strip() for entry in text.split(",")] if text else []
