"""One item of the work, done where it is sent: what came of it, or why nothing did, as small data."""

import socket
from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, TypeVar

from station.results.cluster.code_hash import code_hash

I = TypeVar("I")  # noqa: E741
R = TypeVar("R")


@dataclass(frozen=True, slots=True)
class ItemFault:
    """Why there is no result: one line, the exit code a command would end with, and the machine that said so."""

    text: str
    code: int
    host: str


@dataclass(frozen=True, slots=True)
class ItemResult(Generic[R]):
    """The result of a function, or the fault that stands in its place."""

    result: R | None
    fault: ItemFault | None = None


def attempt(function: Callable[[I], R], item: I, code: str | None = None) -> ItemResult[R]:
    """Call ``function``; whatever it raises becomes a fault, so that one item never stops the others.

    ``code`` is the `code_hash` of whoever asks from another machine: a worker with other code would give other
    numbers, and refuses. None asks no such thing.
    """
    from station.exit_codes import explain, one_line

    host = socket.gethostname()
    try:
        if code is not None and (found := code_hash(function.__module__)) != code:
            remedy = "install the same station, numpy, scipy and numba there"
            return ItemResult(
                None, ItemFault(f"found code {found[:12]} on {host}, expected {code[:12]}; {remedy}", 2, host)
            )
        return ItemResult(function(item))
    except Exception as error:  # the edge of a worker: an exception of ours does not survive pickling
        said, text = explain(error)
        return ItemResult(None, ItemFault(one_line(text), said, host))
