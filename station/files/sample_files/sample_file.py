"""What every writer of calibrated samples is given, and does."""

from dataclasses import dataclass
from typing import Protocol

from procedures.arrays import FloatArray

NS_PER_S = 1e9


@dataclass(frozen=True, slots=True)
class SampleColumns:
    """The columns: ``names`` of all, the first seven in this order; ``rows`` that will come at most.

    ``is_si`` says that forces are in m/s2 and rates in rad/s; ``frame`` names their axes.
    """

    names: tuple[str, ...]
    rows: int
    frame: str
    is_si: bool


class SampleWriter(Protocol):
    """Writes a new file, or a folder; in memory that does not grow with it."""

    def write(self, columns: list[FloatArray]) -> None:
        """Write rows, ``columns`` (n,) in the order and units of the names."""
        ...

    def finish(self) -> None:
        """Make the file whole, on the disk."""
        ...

    def abandon(self) -> None:
        """Let go of the file, which is taken away by the one who asked for it."""
        ...
