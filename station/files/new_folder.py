"""A campaign's folder at its beginning: made, or taken away again if the campaign did not come about."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from datetime import UTC, datetime
from itertools import chain, count
from pathlib import Path

from fixtures_db.folder_on_disk import make_folder
from station.errors import CannotWrite, cannot_write


@contextmanager
def new_folder(
    folder: Path, sign: str, is_free: Callable[[Sequence[str]], bool] = lambda names: not names
) -> Iterator[Path]:
    """Make a folder; take it away again, with all that came into it, if no file named ``sign`` did.

    One that is there already must be empty, or ``is_free`` says of the names in it that they are what a killed
    program had begun with; such a one is not taken away.

    Raises
    ------
    CannotWrite
        If it cannot be made or is not empty.
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


def journal_path(folder: Path, name: str = "session") -> Path:
    """Return where what is read from now on goes."""
    return folder / f"{name}_{datetime.now(UTC):%Y%m%dT%H%M%S%fZ}.mcap"


def free_path(folder: Path, name: str) -> Path:
    """Return where ``name.mcap`` goes; ``name_2.mcap`` and so on where that is there already."""
    numbered = chain([name], (f"{name}_{number}" for number in count(2)))
    return next(path for stem in numbered if not (path := folder / f"{stem}.mcap").exists())
