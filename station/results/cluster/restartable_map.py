"""A function mapped over items, each result kept as it arrives: a run that was killed goes on where it was."""

import json
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Generic

from fixtures_db.folder_on_disk import make_folder
from fixtures_db.hash_chain import canonical, digest
from station.errors import cannot_write
from station.files.atomic_file import replace_file
from station.results.cluster.code_hash import code_hash
from station.results.cluster.engine import Engine
from station.results.cluster.work_item import I, ItemResult, Result

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

    Parameters
    ----------
    function
        Of a module that workers can import; returns what JSON can hold, finite. What it computes depends on the
        item alone (seeds are part of it), so that no number depends on who computes it or when.
    key
        All that the result of an item depends on beside the code, as JSON can hold it: hashes of files, seeds.
    folder
        Where results are kept, a file each; None keeps none. It may be deleted at any time.

    Raises
    ------
    CannotWrite
        If a result cannot be kept.

    Faults are not kept: a second run tries those items again.
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
