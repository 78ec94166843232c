"""One item of parallel work, done where it is sent, with the hash of the code that its result depends on.

Its result is a value, or why there is none.
"""

import hashlib
import importlib.util
import socket
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any, TypeVar

from procedures.errors import ErrorCode
from station.errors import StationError

PACKAGES = ("procedures", "drivers", "fixtures_db", "station")
LIBRARIES = ("numpy", "scipy", "numba")


@cache
def code_hash(module: str) -> str:
    """Return the SHA-256 [hex] of the code that a function of ``module`` may run."""
    total = hashlib.sha256(f"python {sys.version_info[:2]}".encode())
    for library in LIBRARIES:
        total.update(f"\n{library} {version(library)}".encode())
    root = Path(__file__).resolve().parents[3]
    files = [(str(path.relative_to(root)), path) for name in PACKAGES for path in (root / name).rglob("*.py")]
    for name, path in [*sorted(files), (module, _source(module))]:
        total.update(f"\n{name} {hashlib.sha256(path.read_bytes()).hexdigest()}".encode())
    return total.hexdigest()


def _source(module: str) -> Path:
    spec = importlib.util.find_spec(module)
    if module == "__main__" or spec is None or spec.origin is None:
        raise ValueError(f"module {module!r} has no file: expected a function of one that workers can import")
    return Path(spec.origin)


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
    """Why there is no result: one line, the exit code a command would end with, and the machine that sent it."""

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
    from station.errors import explain, one_line

    host = socket.gethostname()
    try:
        if code is not None and (found := code_hash(function.__module__)) != code:
            remedy = "install the same station, numpy, scipy and numba there"
            text = f"found code {found[:12]} on {host}, expected {code[:12]}; {remedy}"
            return ItemResult(None, ItemFault(text, 2, host))
        return ItemResult(function(item))
    except Exception as error:  # the edge of a worker: an exception of ours does not survive pickling
        wording, text = explain(error)
        return ItemResult(None, ItemFault(one_line(text), wording, host))
