"""A campaign's folder at its beginning: made, or taken away again if the campaign did not come about."""

from collections.abc import Iterator
from contextlib import contextmanager
from datetime import UTC, datetime
from pathlib import Path

from station.errors import CannotWrite, cannot_write


@contextmanager
def new_folder(folder: Path, sign: str) -> Iterator[Path]:
    """Make a folder; take it away again, with all that came into it, if no file named ``sign`` did.

    Raises
    ------
    CannotWrite
        If it cannot be made or is not empty.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        if any(folder.iterdir()):
            raise CannotWrite(folder, "it is not empty, expected a new folder")
    except OSError as error:
        if isinstance(error, CannotWrite):
            raise
        raise cannot_write(folder, error) from error
    try:
        yield folder
    finally:
        if not (folder / sign).exists():
            for file in folder.iterdir():
                file.unlink()
            folder.rmdir()


def journal_path(folder: Path) -> Path:
    """Return where a new session's journal goes."""
    return folder / f"session_{datetime.now(UTC):%Y%m%dT%H%M%S%fZ}.mcap"
