"""Sweeps on a dask.distributed cluster on this machine: the same bits, also when a worker is lost; clear ends."""

from __future__ import annotations

import builtins
import importlib.util
import os
import signal
import socket
import threading

import pytest
from sweep_files import runs_of

from gough.errors import ExperimentError, RunError
from gough.experiment import load_experiment
from gough.sweep import cluster
from gough.sweep.run import sweep

if importlib.util.find_spec("distributed") is None:
    pytest.skip("the extra `cluster` is not installed", allow_module_level=True)
pytestmark = pytest.mark.full  # Dask alone takes a second to load

VARY = '"plant.payload" = "uniform(1, 40) kg"'


@pytest.fixture(scope="module")
def scheduler():
    """Two workers of one thread on 127.0.0.1, and no page of Dask's."""
    import distributed

    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, host="127.0.0.1", dashboard_address=None, silence_logs=50
    ) as found:
        yield found


def test_a_cluster_gives_the_bits_of_one_machine_also_when_a_worker_is_lost(scheduler, written, tmp_path):
    base = load_experiment(written(VARY, "runs = 40"))
    lost = []

    def tell(progress):
        if progress.done and not lost:
            lost.append(next(iter(scheduler.workers.values())).pid)
            os.kill(lost[0], signal.SIGKILL)

    swept = sweep(base, tmp_path / "cluster", scheduler=scheduler.scheduler_address, tell=tell)
    assert lost and swept.progress.failed == 0 and len(swept.records) == 80
    sweep(base, tmp_path / "here", workers=2)
    assert runs_of(tmp_path / "cluster") == runs_of(tmp_path / "here")


def test_a_scheduler_that_is_not_there_is_told_at_once(experiment, tmp_path):
    with socket.socket() as free:  # a port that nobody listens on
        free.bind(("127.0.0.1", 0))
        address = f"tcp://127.0.0.1:{free.getsockname()[1]}"
        with pytest.raises(RunError, match=f"{address}: no scheduler answers, got .*refused; is it running, and can"):
            sweep(experiment(VARY, "runs = 2"), tmp_path / "s", scheduler=address)


@pytest.mark.parametrize("answer", [b"", b"HTTP/1.1 400 Bad Request\r\n\r\n" * 40], ids=["silence", "another server"])
def test_what_answers_and_is_no_scheduler_is_told_and_not_waited_for(answer, experiment, tmp_path):
    with socket.socket() as server:
        server.bind(("127.0.0.1", 0))
        server.listen()
        calls = []

        def serve():
            while True:
                try:
                    calls.append(server.accept()[0])
                    calls[-1].sendall(answer)
                except OSError:
                    return

        threading.Thread(target=serve, daemon=True).start()
        with pytest.raises(RunError, match="no scheduler answers"):
            sweep(experiment(VARY, "runs = 2"), tmp_path / "s", scheduler=f"tcp://127.0.0.1:{server.getsockname()[1]}")
        assert cluster.PATIENCE <= 8  # s, half for the call and half for the answer; the limit is 10
        server.shutdown(socket.SHUT_RDWR)
        for call in calls:
            call.close()


@pytest.mark.parametrize("address", ["bogus://x:1", "tcp://", "127.0.0.1", "tcp://127.0.0.1:many"])
def test_what_is_no_address_is_told_as_wrong_input(address, experiment, tmp_path):
    with pytest.raises(ExperimentError, match=r"--scheduler: is no address, got .*; write it as in"):
        sweep(experiment(VARY, "runs = 2"), tmp_path / "s", scheduler=address)


def test_a_scheduler_without_workers_is_told(experiment, tmp_path, monkeypatch):
    import distributed

    monkeypatch.setattr(cluster, "PATIENCE", 4.0)
    with (
        distributed.LocalCluster(n_workers=0, host="127.0.0.1", dashboard_address="127.0.0.1:0") as empty,
        pytest.raises(RunError, match="the scheduler has no workers; start some: dask worker tcp://127.0.0.1"),
    ):
        sweep(experiment(VARY, "runs = 2"), tmp_path / "s", scheduler=empty.scheduler_address)


def test_workers_with_another_gough_are_refused(scheduler, experiment, tmp_path, monkeypatch):
    monkeypatch.setattr(cluster, "__version__", "9.9.9")
    with pytest.raises(RunError, match="a worker has another gough, got 0.1.0, here 9.9.9"):
        sweep(experiment(VARY, "runs = 2"), tmp_path / "s", scheduler=scheduler.scheduler_address)


def test_without_the_extra_the_cure_is_one_line(monkeypatch):
    real = builtins.__import__

    def without(name, *more, **options):
        if name == "distributed":
            raise ImportError(name)
        return real(name, *more, **options)

    monkeypatch.setattr(builtins, "__import__", without)
    with pytest.raises(ExperimentError) as caught:
        cluster.Cluster("tcp://127.0.0.1:8786")
    assert str(caught.value) == "--scheduler: needs dask.distributed; pip install 'gough[cluster]'"
