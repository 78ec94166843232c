"""A simulated unit's truth as a file, and refusals of the simulator that name the file they came from."""

import contextlib
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from drivers.simulated.truth import Truth


def read_truth(path: Path) -> "Truth":
    """Read a truth; raise `DataRefused` if it is none."""
    from drivers.simulated.truth import load_truth

    with blamed_on(path):
        return load_truth(read_text(path))


@contextlib.contextmanager
def blamed_on(file: Path | None) -> Iterator[None]:
    """Have what the simulator refuses name the file it came from."""
    from drivers.errors import SimulatorError, TruthRefused, UnknownEffect
    from station.errors import DataRefused

    try:
        yield
    except TruthRefused as error:
        raise DataRefused(file or "truth", None, error.found, error.expected) from error
    except UnknownEffect as error:
        accepted = f"one of {', '.join(error.accepted)}"
        raise DataRefused(file or "truth", None, f"effect {error.name!r}", accepted) from error
    except SimulatorError as error:
        raise DataRefused(file or "truth", None, str(error), "it as described") from error


def read_text(path: Path, kind: str = "a TOML file") -> str:
    """Return what a file says; raise `DataRefused` if it cannot be read."""
    from station.errors import DataRefused

    try:
        return path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise DataRefused(path, None, f"no readable file ({error})", f"{kind} in UTF-8") from error
