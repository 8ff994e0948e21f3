"""Sweeps: the runs that an experiment's [sweep] table asks for, done side by side and kept run by run."""
