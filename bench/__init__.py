"""Timings beside real peers, in one run, interleaved.  Never in the tests."""
