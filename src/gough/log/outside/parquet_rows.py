"""Parquet, a batch of rows at a time; needs pyarrow."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ...errors import LogError
from .table import ROWS, Block, Source, marked


class ParquetRows(Source):
    """A Parquet file; missing values become NaN."""

    def __init__(self, path: Path):
        super().__init__(path)
        try:
            import pyarrow.parquet as pq
        except ImportError:
            raise LogError("Parquet needs pyarrow", file=str(path), cure="pip install 'gough[logs]'") from None
        try:
            # buffered ahead, all of the file would stay; a checksum is looked at where the writer left one
            self.file: Any = pq.ParquetFile(path, pre_buffer=False, page_checksum_verification=True)
        except Exception as error:  # whatever pyarrow makes of a file that is cut or not Parquet
            raise self.error("cannot be read as Parquet", value=str(error).splitlines()[0][:100]) from None
        self.names = list(self.file.schema_arrow.names)

    def blocks(self, names: Sequence[str]) -> Iterator[Block]:
        self.places(names)
        kinds = {field.name: field.type for field in self.file.schema_arrow}
        for name in names:
            if not _is_number(kinds[name]):
                raise self.error("a column of numbers is needed", key=name, value=str(kinds[name]))
        done = 0
        batches = self.file.iter_batches(batch_size=ROWS, columns=list(dict.fromkeys(names)))
        while True:
            try:
                batch = next(batches, None)
            except Exception as error:  # a page that is damaged
                text = str(error).splitlines()[0][:100]
                raise self.error("cannot be read as Parquet", where=f"behind row {done}", value=text) from None
            if batch is None:
                return
            values = np.empty((len(batch), len(names)))
            for i, name in enumerate(names):
                values[:, i] = batch.column(name).cast("float64").to_numpy(zero_copy_only=False)
            yield Block(values, np.arange(done + 1, done + 1 + len(values)), marked(values))
            done += len(values)


def _is_number(kind: Any) -> bool:
    import pyarrow as pa

    return pa.types.is_integer(kind) or pa.types.is_floating(kind)
