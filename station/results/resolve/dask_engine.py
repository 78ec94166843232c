"""The workers of a Dask cluster, started here or elsewhere.

A worker that dies is no loss: Dask gives its items to the others, and up to three times an item whose worker died
each time. Local workers listen on the loopback alone and have one thread and one BLAS thread each, so that two of
them are two cores (Dask's own setting of ``OMP_NUM_THREADS`` and ``OPENBLAS_NUM_THREADS``).
"""

import logging
import multiprocessing
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from importlib.metadata import version
from itertools import islice
from typing import Any

import distributed
from dask import config
from distributed.client import FutureCancelledError

from station.results.resolve.work_item import (
    ClusterLost,
    I,
    ItemFault,
    ItemResult,
    NoCluster,
    Result,
    attempt,
    code_hash,
)

dask: Any = distributed  # its own hints are partial
Future = Any
SCHEDULER_TIMEOUT_S = 15.0  # how long a scheduler may take to answer
NO_WORKER_TIMEOUT_S = 60.0  # how long a cluster may be without any worker
POLL_PERIOD_S = 5.0
ITEMS_PER_WORKER = 4  # items a worker has waiting: enough that it never waits for us, few enough to hold no memory
PRELOAD = ("distributed", "procedures.diagnosis.diagnose", "station.files.campaign_folder")
SETTINGS = {  # of local workers
    "distributed.worker.multiprocessing-method": "forkserver",
    "distributed.nanny.pre-spawn-environ.MALLOC_TRIM_THRESHOLD_": None,  # Dask's 64 KiB costs a solve 12 %
    "distributed.worker.profile.enabled": False,  # samples our stack every 10 ms
    "distributed.admin.tick.interval": "1s",
    "distributed.admin.system-monitor.interval": "5s",
}
EXIT_CODE_WORKER_DIED = 70  # as a bug of ours ends a command: that is what kills a worker over and over


@dataclass(frozen=True, slots=True)
class DaskEngine:
    """Runs items on the workers of a client's cluster; ``is_local``: they run the same files as we."""

    client: Any
    is_local: bool

    @property
    def workers(self) -> int:
        """How many there are now."""
        return len(self.client.scheduler_info()["workers"])

    def run(self, function: Callable[[I], Result], items: Iterable[I]) -> Iterator[tuple[int, ItemResult]]:
        """Yield each answer as it arrives.

        Raise `ClusterLost` if the scheduler goes away, or all workers do and none comes back.
        """
        code = None if self.is_local else code_hash(function.__module__)
        coming, running = enumerate(items), dict[Future, int]()
        while True:
            room = max(ITEMS_PER_WORKER * self.workers, 32) - len(running)
            for i, item in islice(coming, max(room, 0)):
                running[self.client.submit(attempt, function, item, code, pure=False)] = i
            if not running:
                return
            for future in self._ended(list(running)):
                yield running.pop(future), _answer(future)

    def _ended(self, futures: list[Future]) -> set[Future]:
        """Wait until at least one ends; a cluster in which none can end is lost."""
        until = time.monotonic() + NO_WORKER_TIMEOUT_S
        while True:
            try:
                ended: set[Future] = dask.wait(futures, timeout=POLL_PERIOD_S, return_when="FIRST_COMPLETED").done
                return ended
            except TimeoutError:
                if self.client.status != "running":
                    raise ClusterLost("no scheduler any more") from None
                if self.workers:
                    until = time.monotonic() + NO_WORKER_TIMEOUT_S
                if time.monotonic() > until:
                    raise ClusterLost(f"no worker for {NO_WORKER_TIMEOUT_S:g} s") from None
            except FutureCancelledError:  # what the client does to them when its scheduler has gone
                raise ClusterLost("no scheduler any more") from None


def _answer(future: Future) -> ItemResult:
    """Return what `attempt` did, or what Dask says where it did not end: a worker died or has no code of ours."""
    if (error := future.exception()) is None:
        found: ItemResult = future.result()
        return found
    text = f"{type(error).__name__}: {' '.join(str(error).split())}; see the worker's log"
    return ItemResult(None, ItemFault(text, EXIT_CODE_WORKER_DIED, "a worker"))


@contextmanager
def local(workers: int) -> Iterator[DaskEngine]:
    """Yield an engine of ``workers`` processes of this machine.

    They are forked from one process that has imported what a solve needs, which costs each two seconds.
    """
    multiprocessing.get_context("forkserver").set_forkserver_preload(list(PRELOAD))
    with (
        config.set(SETTINGS),
        dask.LocalCluster(
            n_workers=workers,
            threads_per_worker=1,
            host="127.0.0.1",
            dashboard_address="127.0.0.1:0",  # any free port: two stations may do this at once
            memory_limit=0,  # a campaign needs what it needs; half of it on two workers kills both
            silence_logs=logging.CRITICAL,
        ) as cluster,
        dask.Client(cluster) as client,
    ):
        yield DaskEngine(client, is_local=True)


@contextmanager
def connected(address: str) -> Iterator[DaskEngine]:
    """Yield an engine of the workers at a scheduler's address.

    Raise `NoCluster` if nobody answers there, or it has no worker.
    """
    remedy = f"check --scheduler, or start it there: {'dask scheduler'!r} and {'dask worker ADDRESS'!r}"
    try:
        client = dask.Client(address, timeout=SCHEDULER_TIMEOUT_S, set_as_default=False)
    except (OSError, ValueError, TimeoutError) as error:
        found = " ".join(str(error).split())[:120]
        raise NoCluster(f"no answer at {address} ({found})", "a Dask scheduler", remedy) from error
    with client:
        try:
            client.wait_for_workers(1, timeout=SCHEDULER_TIMEOUT_S)
        except TimeoutError as error:
            raise NoCluster(f"a scheduler without a worker at {address}", "at least one", remedy) from error
        _refuse_strangers(client)
        yield DaskEngine(client, is_local=False)


def _refuse_strangers(client: Any) -> None:
    """Refuse a worker that does not have us: it could not even read what it is sent, and would leave."""
    for worker, found in client.run(version, "fog-station", on_error="return").items():
        if isinstance(found, Exception):
            raise NoCluster(f"worker {worker} without fog-station", "this station on each", "install it there")
