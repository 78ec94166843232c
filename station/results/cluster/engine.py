"""Who does the work: this process, processes of this machine, or the workers of a cluster."""

import os
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from typing import TYPE_CHECKING, TypeAlias

from procedures.optional_libraries import install_command
from station.results.cluster.work_item import I, ItemResult, NoCluster, Result, attempt

if TYPE_CHECKING:
    from station.results.cluster.dask_engine import DaskEngine


class OneProcess:
    """Does one item after the other, here."""

    workers = 1

    def run(self, function: Callable[[I], Result], items: Iterable[I]) -> Iterator[tuple[int, ItemResult]]:
        """Yield the place of each item and its answer, in the order of the items.

        ``function`` is one of a module that workers can import. Items and results should be small: send the
        name of a file, not its content.
        """
        for i, item in enumerate(items):
            yield i, attempt(function, item)


Engine: TypeAlias = "OneProcess | DaskEngine"  # which, and in which order it works, changes no result


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
        raise NoCluster(
            "no dask.distributed",
            "it for more than one worker",
            f"{install_command('cluster')} or give --workers 1",
        )
    from station.results.cluster.dask_engine import connected, local

    with local(workers) if scheduler is None else connected(scheduler) as engine:
        yield engine
