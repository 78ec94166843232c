"""The disk of the simulated machine: full for a while, or the last thing that a killed program touched.

A kill is an exception at one write, after which nothing that the dying program's own clean-up does reaches the
disk any more: renames, removals and commits of the dead do nothing. Its locks go as the kernel lets them go.
"""

import builtins
import errno
import io
import os
import sqlite3
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from unittest.mock import patch

from sqlalchemy import event
from sqlalchemy.engine import Engine
from sqlalchemy.exc import OperationalError

from tests.year.clock import HostClock

CHANGES = ("rename", "replace", "unlink", "remove", "rmdir", "mkdir")


class Killed(BaseException):
    """The program is dead; whatever it was about to write is not written."""


class Disk:
    """``kill_at``: the write, counted from 1, at which the program dies; ``is_full``: nothing more fits."""

    def __init__(self, clock: HostClock, root: Path) -> None:
        self._clock, self._root = clock, str(root)
        self.kill_at: int | None = None
        self.is_full, self.is_dead, self.writes = False, False, 0
        self.last = ""  # what was written last

    def die(self) -> None:
        """Let the program be dead from now on."""
        self.is_dead = True
        raise Killed(self.last)

    def begin(self, kill_at: int | None) -> None:
        """Let a program begin."""
        self.kill_at, self.is_dead, self.writes = kill_at, False, 0

    @contextmanager
    def aside(self) -> Iterator[None]:
        """Let another machine write meanwhile, which no trouble of this one's reaches."""
        kept = self.kill_at, self.is_full, self.is_dead, self.writes, self.last
        self.kill_at, self.is_full, self.is_dead = None, False, False
        try:
            yield
        finally:
            self.kill_at, self.is_full, self.is_dead, self.writes, self.last = kept

    def touched(self, what: str) -> None:
        """Count a write of the program; raise what the disk has against it."""
        if self.is_dead:
            raise Killed(what)
        self.writes, self.last = self.writes + 1, what
        if self.writes == self.kill_at:
            self.die()
        if self.is_full and not what.startswith(("unlink", "remove", "rmdir")):
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), what)

    def is_ours(self, path: Any) -> bool:
        """Say whether a path is beneath what is simulated."""
        return isinstance(path, str | os.PathLike) and str(path).startswith(self._root)

    @contextmanager
    def mounted(self) -> Iterator[None]:
        """Let every write of this process go through here."""

        def committed(_connection: object) -> None:
            try:
                self.touched("commit")
            except OSError as error:
                full = sqlite3.OperationalError("database or disk is full")
                raise OperationalError("COMMIT", None, full) from error

        event.listen(Engine, "commit", committed)
        patches = [patch.object(os, name, self._change(name, getattr(os, name))) for name in CHANGES]
        patches += [
            patch.object(os, "fsync", self._fsync(os.fsync)),
            patch.object(os, "open", self._open(os.open)),
        ]
        opened = self._stream(io.open)
        patches += [patch.object(builtins, "open", opened), patch.object(io, "open", opened)]
        for each in patches:
            each.start()
        try:
            yield
        finally:
            for each in patches:
                each.stop()
            event.remove(Engine, "commit", committed)

    def _change(self, name: str, real: Callable[..., None]) -> Callable[..., None]:
        def change(path: Any, *others: Any, **options: Any) -> None:
            if self.is_ours(path):
                if self.is_dead:
                    return
                self.touched(f"{name} {Path(path).name}")
            real(path, *others, **options)
            if others and name in {"rename", "replace"} and self.is_ours(others[0]):
                os.utime(others[0], (self._clock.wall, self._clock.wall))

        return change

    def _fsync(self, real: Callable[[int], None]) -> Callable[[int], None]:
        def fsync(descriptor: int) -> None:
            if not self.is_dead:
                self.touched("fsync")  # what it would cost stays in the page cache, which a kill spares

        return fsync

    def _open(self, real: Callable[..., int]) -> Callable[..., int]:
        def opened(path: Any, flags: int, *others: Any, **options: Any) -> int:
            if flags & (os.O_WRONLY | os.O_RDWR | os.O_CREAT) and self.is_ours(path):
                self.touched(f"open {Path(path).name}")
            return real(path, flags, *others, **options)

        return opened

    def _stream(self, real: Callable[..., Any]) -> Callable[..., Any]:
        def opened(file: Any, mode: str = "r", *others: Any, **options: Any) -> Any:
            if set(mode) & set("wxa+") and self.is_ours(file):
                self.touched(f"open {Path(file).name}")
            return real(file, mode, *others, **options)

        return opened
