"""Experiment files: TOML to checked parts, every mistake at once, and back to a file that repeats the run."""

from .experiment import SCHEMA, SUFFIXES, Experiment, experiment_of, load_experiment, nc_file

__all__ = ["SCHEMA", "SUFFIXES", "Experiment", "experiment_of", "load_experiment", "nc_file"]
