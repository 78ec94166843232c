"""Files that are there whole or not at all: written aside, synced, then renamed into place.

What is read is not written over, nor one result by another.
"""

import json
import os
import secrets
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from fixtures_db.folder_on_disk import sync_folder
from station.errors import CannotWrite, cannot_write


def replace_file(path: Path, content: bytes) -> None:
    """Put ``content`` at ``path``, on the disk when this returns; what stood there is kept until then.

    Raises
    ------
    CannotWrite
        If the place cannot be written.
    """
    try:
        if path.exists() and not path.is_file():  # /dev/stdout, a pipe: nothing to replace
            path.write_bytes(content)
            return
        aside = path.with_name(f".{path.name}.{secrets.token_hex(6)}.tmp")
        try:
            with aside.open("xb") as stream:
                stream.write(content)
                stream.flush()
                os.fsync(stream.fileno())
            os.replace(aside, path)
        finally:
            aside.unlink(missing_ok=True)
        sync_folder(path.parent)
    except OSError as error:
        raise cannot_write(path, error, len(content)) from error


def replace_files(contents: Mapping[Path, bytes]) -> None:
    """Put several files of one folder in their places: all are on the disk before the first is renamed.

    The folder is made if what it stands in is there.

    Raises
    ------
    CannotWrite
        If a place cannot be written; then none is.
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
                stream.flush()
                os.fsync(stream.fileno())
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


def write_json(path: Path, document: Mapping[str, Any]) -> None:
    """Put a document at ``path`` as `replace_file` does; NaN and infinity are a `ValueError`."""
    replace_file(path, (json.dumps(document, indent=1, allow_nan=False, ensure_ascii=False) + "\n").encode())


def refuse_own(outputs: Iterable[Path | None], inputs: Iterable[Path]) -> None:
    """Refuse to write over a file that is read, or one result over another, by whatever path it is named.

    Raises
    ------
    CannotWrite
        If an output is one of the inputs, or another output.
    """
    read = {path.resolve() for path in inputs if path.is_file()}
    written = set[Path]()
    for path in (path for path in outputs if path is not None):
        if path.resolve() in read:
            raise CannotWrite(path, "it is read here and would be lost")
        if path.resolve() in written and (path.is_file() or not path.exists()):  # a terminal takes both
            raise CannotWrite(path, "another result goes there")
        written.add(path.resolve())
