"""A file and what is to know of it, put in their places together: never one beside the other of another time."""

import os
import secrets
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from fixtures_db.folder_on_disk import sync_folder
from station.errors import CannotWrite, cannot_write


@contextmanager
def write_file_pair(out: Path, beside: Path) -> Iterator[tuple[Path, Path]]:
    """Give places to write a file, or a folder, and its companion to, under their names in a folder of their own.

    At the end they are put in their places, unless something is raised. What stood beside ``out`` goes first, and
    its companion comes last: one that is cut off leaves a file that nothing is said of, none that it is not of.

    Raises
    ------
    CannotWrite
        If a place cannot be written, or is a folder.
    """
    for path in (out, beside):
        if path.is_dir():
            raise CannotWrite(path, "a folder of this name is there")
    aside = out.with_name(f".{out.name}.{secrets.token_hex(6)}.tmp")
    try:
        aside.mkdir()
        yield aside / out.name, aside / beside.name
        sync_folder(aside)
        if beside.exists():
            beside.unlink()
            sync_folder(out.parent)  # or a power cut may leave it beside the new one
        for path in (out, beside):
            os.replace(aside / path.name, path)
            sync_folder(out.parent)
    except OSError as error:
        raise error if isinstance(error, CannotWrite) else cannot_write(out, error) from error
    finally:
        shutil.rmtree(aside, ignore_errors=True)
