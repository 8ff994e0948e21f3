"""A record as samples of a machine: SI, in the order of its joints, at one period, good or missing.

record = Record(path, machine, load_map("map.toml"))
for part in record.parts():            in the memory of a block, however long the file
    part.t, part.q, part.u, part.good
record.findings, record.missing        what was found on the way
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ...errors import LogError, RunError
from ...machine.base import Machine
from ...machine.drives import force_limit
from ...machine.record import RecordMap, Text
from .array_rows import Hdf5Rows, MatRows, is_hdf5
from .detect import Detector
from .findings import Finding, Findings
from .mapping import own_map
from .parquet_rows import ParquetRows
from .table import Source
from .text_rows import Patience, TextRows
from .timeline import Samples, Timeline

SUFFIXES = {".csv": "text", ".txt": "text", ".tsv": "text", ".dat": "text", ".parquet": "parquet", ".pq": "parquet",
            ".mat": "mat", ".nc": "hdf5", ".h5": "hdf5", ".hdf5": "hdf5"}  # fmt: skip
_BEYOND = 1.001  # of the drives' limit: a current that is read has an error
_ENOUGH = 10_000  # samples from which the share that is missing is judged while reading


class Part(NamedTuple):
    """Samples that follow one another at the period."""

    t: np.ndarray  # (N,) s
    q: np.ndarray  # (N, n) m, NaN where not good
    u: np.ndarray  # (N, n) N, the force applied in the sample before; NaN where not good
    good: np.ndarray  # (N,)
    anew: bool  # whether they do not follow those before


def open_source(path: str | Path, text: Text, wait: Patience | None = None) -> Source:
    """The reader of a file, by its suffix.

    Raises
    ------
    LogError
        no such file, another suffix, or the file cannot be read.
    """
    path = Path(path)
    kind = SUFFIXES.get(path.suffix.lower())
    if kind is None:
        raise LogError(
            "is no log that gough reads", file=str(path), value=repr(path.suffix),
            cure=f"a log ends in {', '.join(SUFFIXES)}",
        )  # fmt: skip
    try:
        if not path.is_file():
            raise LogError("no such file" if not path.exists() else "must be a regular file", file=str(path))
        if wait is not None and kind != "text":
            raise LogError("only a text file can be followed while it is written", file=str(path))
        if path.stat().st_size == 0 and wait is None:
            raise LogError("is empty", file=str(path))
        if kind == "text":
            return TextRows(path, text, wait)
        if kind == "parquet":
            return ParquetRows(path)
        return Hdf5Rows(path) if kind == "hdf5" or is_hdf5(path) else MatRows(path)
    except OSError as error:
        raise LogError("cannot be read", file=str(path), value=error.strerror or str(error)) from None


class Record:
    """A record of a machine, read as it comes.

    Raises
    ------
    LogError
        the file or the map is wrong, or they do not go together or with the machine.
    """

    def __init__(
        self, path: str | Path, machine: Machine, mapping: RecordMap | None = None,
        wait: Patience | None = None,
    ):  # fmt: skip
        self.machine = machine
        self.source = open_source(path, Text() if mapping is None else mapping.text, wait)
        known = mapping or getattr(machine, "record", None) or own_map(self.source, machine.joints_count)
        if known is None:
            raise self.source.error(
                "nobody says what its columns are", value=", ".join(self.source.names)[:120] or "no columns",
                cure="give a map: --map map.toml; gough new map writes one to start from",
            )  # fmt: skip
        self.map = known.fits(machine)
        self.factor = known.forces.factor_of(machine)
        self.findings = Findings()
        if known.machine is not None and known.machine != machine.name:
            text = f"the map is for {known.machine}, not for {machine.name}"
            self.findings.add(Finding("machine", text))
        self.samples = self.missing = self.clipped = 0
        self.source.places(known.names)

    @property
    def period(self) -> float:
        """s, from sample to sample."""
        return self.map.time.period

    def parts(self) -> Iterator[Part]:
        """The samples, in order.

        Raises
        ------
        LogError
            a row that cannot be read, cells that are missing for too long, units that cannot be, too much missing.
        """
        n, last = self.machine.joints_count, None
        timeline = Timeline(self.source, self.map.time, self.findings)
        detector = Detector(self.machine, self.period, self.findings)
        cells = _Cells(self)
        checked = False
        for block in self.source.blocks(self.map.names):
            cells.remember(block)
            for samples in timeline.place(block, 2 * n):
                good = cells.good(samples)
                q, u = self._si(samples.values[:, :n], samples.values[:, n:])
                good &= ~self._clipped(samples, u)
                if not checked and good.sum() >= 2:
                    self._check_units(q[good])
                    checked = True
                self._count(good)
                detector.look(samples.t, q, u, good)
                u[~good] = np.nan  # what was cut off is no force of the next row either
                if self.map.forces.acts == "after":
                    before = np.full((1, n), np.nan) if last is None or samples.anew else last
                    last = u[-1:].copy()
                    u = np.concatenate([before, u[:-1]])
                yield Part(samples.t, q, u, good & np.isfinite(u).all(1) & np.isfinite(q).all(1), samples.anew)
        for text in self.source.told:
            self.findings.add(Finding("end", text))
        if not self.samples:
            raise self.source.error("has no rows")
        detector.finish()
        self._check_missing(0)

    def _si(self, q, u):
        m = self.map
        return q * (m.joints.scale_and_dimension()[0] * m.joints.sign) + m.joints.offset, u * (
            self.factor * m.forces.sign
        )

    def _clipped(self, samples: Samples, u: np.ndarray) -> np.ndarray:
        """Rows whose forces are cut off, by the map's `clip`, or beyond what the machine's drives can give."""
        n, most = self.machine.joints_count, force_limit(self.machine.drive)
        clip = self.map.forces.clip
        cut = np.zeros(len(u), bool) if clip is None else (np.abs(samples.values[:, n:]) >= clip).any(1)
        beyond = np.zeros(len(u), bool) if most is None else (np.abs(u) > _BEYOND * most).any(1) & ~cut
        self.clipped += int((cut | beyond).sum())
        for rows, kind, rule in (
            (cut, "clipped", "forces are cut off"),
            (beyond, "force", "no drive gives such a force"),
        ):
            for start, stop in stretches(rows):
                line, t = int(samples.lines[start]), samples.t
                found = Finding(kind, rule, line, float(t[start]), float(t[stop - 1]), stop - start)
                self.findings.add(found, 2 * self.period)
        return cut | beyond

    def _count(self, good: np.ndarray) -> None:
        self.samples += len(good)
        self.missing += int((~good).sum())
        self._check_missing(_ENOUGH)

    def _check_missing(self, enough: int) -> None:
        missing = self.missing - self.clipped
        if self.samples >= max(enough, 1) and missing > self.map.gaps.most * self.samples:
            raise self.source.error(
                "too many samples are missing or wrong", value=f"{missing} of {self.samples}",
                limit=f"{100 * self.map.gaps.most:g} %", cure="give a better record, or more in gaps.most",
            )  # fmt: skip

    def _check_units(self, q: np.ndarray) -> None:
        """Refuse readings that no pose of the machine has, or that move faster than its joints can."""
        try:
            self.machine.forward_kinematics(q[0])
        except RunError as error:
            problem = error.problems[0]
            raise self.source.error(
                f"the first readings are no pose of {self.machine.name}: {problem.rule}",
                key="joints", value=f"{np.round(q[0], 6).tolist()} m", cure=self._cure(q[0]),
            ) from None  # fmt: skip
        limit = getattr(self.machine.limits, "speed", None)
        speed = np.abs(np.diff(q, axis=0)).max(1) / self.period
        if limit is not None and len(speed) and np.percentile(speed, 90) > limit:
            raise self.source.error(
                "joints move faster than the machine's can", key="time.period",
                value=f"{np.percentile(speed, 90):.4g} m/s", limit=f"{limit:.4g} m/s",
                cure="check the period, and the unit of the readings",
            )  # fmt: skip

    def _cure(self, q: np.ndarray) -> str:
        """Another unit in which the readings are a pose."""
        scale, _ = self.map.joints.scale_and_dimension()
        for name, value in (("m", 1.0), ("mm", 1e-3), ("um", 1e-6), ("cm", 1e-2), ("in", 0.0254)):
            if value != scale:
                _, status = self.machine.forward_kinematics((q - self.map.joints.offset) / scale * value, on_fail="nan")
                if status == 0:
                    return f'did you mean unit = "{name}"?'
        return "check unit, order and offset of the readings"


class _Cells:
    """Cells that are no numbers: refused, or, for as long as the map allows, missing."""

    def __init__(self, record: Record):
        self.record = record
        self.run, self.first = 0, None
        self.told: dict[int, tuple[str, str]] = {}  # line: (column, what stands there)

    def remember(self, block) -> None:
        """Where this block has cells that are no numbers."""
        names = self.record.map.names
        self.told = {int(block.lines[row]): (names[column], text) for row, column, text in reversed(block.bad)}

    def good(self, samples: Samples) -> np.ndarray:
        """Which samples are whole.  LogError where cells are missing for longer than gaps.longest."""
        there, wrong = samples.lines > 0, np.isnan(samples.values).any(1)
        empty = there & wrong
        if not empty.any():
            self.run = 0
            return there & ~wrong & ~samples.late
        longest, period = self.record.map.gaps.longest, self.record.period
        for start, stop in stretches(empty):
            self.run = stop - start + (self.run if start == 0 else 0)
            line = int(samples.lines[start])
            self.first = line if self.run == stop - start else self.first
            if self.run * period > longest * (1 + 1e-9):
                self._refuse(self.first if self.first in self.told else line)
            column, text = self.told.get(line, ("", ""))
            rule = f"{column}: {text} where a number should be"
            t = samples.t
            self.record.findings.add(Finding("cell", rule, line, float(t[start]), float(t[stop - 1]), stop - start))
        self.run = self.run if empty[-1] else 0
        return there & ~wrong & ~samples.late

    def _refuse(self, line: int):
        column, text = self.told.get(line, ("a cell", "no number"))
        record = self.record
        number = {"line": line} if record.source.row_word == "line" else {"where": f"row {line}"}
        cure = 'allow short gaps by longest = "5 ms" in [gaps]' if not record.map.gaps.longest else None
        rule = "a number should be here"
        if record.map.gaps.longest:
            rule, cure = f"no numbers for longer than gaps.longest, {record.map.gaps.longest:g} s", None
        raise record.source.error(rule, key=column, value=text, cure=cure, **number)


def stretches(flags: np.ndarray) -> list[tuple[int, int]]:
    """(start, stop) of every run of true entries."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], flags, [False]]).astype(np.int8)))
    return list(zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True))
