"""What a disk may hold after a power cut: the states that a file system is free to leave.

``weak`` is what POSIX promises and no more: a file's bytes are kept from its fsync on, a folder's names from the
folder's own; what was done since is kept or lost piece by piece, writes by sectors of 512 bytes, sizes without
bytes (zeros), names in any order, a rename as a whole. ``ordered`` is ext4 with data=ordered: names are kept in
the order in which they were changed, any fsync keeps all of them that came before, a grown file is a beginning of
what was written, and pages of 4096 bytes written over may be old or new.

Source: Pillai et al., All File Systems Are Not Created Equal, OSDI 2014, section 3 (abstract persistence models);
Linux kernel documentation, ext4 general information, data mode.
"""

import random
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field

ROOT = 0  # the node of a folder that was there, and on the disk, before; a node is a file or a folder
SECTOR, PAGE = 512, 4096
MODELS = ("weak", "ordered")
SETTLED = '"settled"'


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
Change = Write | Resize
Names = dict[tuple[int, str], int | None]


@dataclass(frozen=True, slots=True)
class FileLog:
    """Operations, and which nodes are folders."""

    operations: tuple[Operation, ...]
    folders: frozenset[int]


def changed(content: bytes, operations: Iterable[Change]) -> bytes:
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


@dataclass(slots=True)
class Disk:
    """What is certainly on the disk, and what is not yet: by node its changes, and the changes of names."""

    content: dict[int, bytes] = field(default_factory=dict)
    waiting: dict[int, list[tuple[int, Change]]] = field(default_factory=dict)
    names: dict[str, Names] = field(default_factory=lambda: {model: {} for model in MODELS})
    renamed: dict[str, list[tuple[int, Entries]]] = field(default_factory=lambda: {model: [] for model in MODELS})
    live: Names = field(default_factory=dict)
    # as of the sync before the last: that of its folder is over too
    promised: dict[int, bytes] = field(default_factory=dict)

    def take(self, number: int, operation: Operation, folders: frozenset[int]) -> None:
        """Take an operation, the ``number``-th."""
        match operation:
            case Write(node) | Resize(node):
                self.waiting.setdefault(node, []).append((number, operation))
            case Entries():
                for waiting in self.renamed.values():
                    waiting.append((number, operation))
                _apply(self.live, [(number, operation)])
            case Sync(node, began):
                self._sync(node, began, folders)

    def _sync(self, node: int, began: int, folders: frozenset[int]) -> None:
        if node in folders:
            self._keep("weak", lambda one: one[0] < began and any(f == node for f, _, _ in one[1].changes))
        else:
            waiting = self.waiting.pop(node, [])
            if node in self.content:
                self.promised[node] = self.content[node]
            done = [change for number, change in waiting if number < began]
            self.content[node] = changed(self.content.get(node, b""), done)
            if len(done) < len(waiting):
                self.waiting[node] = [one for one in waiting if one[0] >= began]
        self._keep("ordered", lambda one: one[0] < began)

    def _keep(self, model: str, is_kept: Callable[[tuple[int, Entries]], bool]) -> None:
        waiting = self.renamed[model]
        _apply(self.names[model], filter(is_kept, waiting))
        self.renamed[model] = [one for one in waiting if not is_kept(one)]

    def settle(self, number: int, folders: frozenset[int]) -> None:
        """Put everything on the disk."""
        for node in (*folders, *self.waiting):
            self._sync(node, number + 1, folders)

    @property
    def is_settled(self) -> bool:
        """Say whether nothing is left to lose."""
        return not (self.waiting or any(self.renamed.values()))


def _apply(names: Names, changes: Iterable[tuple[int, Entries]]) -> None:
    for _, entries in changes:
        for folder, name, node in entries.changes:
            names[folder, name] = node


@dataclass(frozen=True, slots=True)
class CrashState:
    """A state of the disk after a power cut at operation ``cut``, and what had been said by then."""

    cut: int
    model: str
    kept: str
    files: dict[str, bytes | None]
    reported: tuple[str, ...]
    synced: dict[str, bytes]


def crash_states(log: FileLog, seed: int, draws: int, every: int = 1) -> Iterator[CrashState]:
    """Yield states after a cut behind each operation: all kept, none kept, and ``draws`` at random, each model.

    Of the cuts only each ``every``-th, from where the program says that all is settled, if it does.
    """
    disk, reported, rng = Disk(), list[str](), random.Random(seed)
    begins = next((n for n, one in enumerate(log.operations) if isinstance(one, Say) and SETTLED in one.text), 0)
    offset = rng.randrange(every)
    for number, operation in enumerate(log.operations):
        disk.take(number, operation, log.folders)
        if isinstance(operation, Say):
            reported.append(operation.text)
        if number < begins:
            continue
        if number == begins and begins:
            disk.settle(number, log.folders)
        if number % every != offset and number < len(log.operations) - 1:
            continue
        there, promised = _paths(disk.live, log.folders), disk.promised
        synced = {path: promised[node] for path, node in there if node in promised}
        for model in MODELS:
            for kept in ("all", "none", *("some" for _ in range(0 if disk.is_settled else draws))):
                files = _files(disk, model, kept, log.folders, rng)
                yield CrashState(number, model, kept, files, tuple(reported), synced)


def _paths(names: Names, folders: frozenset[int]) -> Iterator[tuple[str, int]]:
    """Yield path and node of all that can be reached, folders before what is in them."""
    children = dict[int, list[tuple[str, int]]]()
    for (folder, name), node in names.items():
        if node is not None:
            children.setdefault(folder, []).append((name, node))
    to_look = [("", ROOT)]
    while to_look:
        path, folder = to_look.pop()
        for name, node in children.get(folder, []):
            yield path + name, node
            if node in folders:
                to_look.append((f"{path}{name}/", node))


def _files(
    disk: Disk, model: str, kept: str, folders: frozenset[int], rng: random.Random
) -> dict[str, bytes | None]:
    """Return the files of a state by path, None for a folder."""
    names, waiting = dict(disk.names[model]), disk.renamed[model]
    _apply(names, waiting if kept == "all" else [] if kept == "none" else _some_names(waiting, model, rng))
    found = dict[str, bytes | None]()
    for path, node in _paths(names, folders):
        changes = [change for _, change in disk.waiting.get(node, [])]
        base = disk.content.get(node, b"")
        found[path] = None if node in folders else _content(base, changes, model, kept, rng)
    return found


def _some_names(waiting: list[tuple[int, Entries]], model: str, rng: random.Random) -> list[tuple[int, Entries]]:
    if model == "ordered" or rng.random() < 0.3:
        return waiting[: rng.randint(0, len(waiting))]
    way = rng.randrange(4)
    if way < 2:
        return [] if way else waiting
    if way == 2 and waiting:  # one alone is lost
        lost = rng.randrange(len(waiting))
        return [*waiting[:lost], *waiting[lost + 1 :]]
    return [one for one in waiting if rng.random() < 0.5]


def _content(base: bytes, changes: list[Change], model: str, kept: str, rng: random.Random) -> bytes:
    if not changes or kept == "none":
        return base
    if kept == "some":
        changes = _some_changes(base, changes, model, rng)
    return changed(base, changes)


def _some_changes(base: bytes, changes: list[Change], model: str, rng: random.Random) -> list[Change]:
    """Return what of a file's changes reached the disk."""
    if model == "ordered":
        return _in_order(base, changes, rng)
    way = rng.randrange(6)
    if way < 2:
        return [] if way else changes
    if way == 2:  # a beginning, the last of it torn
        return _torn(changes[: rng.randint(1, len(changes))], SECTOR, rng)
    if way == 3:  # the size alone
        end = max(c.size if isinstance(c, Resize) else c.offset + len(c.data) for c in changes)
        return [Resize(changes[0].node, max(len(base), end))]
    if way == 4:  # any of them
        return [change for change in changes if rng.random() < 0.5]
    return [piece for change in changes for piece in _pieces(change, SECTOR) if rng.random() < 0.7]


def _torn(changes: list[Change], size: int, rng: random.Random) -> list[Change]:
    pieces = list(_pieces(changes[-1], size))
    return [*changes[:-1], *pieces[: rng.randint(0, len(pieces))]]


def _in_order(base: bytes, changes: list[Change], rng: random.Random) -> list[Change]:
    """Return a beginning of what was appended or resized, and any pages of what was written over."""
    grown = [c for c in changes if isinstance(c, Resize) or c.offset + len(c.data) > len(base)]
    over = [c for c in changes if isinstance(c, Write) and c.offset + len(c.data) <= len(base)]
    kept = _torn(grown[: rng.randint(1, len(grown))], PAGE, rng) if grown else []
    return [*(piece for c in over for piece in _pieces(c, PAGE) if rng.random() < 0.5), *kept]


def _pieces(change: Change, size: int) -> Iterator[Change]:
    """Yield a write cut at multiples of ``size`` in the file."""
    if isinstance(change, Resize):
        yield change
        return
    at, end = change.offset, change.offset + len(change.data)
    while at < end:
        to = min(end, (at // size + 1) * size)
        yield Write(change.node, at, change.data[at - change.offset : to - change.offset])
        at = to
