"""One item of the work, done where it is sent: what came of it, or why nothing did; and why all of it ends.

StationError
├── NoCluster          the extra is not installed, or nobody answers at the scheduler's address
└── ClusterLost        a cluster that answered was lost during the run
"""

import socket
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, TypeVar

from procedures.error_codes import ErrorCode
from station.errors import StationError
from station.results.cluster.code_hash import code_hash

I = TypeVar("I")  # noqa: E741
Result = Mapping[str, Any]


class NoCluster(StationError, ConnectionError):
    """There is no cluster to work on."""

    code = ErrorCode.CLUSTER

    def __init__(self, found: str, expected: str, remedy: str) -> None:
        self.found, self.expected = found, expected
        super().__init__(f"found {found}, expected {expected}; {remedy}")


class ClusterLost(StationError, ConnectionError):
    """The cluster went away; what had arrived is kept."""

    code = ErrorCode.CLUSTER

    def __init__(self, found: str) -> None:
        self.found = found
        super().__init__(
            f"found {found}, expected a cluster to the end; start it again and repeat the command: it goes on"
        )


@dataclass(frozen=True, slots=True)
class ItemFault:
    """Why there is no result: one line, the exit code a command would end with, and the machine that said so."""

    text: str
    code: int
    host: str


@dataclass(frozen=True, slots=True)
class ItemResult:
    """The result of a function, or the fault that stands in its place."""

    result: Result | None
    fault: ItemFault | None = None


def attempt(function: Callable[[I], Result], item: I, code: str | None = None) -> ItemResult:
    """Call ``function``; whatever it raises becomes a fault, so that one item never stops the others.

    ``code`` is the `code_hash` of whoever asks from another machine: a worker with other code would give other
    numbers, and refuses. None asks no such thing.
    """
    from station.exit_codes import explain, one_line

    host = socket.gethostname()
    try:
        if code is not None and (found := code_hash(function.__module__)) != code:
            remedy = "install the same station, numpy, scipy and numba there"
            text = f"found code {found[:12]} on {host}, expected {code[:12]}; {remedy}"
            return ItemResult(None, ItemFault(text, 2, host))
        return ItemResult(function(item))
    except Exception as error:  # the edge of a worker: an exception of ours does not survive pickling
        said, text = explain(error)
        return ItemResult(None, ItemFault(one_line(text), said, host))
