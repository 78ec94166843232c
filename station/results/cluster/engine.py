"""Who does the work: this process, processes of this machine, or the workers of a cluster."""

import os
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from typing import Protocol

from station.results.cluster.work_item import I, ItemResult, NoCluster, Result, attempt

EXTRA = "pip install 'fog-station[cluster]'"


class Engine(Protocol):
    """Maps a function over items; who does it and in which order changes no result."""

    @property
    def workers(self) -> int:
        """How many work now."""

    def run(self, function: Callable[[I], Result], items: Iterable[I]) -> Iterator[tuple[int, ItemResult]]:
        """Yield the place of an item and its answer as they arrive.

        ``function`` is one of a module that workers can import. Items and results should be small: send the
        name of a file, not its content.
        """


class OneProcess:
    """Does one item after the other, here."""

    workers = 1

    def run(self, function: Callable[[I], Result], items: Iterable[I]) -> Iterator[tuple[int, ItemResult]]:
        """Yield each answer in the order of the items."""
        for i, item in enumerate(items):
            yield i, attempt(function, item)


@contextmanager
def open_engine(workers: int | None = None, scheduler: str | None = None) -> Iterator[Engine]:
    """Yield an engine and close it in the end.

    Parameters
    ----------
    workers
        Processes of this machine; 1 is this one. None: as many as it has cores, 1 where Dask is not installed.
    scheduler
        The address of a Dask scheduler, ``tcp://HOST:8786``; its workers are used instead.

    Raises
    ------
    NoCluster
        If Dask is wanted and not installed, or nobody answers at the address.
    """
    is_there = find_spec("distributed") is not None
    if workers is None:
        workers = len(os.sched_getaffinity(0)) if is_there else 1
    if scheduler is None and workers == 1:
        yield OneProcess()
        return
    if not is_there:
        raise NoCluster("no dask.distributed", "it for more than one worker", f"{EXTRA} or give --workers 1")
    from station.results.cluster.dask_engine import connected, local

    with local(workers) if scheduler is None else connected(scheduler) as engine:
        yield engine
