"""What every output is, and what an address that cannot be used says."""

from typing import Protocol

from procedures.error_codes import ErrorCode
from station.errors import StationError
from station.sending.samples import CalibratedSamples


class BadAddress(StationError, ValueError):
    """The address of an output cannot be read; ``expected`` says what would be accepted."""

    code = ErrorCode.OUTPUT

    def __init__(self, address: str, found: str, expected: str) -> None:
        self.address, self.found, self.expected = address, found, expected
        super().__init__(f"--to {address}: found {found}, expected {expected}")


class Output(Protocol):
    """Takes samples and never waits for anybody: what does not go at once is dropped and counted.

    ``name`` is its address, ``dropped`` counts the samples that found no room, where it can be known; ``is_over``
    says that nobody can be reached any more, as when the reader of a pipe has left.
    """

    name: str

    @property
    def dropped(self) -> int | None:
        """The samples that did not go out; None of an output that cannot count them."""
        ...

    @property
    def is_over(self) -> bool:
        """Whether nobody will take anything any more."""
        ...

    def send(self, samples: CalibratedSamples) -> None:
        """Hand samples on."""
        ...

    def said(self) -> str:
        """Return who listens and what was dropped, in a few words."""
        ...

    def close(self) -> None:
        """Let it go, what waits sent first where it goes at once."""
        ...
