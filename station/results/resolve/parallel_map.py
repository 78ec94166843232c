"""A function mapped over items by this process, processes of this machine or the workers of a cluster.

Each result is kept as it arrives, so a run that was killed continues where it was. Progress goes to stderr.
"""

import json
import os
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any, Generic, TextIO, TypeAlias

from fixtures_db.folder_on_disk import make_folder
from fixtures_db.hash_chain import canonical, digest
from procedures.optional_libraries import install_command
from station.errors import cannot_write
from station.files.atomic_file import replace_file
from station.results.resolve.work_item import I, ItemResult, NoCluster, Result, attempt, code_hash

if TYPE_CHECKING:
    from station.results.resolve.dask_engine import DaskEngine


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

    ``workers`` are processes of this machine; 1 is this one, None as many as it has cores, 1 where Dask is not
    installed. ``scheduler`` is the address of a Dask scheduler, ``tcp://HOST:8786``, whose workers are used
    instead.

    Raise `NoCluster` if Dask is wanted and not installed, or nobody answers at the address.
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
    from station.results.resolve.dask_engine import connected, local

    with local(workers) if scheduler is None else connected(scheduler) as engine:
        yield engine


FORMAT = "kept/1"


@dataclass(frozen=True, slots=True)
class Finished(Generic[I]):
    """An item's place among the items, its answer, and whether an earlier run had kept it."""

    index: int
    item: I
    answer: ItemResult
    was_kept: bool


def map_restartable(
    function: Callable[[I], Result],
    items: Sequence[I],
    key: Callable[[I], object],
    folder: Path | None,
    engine: Engine,
) -> Iterator[Finished[I]]:
    """Yield what ``function`` makes of each item: kept ones first, then the others as they arrive.

    ``function`` is of a module that workers can import and returns what JSON can hold, finite. What it computes
    depends on the item alone (seeds are part of it), so that no number depends on who computes it or when. ``key``
    has all that the result depends on in addition to the code: hashes of files, seeds. Results are kept in
    ``folder``, a file each, None keeps none; it may be deleted at any time. Faults are not kept: a second run
    tries those items again. Raise `CannotWrite` if a result cannot be kept.
    """
    code, name = code_hash(function.__module__), f"{function.__module__}.{function.__qualname__}"
    keys = [digest(canonical({"code": code, "function": name, "of": key(item)})) for item in items]
    todo = list[int]()
    for index, item in enumerate(items):
        if (kept := _kept(folder, keys[index])) is None:
            todo.append(index)
        else:
            yield Finished(index, item, ItemResult(kept), was_kept=True)
    for place, answer in engine.run(function, [items[index] for index in todo]):
        index = todo[place]
        if folder is not None and answer.result is not None:
            _keep(folder, keys[index], answer.result)
        yield Finished(index, items[index], answer, was_kept=False)


def _kept(folder: Path | None, key: str) -> Result | None:
    """Return a kept result; None if there is none, or not one that was written for this key."""
    if folder is None:
        return None
    try:
        document = json.loads((folder / f"{key}.json").read_bytes())
        result: Result = document["result"]
        return result if document == _sealed(key, result) else None
    except (OSError, ValueError, KeyError, TypeError):
        return None


def _keep(folder: Path, key: str, result: Result) -> None:
    try:
        make_folder(folder)
    except OSError as error:
        raise cannot_write(folder, error) from error
    replace_file(folder / f"{key}.json", json.dumps(_sealed(key, result), allow_nan=False).encode())


def _sealed(key: str, result: Result) -> dict[str, Any]:
    return {"format": FORMAT, "key": key, "sha256": digest(canonical(dict(result))), "result": result}


TERMINAL_PERIOD_S = 0.2  # a terminal needs no more
LOG_PERIOD_S = 10.0  # between lines of a log


class Progress:
    """Counts items that end, some of which were kept from an earlier run."""

    def __init__(self, stream: TextIO, title: str, total: int, now: Callable[[], float] = time.monotonic) -> None:
        self._stream, self._title, self._total, self._now = stream, title, total, now
        self._began = self._shown_at = now()
        self._done = self._kept = self._faults = 0

    def advance(self, *, was_kept: bool = False, is_fault: bool = False) -> None:
        """Count an item."""
        self._done += 1
        self._kept += was_kept
        self._faults += is_fault
        is_terminal, now = self._stream.isatty(), self._now()
        if self._done == self._total or now - self._shown_at >= (
            TERMINAL_PERIOD_S if is_terminal else LOG_PERIOD_S
        ):
            self._shown_at = now
            self._stream.write(f"\r\x1b[K{self}" if is_terminal else f"{self}\n")
            self._stream.flush()

    def end(self) -> None:
        """Take the line off a terminal."""
        if self._stream.isatty():
            self._stream.write("\r\x1b[K")
            self._stream.flush()

    def __str__(self) -> str:
        text = [f"{self._title}: {self._done} of {self._total}"]
        if self._kept:
            text.append(f"{self._kept} kept")
        if self._faults:
            text.append(f"{self._faults} refused")
        worked, left = self._done - self._kept, self._total - self._done
        if worked and left:
            seconds = (self._now() - self._began) / worked * left
            text.append(f"{seconds:.0f} s left" if seconds < 100 else f"{seconds / 60:.0f} min left")
        return ", ".join(text)
