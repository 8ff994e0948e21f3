"""Logs that gough did not write: CSV, Parquet, MATLAB and NetCDF, streamed and strict."""

from __future__ import annotations

from .mapping import load_map as load_map
from .rows import Record as Record
