"""What a program did to its files, in order: the words that a trace is told in and a power cut is drawn from.

A node is a file or a folder; 0 is the root, a folder that was there and on the disk before.
"""

from collections.abc import Iterable
from dataclasses import dataclass

ROOT = 0


@dataclass(frozen=True, slots=True)
class Write:
    """Bytes put into a file."""

    node: int
    offset: int
    data: bytes


@dataclass(frozen=True, slots=True)
class Resize:
    """A file cut or extended by zeros to a size."""

    node: int
    size: int


@dataclass(frozen=True, slots=True)
class Entries:
    """Names set in folders, all at once: (folder, name, node), the node None where the name goes."""

    changes: tuple[tuple[int, str, int | None], ...]


@dataclass(frozen=True, slots=True)
class Sync:
    """A file or folder that is on the disk with all that was done to it before operation ``began``."""

    node: int
    began: int


@dataclass(frozen=True, slots=True)
class Say:
    """What the program said on its standard output: from here on people rely on it."""

    text: str


Operation = Write | Resize | Entries | Sync | Say


@dataclass(frozen=True, slots=True)
class FileLog:
    """Operations, and which nodes are folders."""

    operations: tuple[Operation, ...]
    folders: frozenset[int]


def changed(content: bytes, operations: Iterable[Write | Resize]) -> bytes:
    """Return a file's content after operations."""
    made = bytearray(content)
    for one in operations:
        size = one.size if isinstance(one, Resize) else one.offset
        if len(made) < size:
            made.extend(bytes(size - len(made)))
        if isinstance(one, Resize):
            del made[size:]
        else:
            made[size : size + len(one.data)] = one.data
    return bytes(made)
