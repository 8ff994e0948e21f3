"""Records in many dresses, with wounds whose effect is known: what a reader may make of them, or must refuse.

A wound changes the table of a record before it is written, or its bytes afterwards.  Of a table what it must be read as
is known: `Made.expected`, the rows by their time, NaN where nothing can be known.  Damaged bytes may turn a digit into
another; of them only the form of the answer is known.
"""

from __future__ import annotations

import io
from pathlib import Path
from typing import NamedTuple

import numpy as np

from .conftest import MAP, NAMES, csv_text

PERIOD = 1e-3
CELLS = (
    "",
    "",
    "nan",
    "nan",
    "NaN",
    "inf",
    "-inf",
    "1e400",
    "overrun",
    "12 mm",
    "0x1F",
    "1_0",
    "1.2.3",
    "--",
    "#",
    '"',
    "\xb5",
)
GAPS = '[gaps]\nlongest = "5 ms"\nmost = "40 %"\n'


class Made(NamedTuple):
    """A file, its map, and what may be read of it."""

    name: str
    content: bytes
    map_text: str
    expected: np.ndarray | None  # (N, 13) s, mm, N by row of time; None: only the form of the answer is known
    forceless: bool  # whether a reader of it must see no force on the tool
    story: str  # what was done to it


def made(rng: np.random.Generator, table: np.ndarray) -> Made:
    """A record of (N, 13) in a dress, with up to three wounds."""
    rows = _Rows(rng, table)
    for _ in range(rng.choice([0, 1, 1, 2, 3])):
        rows.wound()
    kind = rng.choice(["text", "parquet", "mat", "nc", "mat73"], p=[0.56, 0.12, 0.12, 0.1, 0.1])
    name, content, map_text = _text(rng, rows) if kind == "text" else _binary(rng, rows, kind)
    expected, forceless, story = rows.expected(), rows.forceless, ", ".join([kind, *rows.story])
    if rng.random() < 0.35:
        content, expected, forceless = _bytes(rng, content), None, False
        story += ", bytes"
    if rng.random() < 0.12:
        map_text, expected, forceless = _map(rng, map_text), None, False
        story += ", map"
    return Made(name, content, map_text, expected, forceless, story)


class _Rows:
    """The cells of a record, numbers or texts, and what each row must be read as."""

    def __init__(self, rng, table):
        self.rng, self.truth = rng, table
        self.table = table.copy()
        self.cells: dict[tuple[int, int], str] = {}  # (index of `order`, column): what stands there in a text
        self.order = list(range(len(table)))
        self.story: list[str] = []
        self.forceless = True

    def expected(self) -> np.ndarray:
        """The table as it must be read: changed numbers as changed, cells that are none as NaN."""
        out = self.table.copy()
        for (row, column), _ in self.cells.items():
            out[row, column] = np.nan
        return out

    def wound(self) -> None:
        kind = self.rng.choice(
            ["drop", "break", "twice", "differ", "swap", "cell", "cells", "huge", "late", "frozen", "flip", "exchange"]
        )
        self.story.append(str(kind))
        getattr(self, f"_{kind}")()

    def _at(self, margin: int = 2) -> int:
        margin = min(margin, len(self.order) // 3)
        return int(self.rng.integers(margin, len(self.order) - margin))

    def _drop(self):
        at = self._at()
        del self.order[at : at + int(self.rng.integers(1, 6))]

    def _break(self):
        at = self._at(70)
        del self.order[at : at + 60]

    def _twice(self):
        at = self._at()
        self.order.insert(at, self.order[at])

    def _differ(self):
        """Two rows of one time that differ: a copy of the table's row, at the time of the one before."""
        at = self._at()
        self.table[self.order[at], 0] = self.table[self.order[at - 1], 0]

    def _swap(self):
        at = self._at()
        self.order[at], self.order[at + 1] = self.order[at + 1], self.order[at]

    def _cell(self):
        self.cells[self.order[self._at()], int(self.rng.integers(13))] = str(self.rng.choice(CELLS))

    def _cells(self):
        at, column, text = self._at(10), int(self.rng.integers(1, 13)), str(self.rng.choice(CELLS))
        for k in range(int(self.rng.integers(2, 9))):
            self.cells[self.order[at + k], column] = text

    def _huge(self):
        self.table[self.order[self._at()], int(self.rng.integers(1, 13))] = self.rng.choice([1e9, -1e15, 1e30, -1e300])

    def _late(self):
        self.table[self.order[self._at()], 0] += self.rng.choice([0.3e-3, -0.3e-3, 0.5e-3])

    def _frozen(self):
        at, column = self._at(30), int(self.rng.integers(1, 7))
        self.table[self.order[at : at + 25], column] = self.table[self.order[at], column]
        self.forceless = False  # a reading that stands still for 25 ms is one that a force could have stopped

    def _flip(self):
        self.table[:, int(self.rng.integers(7, 13))] *= -1
        self.forceless = False  # told by the weight; but believed

    def _exchange(self):
        a, b = self.rng.choice(np.arange(7, 13), 2, replace=False)
        self.table[:, [a, b]] = self.table[:, [b, a]]
        self.forceless = False

    def written(self) -> tuple[np.ndarray, dict[tuple[int, int], str]]:
        """The rows in the order of the file, and the texts among them by place."""
        places = {(k, c): t for k, row in enumerate(self.order) for (r, c), t in self.cells.items() if r == row}
        return self.table[self.order], places


def _text(rng, rows: _Rows) -> tuple[str, bytes, str]:
    """A text in a dress, and a map that mostly fits it."""
    delimiter, decimal = rng.choice([",", ";", "\t", "|", " "]), rng.choice([".", "."])
    if delimiter != "," and rng.random() < 0.3:
        decimal = ","
    table, places = rows.written()
    order = rng.permutation(13) if rng.random() < 0.3 else np.arange(13)  # columns with their names elsewhere
    lines = csv_text(table[:, order], [NAMES[k] for k in order], delimiter, decimal).split("\n")
    for (row, column), text in places.items():
        cells = lines[row + 1].split(delimiter)
        cells[int(np.argmax(order == column))] = text
        lines[row + 1] = delimiter.join(cells)
    if rng.random() < 0.15:
        lines.insert(int(rng.integers(1, len(lines))), "# a remark")
    if rng.random() < 0.1:
        lines.insert(int(rng.integers(1, len(lines))), "")
    text = str(rng.choice(["\n", "\n", "\r\n"])).join(lines)
    told, dot = (delimiter, decimal) if rng.random() < 0.85 else (rng.choice([",", ";", "\t"]), ".")
    dress = f'[text]\ndelimiter = "{told}"\ndecimal = "{dot}"\n'.replace("\t", "\\t")
    mark = "\ufeff" if rng.random() < 0.1 else ""
    return "log.csv", (mark + text).encode("utf-8" if rng.random() < 0.97 else "utf-16"), _gaps(rng, MAP) + dress


def _gaps(rng, text: str) -> str:
    return text + GAPS if rng.random() < 0.7 else text


def _binary(rng, rows: _Rows, kind: str) -> tuple[str, bytes, str]:
    table, places = rows.written()
    table = table.copy()
    for row, column in places:
        table[row, column] = rng.choice([np.nan, np.inf, -np.inf])
    columns, folder = dict(zip(NAMES, table.T, strict=True)), io.BytesIO()
    if kind == "parquet":
        import pyarrow as pa
        import pyarrow.parquet as pq

        checked = bool(rng.random() < 0.5)
        pq.write_table(
            pa.table(columns), folder, row_group_size=int(rng.choice([50, 150, 1000])), write_page_checksum=checked,
            compression=str(rng.choice(["none", "snappy", "zstd"])), use_dictionary=bool(rng.random() < 0.5),
        )  # fmt: skip
    elif kind == "mat":
        from scipy.io import savemat

        savemat(folder, columns, oned_as=str(rng.choice(["column", "row"])), do_compression=bool(rng.random() < 0.5))
    else:
        import h5py

        with h5py.File(folder, "w", userblock_size=512 if kind == "mat73" else 0) as file:
            for name, column in columns.items():
                lying = column[None] if kind == "mat73" else column
                file.create_dataset(name, data=lying, compression="gzip" if rng.random() < 0.3 else None)
    name = {"parquet": "log.parquet", "mat": "log.mat", "nc": "log.nc", "mat73": "log.mat"}[kind]
    return name, folder.getvalue(), _gaps(rng, MAP)


def _bytes(rng, data: bytes) -> bytes:
    """Bytes changed, cut out, put in, said again, or the end cut off."""
    data = bytearray(data)
    for _ in range(int(rng.choice([1, 1, 2, 5, 40]))):
        at, kind = int(rng.integers(len(data) + 1)), rng.integers(6)
        if rng.random() < 0.3:
            at = min(at, int(rng.integers(1, 600)))  # where headers are
        if kind == 0 and at < len(data):
            data[at] ^= 1 << int(rng.integers(8))
        elif kind == 1 and at < len(data):
            data[at] = int(rng.integers(256))
        elif kind == 2:
            del data[at : at + int(rng.integers(1, 40))]
        elif kind == 3:
            data[at:at] = rng.integers(256, size=int(rng.integers(1, 20)), dtype=np.uint8).tobytes()
        elif kind == 4:
            data[at:at] = data[at : at + int(rng.integers(1, 400))]
        elif kind == 5 and rng.random() < 0.4:
            del data[at:]
    return bytes(data)


TOKENS = (
    '""',
    "0",
    "-1",
    "nan",
    "1e300",
    "true",
    "[]",
    "{}",
    '"1 s"',
    '"ms"',
    '"N m"',
    '"0 N"',
    '["q1"]',
    '"q9"',
    "1e-9",
)


def _map(rng, text: str) -> str:
    """A map with a line gone, a value of another kind, or a letter of another name."""
    lines = text.split("\n")
    row = int(rng.integers(1, len(lines)))
    kind = rng.integers(4)
    if kind == 0:
        del lines[row]
    elif kind == 1 and "=" in lines[row]:
        lines[row] = f"{lines[row].split('=')[0]}= {rng.choice(TOKENS)}"
    elif kind == 2:
        lines.insert(
            row, str(rng.choice(["[gaps]", "clip = 1e9", "sign = -1", 'acts = "before"', "x = 1", "[[text]]"]))
        )
    else:
        at = int(rng.integers(len(text)))
        return text[:at] + str(rng.choice(list('ab09"[]={}.,\n\0\xb5'))) + text[at + 1 :]
    return "\n".join(lines)


def written(folder: Path, one: Made) -> tuple[Path, Path]:
    """The files of a record: its own, its map's."""
    path, told = folder / one.name, folder / "map.toml"
    path.write_bytes(one.content)
    told.write_text(one.map_text, encoding="utf-8")
    return path, told
