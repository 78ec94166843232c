"""Files that are there whole or not at all: written under another name, synced, then renamed.

Also pairs of files, new folders and free names, and how often a growing file is flushed.
"""

import csv
import json
import os
import secrets
import shutil
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from datetime import UTC, datetime
from itertools import chain, count
from pathlib import Path
from typing import Any

from fixtures_db.folder_on_disk import make_folder, sync_file, sync_folder
from station.errors import CannotWrite, cannot_write


def replace_file(path: Path, content: bytes) -> None:
    """Put ``content`` at ``path``, on the disk when this returns; what stood there is kept until then.

    Raise `CannotWrite` if the place cannot be written.
    """
    try:
        if path.exists() and not path.is_file():  # /dev/stdout, a pipe: nothing to replace
            path.write_bytes(content)
            return
        aside = path.with_name(f".{path.name}.{secrets.token_hex(6)}.tmp")
        try:
            with aside.open("xb") as stream:
                stream.write(content)
                sync_file(stream)
            os.replace(aside, path)
        finally:
            aside.unlink(missing_ok=True)
        sync_folder(path.parent)
    except OSError as error:
        raise cannot_write(path, error, len(content)) from error


def replace_files(contents: Mapping[Path, bytes]) -> None:
    """Put several files of one folder in their places: all are on the disk before the first is renamed.

    The folder is made if what it stands in is there. Raise `CannotWrite` if a place cannot be written; then none
    is.
    """
    aside = {path: path.with_name(f".{path.name}.{secrets.token_hex(6)}.tmp") for path in contents}
    path = next(iter(contents)).parent
    try:
        if not path.is_dir():
            path.mkdir()
            sync_folder(path.parent)
        for path, content in contents.items():
            if path.exists() and not path.is_file():
                raise CannotWrite(path, "it is no file")
            with aside[path].open("xb") as stream:
                stream.write(content)
                sync_file(stream)
        for path in contents:
            os.replace(aside[path], path)
        sync_folder(path.parent)
    except CannotWrite:
        raise
    except OSError as error:
        raise cannot_write(path, error, sum(map(len, contents.values()))) from error
    finally:
        for each in aside.values():
            each.unlink(missing_ok=True)


def add_rows(path: Path, header: Iterable[str], rows: Iterable[Iterable[object]]) -> None:
    """Add rows to a CSV file, which begins with its header; raise `CannotWrite` if the disk refuses."""
    try:
        is_new = not path.exists()
        with path.open("a", newline="", encoding="utf-8") as stream:
            csv.writer(stream).writerows([header, *rows] if is_new else rows)
    except OSError as error:
        raise cannot_write(path, error) from error


def write_json(path: Path, document: Mapping[str, Any]) -> None:
    """Put a document at ``path`` as `replace_file` does; NaN and infinity are a `ValueError`."""
    replace_file(path, (json.dumps(document, indent=1, allow_nan=False, ensure_ascii=False) + "\n").encode())


def refuse_own(outputs: Iterable[Path | None], inputs: Iterable[Path]) -> None:
    """Refuse to write over a file that is read, or one result over another, by whatever path it is named.

    Raise `CannotWrite` if an output is one of the inputs, or another output.
    """
    read = {path.resolve() for path in inputs if path.is_file()}
    written = set[Path]()
    for path in (path for path in outputs if path is not None):
        if path.resolve() in read:
            raise CannotWrite(path, "it is read here and would be lost")
        if path.resolve() in written and (path.is_file() or not path.exists()):  # a terminal takes both
            raise CannotWrite(path, "another result goes there")
        written.add(path.resolve())


@contextmanager
def write_file_pair(out: Path, second: Path) -> Iterator[tuple[Path, Path]]:
    """Give places to write a file, or a folder, and its companion to, under their names in a folder of their own.

    At the end they are put in their places, unless something is raised. What stood next to ``out`` goes first, and
    its companion comes last: one that is cut off leaves a file that nothing is stated of, none that it is not of.
    Raise `CannotWrite` if a place cannot be written, or is a folder.
    """
    for path in (out, second):
        if path.is_dir():
            raise CannotWrite(path, "a folder of this name is there")
    aside = out.with_name(f".{out.name}.{secrets.token_hex(6)}.tmp")
    try:
        aside.mkdir()
        yield aside / out.name, aside / second.name
        sync_folder(aside)
        if second.exists():
            second.unlink()
            sync_folder(out.parent)  # or a power cut may leave it alongside the new one
        for path in (out, second):
            os.replace(aside / path.name, path)
            sync_folder(out.parent)
    except OSError as error:
        raise error if isinstance(error, CannotWrite) else cannot_write(out, error) from error
    finally:
        shutil.rmtree(aside, ignore_errors=True)


@contextmanager
def new_folder(
    folder: Path, sign: str, is_free: Callable[[Sequence[str]], bool] = lambda names: not names
) -> Iterator[Path]:
    """Make a folder; take it away again, with all that came into it, if no file named ``sign`` did.

    One that is there already must be empty, or ``is_free`` says of the names in it that they are what a killed
    program had begun with; such a one is not taken away. Raise `CannotWrite` if it cannot be made or is not empty.
    """
    try:
        make_folder(folder)
        there = [file.name for file in folder.iterdir()]
        if there and not is_free(there):
            raise CannotWrite(folder, "it is not empty, expected a new folder")
    except OSError as error:
        if isinstance(error, CannotWrite):
            raise
        raise cannot_write(folder, error) from error
    try:
        yield folder
    finally:
        if not there and not (folder / sign).exists():
            for file in folder.iterdir():
                file.unlink()
            folder.rmdir()


def recording_path(folder: Path, name: str = "session") -> Path:
    """Return where what is read from now on goes."""
    return folder / f"{name}_{datetime.now(UTC):%Y%m%dT%H%M%S%fZ}.mcap"


def free_path(folder: Path, name: str) -> Path:
    """Return where ``name.mcap`` goes; ``name_2.mcap`` and so on where that is there already."""
    numbered = chain([name], (f"{name}_{number}" for number in count(2)))
    return next(path for stem in numbered if not (path := folder / f"{stem}.mcap").exists())


class FlushInterval:
    """Flushes every ``period_s``, or after as long as the last one took: else nothing else would be done."""

    def __init__(self, period_s: float) -> None:
        self._period_s = period_s
        self._due = time.monotonic() + period_s

    @property
    def is_due(self) -> bool:
        """Whether to flush now."""
        return time.monotonic() >= self._due

    @contextmanager
    def flushing(self) -> Iterator[None]:
        """Time a flush."""
        began = time.monotonic()
        yield
        now = time.monotonic()
        self._due = now + max(self._period_s, now - began)
