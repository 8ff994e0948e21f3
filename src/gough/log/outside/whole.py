"""A whole record in memory, as a Log: for what looks at all of it at once, as identification does."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ...errors import LogError
from ...machine.base import Machine
from ...machine.record import RecordMap
from .rows import Record

if TYPE_CHECKING:
    from ..log import Log

MOST = 5_000_000  # samples; 0.5 GB of a machine of six joints


def read(path: str | Path, machine: Machine, mapping: RecordMap | None = None) -> Log:
    """A log of gough's (.nc), or the record of any other file, as `load`.

    Raises
    ------
    LogError
        as `Log.load` or `load`.
    """
    from ..log import Log

    ours = Path(path).suffix.lower() == ".nc" and mapping is None and getattr(machine, "record", None) is None
    return Log.load(path) if ours else load(path, machine, mapping)


def load(path: str | Path, machine: Machine, mapping: RecordMap | None = None) -> Log:
    """The record of a file: t, q_m, and u, the force that acted from a row's time on for one period.

    Samples that are missing or wrong are left out, so time has gaps there.

    Raises
    ------
    LogError
        as `Record`; or more than MOST samples.
    """
    from ..build import LogBuilder

    record = Record(path, machine, mapping)
    kept, count, last = [], 0, None
    for part in record.parts():
        count += len(part.t)
        if count > MOST:
            raise record.source.error(
                "the log is too long to be looked at as a whole", limit=f"{MOST} samples",
                cure="cut a stretch of it out",
            )  # fmt: skip
        t, q, u = part.t, part.q, part.u
        if last is not None and not part.anew:
            t, q, u = np.concatenate([last[0], t]), np.concatenate([last[1], q]), np.concatenate([u[:1], u])
        last = part.t[-1:], part.q[-1:]
        t, q, u = t[:-1], q[:-1], u[1:]  # a force that acted before a row acted from the row before on
        good = np.isfinite(q).all(1) & np.isfinite(u).all(1)
        kept.append((t[good], q[good], u[good]))
    t, q, u = (np.concatenate(columns) for columns in zip(*kept, strict=True))
    if len(t) < 2:
        raise LogError("has no two rows that can be used", file=str(path))
    builder = LogBuilder(t, machine.task, machine.joints_count)
    builder.add("q_m", q)
    builder.add("u", u)
    info = {
        "machine_name": machine.name, "joint_names": list(machine.joint_names), "record": str(path),
        "run": {"period": f"{record.period!r} s"}, "findings": record.findings.to_json(),
    }  # fmt: skip
    return builder.build(info)
