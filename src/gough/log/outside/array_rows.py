"""MATLAB and NetCDF files: arrays by name.  An entry of a table (n, k) is a column "name.3", from 1.

NetCDF-4 and MATLAB 7.3 are HDF5 and read a block of rows at a time; MATLAB 5 is read whole, up to 2 GB.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from ...errors import LogError
from .table import ROWS, Block, Source, marked

LARGEST = 2 << 30  # bytes of a file that is read whole
MOST_COLUMNS = 10_000  # of one array; a damaged header may say a thousand million
_HDF5 = b"\x89HDF\r\n\x1a\n"


class ArrayRows(Source):
    """Arrays of as many rows, each a column or several."""

    def __init__(self, path: Path):
        super().__init__(path)
        self.arrays = self._arrays()
        self.names, self.where = [], {}
        for name, array in self.arrays.items():
            if 0 in array.shape or array.shape[1:] > (MOST_COLUMNS,):  # nothing, or no table of columns
                continue
            count = 1 if array.ndim == 1 else array.shape[1]
            names = [name] if array.ndim == 1 else [f"{name}.{i + 1}" for i in range(count)]
            for i, full in enumerate(names):
                self.where[full] = name, i
            self.names += names

    def _arrays(self) -> dict[str, Any]:
        """{name: array (n,) or (n, k)} of all that may be columns."""
        raise NotImplementedError

    def blocks(self, names: Sequence[str]) -> Iterator[Block]:
        self.places(names)
        lengths = {name: self.arrays[self.where[name][0]].shape[0] for name in names}
        if len(set(lengths.values())) > 1:
            text = ", ".join(f"{count} of {name}" for name, count in lengths.items())
            raise self.error("columns must have equally many rows", value=text[:200])
        total = next(iter(lengths.values()))
        for start in range(0, total, ROWS):
            stop = min(total, start + ROWS)
            read: dict[str, np.ndarray] = {}
            values = np.empty((stop - start, len(names)))
            for k, name in enumerate(names):
                array, i = self.where[name]
                if array not in read:
                    read[array] = np.asarray(self.arrays[array][start:stop], float)
                values[:, k] = read[array] if read[array].ndim == 1 else read[array][:, i]
            yield Block(values, np.arange(start + 1, stop + 1), marked(values))


class MatRows(ArrayRows):
    """A MATLAB 5 file."""

    def _arrays(self):
        from scipy.io import loadmat

        size = self.path.stat().st_size
        if size > LARGEST:
            raise self.error(
                "a MATLAB 5 file is read whole, up to 2 GB", value=f"{size / 1e9:.1f} GB", cure="save it with -v7.3"
            )
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("error")  # "returned data may be corrupt", "duplicate variable name"
                content = loadmat(self.path)
        except Exception as error:  # whatever scipy makes of a file that is cut or not MATLAB
            raise self.error("cannot be read as MATLAB", value=str(error)[:100]) from None
        found = {}
        for name, value in content.items():
            if isinstance(value, np.ndarray) and value.dtype.kind in "fiu" and value.ndim == 2:
                if value.shape[0] == 1 and value.shape[1] > 1:  # a row is a column that lies down
                    value = value.T
                found[name] = value[:, 0] if value.shape[1] == 1 else value
        return found


class Hdf5Rows(ArrayRows):
    """NetCDF-4, or MATLAB 7.3, whose arrays stand on their side.

    The file is open only while rows are read: HDF5 knows a file that is open by its inode, and would give what it
    remembers of one that has been written anew.
    """

    file: Any = None  # while rows are read

    def _arrays(self):
        import h5py

        found: dict[str, Any] = {}
        with self._opened():
            try:
                turned = self.file.userblock_size >= 128  # MATLAB writes its header in front
                for name, data in self.file.items():
                    if isinstance(data, h5py.Dataset) and data.dtype.kind in "fiu" and data.ndim in (1, 2):
                        found[name] = _Hdf5(self, name, data, turned)
            except Exception as error:  # whatever h5py makes of a file that is damaged
                raise self.damaged(error) from None
        return found

    def blocks(self, names: Sequence[str]) -> Iterator[Block]:
        with self._opened():
            yield from super().blocks(names)

    @contextmanager
    def _opened(self) -> Iterator[None]:
        import h5py

        try:
            self.file = h5py.File(self.path, "r")
        except Exception as error:
            raise self.damaged(error) from None
        try:
            yield
        finally:
            self.file.close()
            self.file = None

    def damaged(self, error: Exception) -> LogError:
        """What h5py says of a file that it cannot read."""
        return self.error("cannot be read as HDF5", value=str(error)[:100])


class _Hdf5:
    """A dataset as (n,) or (n, k), its missing values NaN."""

    def __init__(self, source: Hdf5Rows, name: str, data: Any, turned: bool):
        self.source, self.name, self.turned = source, name, turned and data.ndim == 2
        self.packed = [key for key in ("scale_factor", "add_offset") if key in data.attrs]
        shape = data.shape[::-1] if self.turned else data.shape
        self.flat = len(shape) == 2 and shape[1] == 1
        self.shape = shape[:1] if self.flat else shape
        self.ndim = len(self.shape)
        # of whole numbers only: NaN marks what is missing among the others
        fill = data.attrs.get("_FillValue", data.attrs.get("missing_value"))
        self.fill = None if fill is None else np.ravel(fill)[0]

    def __getitem__(self, rows: slice) -> np.ndarray:
        if self.packed:  # its numbers are not what they say
            raise self.source.error(
                f"is packed ({', '.join(self.packed)})", key=self.name, cure="write it as plain numbers, e.g. ncpdq -U"
            )
        try:
            data = self.source.file[self.name]
            values = np.asarray(data[:, rows].T if self.turned else data[rows])
        except Exception as error:  # a chunk that is damaged
            raise self.source.damaged(error) from None
        missing = None if self.fill is None else values == self.fill
        values = values.astype(float)
        if missing is not None:
            values[missing] = np.nan
        return values[:, 0] if self.flat else values


def is_hdf5(path: Path) -> bool:
    """Whether a file is HDF5, at its begin or behind the header of MATLAB."""
    with path.open("rb") as file:
        head = file.read(520)
    return head[:8] == _HDF5 or head[512:520] == _HDF5
