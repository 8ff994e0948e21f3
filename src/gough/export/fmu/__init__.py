"""A plant as an FMU: what other simulators run, without Python."""
