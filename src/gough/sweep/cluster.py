"""Workers of a cluster: an existing dask.distributed scheduler, told by its address.

What a worker does is work(), the same as on one machine, so the bits are the same where the processors are.  Batches
of a worker that is lost are done again by the others, which is Dask's own doing; a batch that has ended several
workers is given up, and told.  Needs the extra `cluster` here, and gough of the same version on the workers: each
batch says which it is made for, so that a worker that comes late is held to it too.

Dask waits without end for a scheduler that has taken a call and says nothing more; here nothing is waited for longer
than is said below, and its own log of lost connections is kept from the terminal.
"""

from __future__ import annotations

import contextlib
import logging
import math
import queue
import socket
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from typing import Any
from urllib.parse import urlsplit

from .. import __version__
from ..errors import ExperimentError, RunError
from .work import Done, Task, work

PATIENCE = 8.0  # s for a scheduler to answer, and for its first worker to come
LOADING = 60.0  # s for its workers to load gough, perhaps from a slow disk, and to say which one it is
_LOOK = 1.5  # s without a result, and the scheduler is asked whether it is there
_ANSWER = 5.0  # s that it has for this: told within ten in all
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
        self._log = logging.getLogger("distributed")
        self._level = self._log.level
        begun = time.monotonic()

        class Quiet(Client):  # one that could not connect would wait for its answer again when it is forgotten
            def __del__(self):
                pass

        self._probe()
        self.client = None
        self._log.setLevel(logging.CRITICAL + 1)  # what is lost is told once, by us
        try:
            self.client = self._connected(Quiet)
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
        """A client of the scheduler."""

        def connect() -> Any:
            # set_as_default=False: a Dask of the caller's own stays what it is
            return client(self.address, timeout=PATIENCE, set_as_default=False)

        try:
            return _within(PATIENCE / 2, connect)
        except OSError as error:  # TimeoutError is one
            raise self._lost("no scheduler answers", error) from None
        except Exception:  # whatever Dask makes of an answer that is none of a scheduler's
            raise self._lost("no scheduler answers", ConnectionError("what is no answer of Dask's")) from None

    def _workers(self, begun: float) -> int:
        """How many threads of workers there are."""
        while True:
            threads = sum(self._asked(self.client.nthreads).values())
            if threads:
                return threads
            if time.monotonic() - begun > PATIENCE:
                cure = f"start some: dask worker {self.address}"
                raise RunError("the scheduler has no workers", where=self.address, cure=cure)
            time.sleep(0.1)

    def _same_gough(self) -> None:
        try:
            told = self._waited(_begun(lambda: self.client.run(version)), LOADING)
        except RunError:
            raise
        except TimeoutError as error:
            cure = "end those that hang (dask's own name for it: worker-ttl), or start them anew"
            raise RunError("a worker does not answer", where=self.address, value=str(error), cure=cure) from None
        except Exception as error:  # most often: the worker has no gough
            cure = "install gough on the workers, the same version"
            raise RunError("a worker cannot load gough", where=self.address, value=str(error)[:80], cure=cure) from None
        for other in told.values():
            _check(other, version(), self.address)

    def _waited(self, came: queue.SimpleQueue, most: float = math.inf) -> Any:
        """What comes, while the scheduler is there.

        Raises
        ------
        RunError
            it is not.
        TimeoutError
            nothing comes in `most` s; or whatever has come instead.
        """
        begun = time.monotonic()
        while True:
            try:
                return _taken(came, _LOOK)
            except _Nothing:
                self._asked(lambda: self.client.sync(self.client.scheduler.identity))
                if time.monotonic() - begun > most:
                    raise TimeoutError(f"nothing in {most:g} s") from None

    def _asked(self, question: Callable[[], Any]) -> Any:
        """The scheduler's answer.

        Raises
        ------
        RunError
            it gives none.
        """
        try:
            return _within(_ANSWER, question)
        except Exception as error:
            raise self._lost("the scheduler does not answer", error) from None

    def _lost(self, rule: str, error: BaseException) -> RunError:
        value = str(error).splitlines()[0][:80] if str(error) else type(error).__name__
        return RunError(rule, where=self.address, value=value, cure="is it running, and can this machine reach it?")

    def __enter__(self) -> Cluster:
        return self

    def __exit__(self, *_error: Any) -> None:
        with contextlib.suppress(Exception):
            if self.client is not None:
                _within(1.0, lambda: self.client.close(timeout=1.0))
        self._log.setLevel(self._level)

    def each(self, tasks: Iterable[Task]) -> Iterator[tuple[int, Done]]:
        """(number of the task, what came of it), as they end.

        Raises
        ------
        RunError
            the scheduler is gone or says nothing, or a batch has ended several workers.
        """
        coming, ended, sent = enumerate(tasks), queue.SimpleQueue(), {}

        def send() -> None:
            item = next(coming, None)
            if item is not None:
                # not pure: whether a run is done already the store knows, not Dask
                future = self.client.submit(work_as, item[1], version(), pure=False, retries=0)
                sent[future.key] = future, item
                future.add_done_callback(lambda future: ended.put((future, None)))

        for _ in range(_AHEAD * self.workers):
            send()
        while sent:
            future = self._waited(ended)
            number, task = sent.pop(future.key)[1]
            if future.status != "finished":
                error = future.exception() if future.status == "error" else None
                if error is None:
                    raise self._lost("the scheduler is gone", ConnectionError(future.status))
                if isinstance(error, RunError):
                    raise error
                raise RunError(
                    f"a batch of {len(task.jobs)} runs broke on the cluster", where=self.address,
                    value=f"{type(error).__name__}: {error}"[:120], cure="the same command goes on",
                )  # fmt: skip
            done = self._waited(_begun(future.result))
            future.release()
            send()
            yield number, done


def work_as(task: Task, asked: tuple[str, str]) -> Done:
    """work(), on a worker whose gough is the one asked for.

    Raises
    ------
    RunError
        it has another.
    """
    _check(version(), asked, "a worker that came later")
    return work(task)


def version() -> tuple[str, str]:
    """Version and source of the gough that is at work here."""
    from .jobs import source_hash

    return __version__, source_hash()


def _check(found: tuple[str, str], asked: tuple[str, str], where: str) -> None:
    if found != asked:
        cure = "the runs would have other bits: install the same gough on all"
        value = f"{found[0]}, here {asked[0]}" + (" of another source" if found[0] == asked[0] else "")
        raise RunError("a worker has another gough", where=where, value=value, cure=cure)


class _Nothing(TimeoutError):
    """Nothing has come."""


def _begun(work: Callable[[], Any]) -> queue.SimpleQueue:
    """What `work()` gives, and what it raises, will come here: it is in a thread, left to itself if it never ends."""
    came: queue.SimpleQueue = queue.SimpleQueue()

    def carry_out() -> None:
        try:
            came.put((work(), None))
        except Exception as error:
            came.put((None, error))

    threading.Thread(target=carry_out, daemon=True).start()
    return came


def _taken(came: queue.SimpleQueue, seconds: float) -> Any:
    """What comes within `seconds`; raises what has come instead, or _Nothing."""
    try:
        found, error = came.get(timeout=seconds)
    except queue.Empty:
        raise _Nothing(f"nothing in {seconds:g} s") from None
    if error is not None:
        raise error
    return found


def _within(seconds: float, work: Callable[[], Any]) -> Any:
    """What `work()` gives within `seconds`; raises what it raises, or _Nothing."""
    return _taken(_begun(work), seconds)
