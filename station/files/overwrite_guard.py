"""What is read is not written over, nor one result by another."""

from collections.abc import Iterable
from pathlib import Path

from station.errors import CannotWrite


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
