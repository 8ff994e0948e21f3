"""The machine moving along a run, in the browser."""
