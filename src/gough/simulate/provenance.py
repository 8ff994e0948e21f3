"""Everything that made a run, for the log's attribute "gough": inputs, versions, seed, hashes, and what it came to."""

from __future__ import annotations

import os
import platform
from importlib import metadata
from typing import Any

from .. import __version__

PACKAGES = ("numpy", "casadi", "llvmlite", "xarray", "pydantic")


def of(job, metrics: dict[str, Any], ticks: int, wall: float) -> dict[str, Any]:
    """The record of one run of `ticks` samples that took `wall` seconds."""
    law = job.law.to_file()
    law.pop("machine", None)
    program = job.program
    parts = {"machine": job.believed, "controller": job.law, "program": program, "plant": job.plant}
    watched = job.observer
    if watched is not None:
        parts["observer"] = watched
    return {
        "version": __version__,
        "versions": {name: metadata.version(name) for name in PACKAGES} | {"python": platform.python_version()},
        "machine": job.believed.to_file(),
        "machine_name": job.believed.name,
        "joint_names": list(job.believed.joint_names),
        "controller": law,
        "controller_kind": job.law.kind,
        "observer": {} if watched is None else {k: v for k, v in watched.to_file().items() if k != "machine"},
        "program": program.to_file() | {name: getattr(program, name, None) for name in ("name", "text")},
        "plant": job.plant.to_file(),
        "compensation": None if job.compensation is None else job.compensation.to_file(),
        "run": job.run_part.to_file()
        | {"substeps": job.substeps, "spectral_radius": job.radius, "native": bool(job.kernel and job.kernel.native)},
        "hashes": {name: part.digest() for name, part in parts.items()},
        "wall_time": wall,
        "simulated_time": ticks * job.run_part.period,
        "metrics": metrics,
        "warnings": list(job.notes),
        "reversals": getattr(job.sums, "reversals", []),
        "circles": [circle.to_json() for circle in job.motion.path.circles],
        "drawing": job.believed.drawing(job.believed.home),
        "processor": processor(),
    }


def of_batch(job, wall: float, runs: list[dict[str, Any]]) -> dict[str, Any]:
    """The record of a batch: that of its first run, what all of them took, and what the others are told by."""
    record = of(job, {}, 0, wall) | {"runs": runs, "simulated_time": float(job.samples.sum() * job.run_part.period)}
    for name in ("metrics", "reversals"):  # of each run
        record.pop(name)
    record["run"] |= {"substeps": sorted(set(job.substeps_of)), "lanes": job.kernel.lanes if job.kernel else None}
    return record


def processor() -> str:
    """The processor and its threads, for people."""
    try:
        with open("/proc/cpuinfo", encoding="ascii", errors="replace") as file:
            names = [line.split(":", 1)[1].strip() for line in file if line.startswith("model name")]
        return f"{names[0]}, {os.cpu_count()} threads"
    except (OSError, IndexError):
        return platform.machine()
