"""What is read is not written over."""

from collections.abc import Iterable
from pathlib import Path

from station.errors import CannotWrite


def refuse_own(outputs: Iterable[Path | None], inputs: Iterable[Path]) -> None:
    """Refuse to write over a file that is read, by whatever path it is named.

    Raises
    ------
    CannotWrite
        If an output is one of the inputs.
    """
    read = {path.resolve() for path in inputs if path.is_file()}
    for path in outputs:
        if path is not None and path.resolve() in read:
            raise CannotWrite(path, "it is read here and would be lost")
