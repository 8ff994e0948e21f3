"""Workers of a cluster: an existing dask.distributed scheduler, told by its address.

What a worker does is work(), the same as on one machine, so the bits are the same where the processors are.  Batches
of a worker that is lost are done again by the others, which is Dask's own doing; a batch that has ended several
workers is given up, and told.  Needs the extra `cluster` here, and gough of the same version on the workers.
"""

from __future__ import annotations

import contextlib
import queue
import socket
import threading
import time
from collections.abc import Iterable, Iterator
from typing import Any
from urllib.parse import urlsplit

from .. import __version__
from ..errors import ExperimentError, RunError
from .work import Done, Task, work

PATIENCE = 8.0  # s for a scheduler to answer, and for its first worker to come
_AHEAD = 2  # batches a worker has waiting, so that it never waits for us


class Cluster:
    """`with Cluster("tcp://10.0.0.1:8786") as cluster: for number, done in cluster.each(tasks): ...`

    Raises
    ------
    ExperimentError
        dask.distributed is not installed, or the address is none.
    RunError
        the scheduler does not answer, has no workers, or they have another gough.
    """

    def __init__(self, address: str):
        try:
            from distributed import Client
        except ImportError:
            raise ExperimentError(
                "needs dask.distributed", key="--scheduler", cure="pip install 'gough[cluster]'"
            ) from None
        self.address = address
        begun = time.monotonic()

        class Quiet(Client):  # one that could not connect would wait for its answer again when it is forgotten
            def __del__(self):
                pass

        self._probe()
        self.client = self._connected(Quiet)
        try:
            self.workers = self._workers(begun)
            self._same_gough()
        except BaseException:
            self.__exit__()
            raise

    def _probe(self) -> None:
        """Refuse at once what is no address, or where nobody listens."""
        parts = urlsplit(self.address if "://" in self.address else f"tcp://{self.address}")
        try:
            place = parts.hostname, parts.port
        except ValueError:  # a port that is no number
            place = None, None
        if parts.scheme not in ("tcp", "tls") or None in place:
            cure = 'write it as in "tcp://127.0.0.1:8786"'
            raise ExperimentError("is no address", key="--scheduler", value=ascii(self.address)[:80], cure=cure)
        try:
            socket.create_connection(place, timeout=PATIENCE / 2).close()
        except (OSError, UnicodeError) as error:
            raise self._lost("no scheduler answers", error) from None

    def _connected(self, client: Any) -> Any:
        """A client of the scheduler; Dask waits without end for one that takes a call and says nothing."""
        came: queue.SimpleQueue = queue.SimpleQueue()

        def connect() -> None:
            try:
                # set_as_default=False: a Dask of the caller's own stays what it is
                came.put(client(self.address, timeout=PATIENCE, set_as_default=False))
            except Exception as error:  # whatever Dask makes of an answer that is none of a scheduler's
                came.put(error)

        threading.Thread(target=connect, daemon=True).start()
        try:
            found = came.get(timeout=PATIENCE / 2)
        except queue.Empty:
            found = TimeoutError(f"nothing in {PATIENCE / 2:g} s")
        if isinstance(found, Exception):
            raise self._lost("no scheduler answers", found)
        return found

    def _workers(self, begun: float) -> int:
        """How many threads of workers there are."""
        while True:
            threads = sum(self.client.nthreads().values())
            if threads:
                return threads
            if time.monotonic() - begun > PATIENCE:
                cure = f"start some: dask worker {self.address}"
                raise RunError("the scheduler has no workers", where=self.address, cure=cure)
            time.sleep(0.1)

    def _same_gough(self) -> None:
        from .jobs import source_hash

        try:
            told = self.client.run(_version)
        except Exception as error:  # most often: the worker has no gough
            cure = "install gough on the workers, the same version"
            raise RunError("a worker cannot load gough", where=self.address, value=str(error)[:80], cure=cure) from None
        other = next((version for version in told.values() if version != (__version__, source_hash())), None)
        if other is not None:
            cure = "the runs would have other bits: install the same gough on all"
            value = f"{other[0]}, here {__version__}"
            raise RunError("a worker has another gough", where=self.address, value=value, cure=cure)

    def _lost(self, rule: str, error: BaseException) -> RunError:
        value = str(error).splitlines()[0][:80] if str(error) else type(error).__name__
        return RunError(rule, where=self.address, value=value, cure="is it running, and can this machine reach it?")

    def __enter__(self) -> Cluster:
        return self

    def __exit__(self, *_error: Any) -> None:
        with contextlib.suppress(Exception):
            self.client.close(timeout=2)

    def each(self, tasks: Iterable[Task]) -> Iterator[tuple[int, Done]]:
        """(number of the task, what came of it), as they end.

        Raises
        ------
        RunError
            the scheduler is gone, or a batch has ended several workers.
        """
        from distributed import as_completed

        coming = enumerate(tasks)
        ended, sent = as_completed(loop=self.client.loop), {}

        def send() -> None:
            item = next(coming, None)
            if item is not None:
                # not pure: whether a run is done already the store knows, not Dask
                future = self.client.submit(work, item[1], pure=False, retries=0)
                sent[future.key] = item
                ended.add(future)

        for _ in range(_AHEAD * self.workers):
            send()
        for future in ended:
            number, task = sent.pop(future.key)
            if future.status != "finished":
                error = future.exception() if future.status == "error" else None
                if error is None:
                    raise self._lost("the scheduler is gone", ConnectionError(future.status))
                raise RunError(
                    f"a batch of {len(task.jobs)} runs broke on the cluster", where=self.address,
                    value=f"{type(error).__name__}: {error}"[:120], cure="the same command goes on",
                )  # fmt: skip
            done = future.result()
            future.release()
            send()
            yield number, done


def _version() -> tuple[str, str]:
    from .jobs import source_hash

    return __version__, source_hash()
