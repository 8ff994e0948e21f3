"""Runs side by side: results in order, the first error ends all, an interruption is prompt."""

from __future__ import annotations

import threading
import time

import pytest

from gough.cli import together as module
from gough.cli.together import together


def test_results_come_in_the_order_of_the_jobs():
    def job(i):
        return lambda: (time.sleep(0.02 * (3 - i)), i)[1]

    assert together([job(i) for i in range(4)], threading.Event(), at_once=4) == [0, 1, 2, 3]


def test_two_jobs_run_at_a_time_when_two_may():
    meeting = threading.Barrier(2, timeout=5)  # a single runner would wait here for ever
    assert len(together([meeting.wait] * 2, threading.Event(), at_once=2)) == 2


def test_one_job_runs_at_a_time_when_one_may():
    running, most = [], []

    def job():
        running.append(1)
        most.append(len(running))
        time.sleep(0.01)
        running.pop()

    together([job] * 4, threading.Event(), at_once=1)
    assert max(most) == 1


def test_the_error_of_one_job_stops_the_others_and_is_raised():
    stop, ended = threading.Event(), []

    def slow():
        ended.append(stop.wait(5))

    def wrong():
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        together([slow, wrong], stop, at_once=2)
    assert ended == [True]


def test_jobs_that_do_not_listen_are_left_behind_after_a_second(monkeypatch):
    monkeypatch.setattr(module, "PATIENCE", 0.1)
    release = threading.Event()

    def deaf():
        release.wait(5)

    def interrupted():
        raise KeyboardInterrupt

    started = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        together([deaf, interrupted], threading.Event(), at_once=2)
    assert time.monotonic() - started < 2
    release.set()
