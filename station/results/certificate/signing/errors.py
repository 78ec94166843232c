"""What signing and checking can refuse.

StationError
├── SignatureBroken    what is signed, or how, does not hold
├── NotVerified        a certificate's file is not what it should be; what was looked at is said before
└── NoTimeStamp        a time-stamping service gave none
"""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from procedures.errors import ErrorCode
from station.errors import StationError


class SignatureBroken(StationError, ValueError):
    """A signature does not hold, or is no signature that is accepted; ``reason`` says why."""

    code = ErrorCode.SIGNATURE

    def __init__(self, reason: str) -> None:
        self.reason = reason
        super().__init__(f"signature: {reason}; get the file again from whoever issued it")


class NotVerified(StationError, ValueError):
    """Of what was looked at, ``faults`` do not hold, by name."""

    code = ErrorCode.SIGNATURE

    def __init__(
        self, file: str | Path, faults: dict[str, str], remedy: str = "get it again from whoever issued it"
    ) -> None:
        self.file, self.faults = str(file), faults
        said = "; ".join(f"{name} {words.removeprefix('found ')}" for name, words in faults.items())
        super().__init__(f"{file}: found {said}; do not use it, {remedy}")


class NoTimeStamp(StationError, OSError):
    """A time-stamping service was asked and gave none; what was issued or written stays, without."""

    code = ErrorCode.TIME_STAMP

    def __init__(self, url: str, reason: str) -> None:
        self.url, self.reason = url, reason
        super().__init__(f"{url}: no time stamp ({reason}), expected one by RFC 3161; try again, or do without")


def first_line(error: BaseException) -> str:
    """Return the first line of what an error says, its name where it says nothing."""
    return next(iter(str(error).splitlines()), "").rstrip(": ") or type(error).__name__


@contextmanager
def refused_as(what: str) -> Iterator[None]:
    """Take whatever a reader of PDF, XML, deflate or ASN.1 stumbles over as `SignatureBroken`."""
    try:
        yield
    except SignatureBroken:
        raise
    except Exception as error:  # libraries name no base of what a changed file makes them raise
        raise SignatureBroken(f"{what} ({first_line(error)})") from error
