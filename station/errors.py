"""What the station can refuse; each says found, expected and what to do, and carries its data.

`EXIT_CODES` has the exit code of each family of refusals of all packages, by full name, so that no command imports
what another needs.
"""

import errno
import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from procedures.errors import ErrorCode

MAX_LISTED = 500  # characters of what was found, in a message


class StationError(Exception):
    """The base of all that ``station`` raises on purpose."""

    code = ErrorCode.DATA


class DataRefused(StationError, ValueError):
    """Data that break a rule of `campaign/1`; ``line`` is None where no single line is to blame."""

    def __init__(
        self, file: str | Path, line: int | None, found: str, expected: str, remedy: str = "correct the file",
        code: ErrorCode = ErrorCode.DATA,
    ) -> None:  # fmt: skip
        self.code = code
        self.file, self.line, self.found, self.expected = str(file), line, found, expected
        where = self.file if line is None else f"{self.file}:{line}"
        super().__init__(f"{where}: found {shortened(found)}, expected {expected}; {remedy}")


class TimeUnitAsked(DataRefused):
    """The unit of a log's time is ambiguous: ``candidates`` are its units, the most probable first.

    Each is the unit as ``--unit-time`` takes it, the sample rate [Hz] and the duration [s] that it makes.
    """

    def __init__(self, file: str | Path, column: str, candidates: Sequence[tuple[str, float, float]]) -> None:
        self.column, self.candidates = column, tuple(candidates)
        text = ", ".join(f"{unit} ({rate:.4g} Hz, {seconds:.4g} s)" for unit, rate, seconds in candidates)
        remedy = f"type --unit-time {candidates[0][0]}, or another of them"
        super().__init__(
            file, None, f"time column {column} in an ambiguous unit", f"one of {text}", remedy, ErrorCode.TIME_UNIT
        )


class ClocksContradict(DataRefused):
    """Two clocks of a log contradict each other: ``clocks`` are column, sample rate [Hz], duration [s] by each."""

    def __init__(self, file: str | Path, clocks: Sequence[tuple[str, float, float]]) -> None:
        self.clocks = tuple(clocks)
        text = ", ".join(f"{name} ({rate:.5g} Hz, {seconds:.4g} s)" for name, rate, seconds in clocks)
        remedy = f"type --time {clocks[0][0]} or --time {clocks[1][0]}"
        super().__init__(
            file, None, f"clocks that contradict each other: {text}", "one of them", remedy, ErrorCode.TIME_UNIT
        )


class CannotWrite(StationError, OSError):
    """A result could not be written; what was there before is untouched."""

    code = ErrorCode.CANNOT_WRITE

    def __init__(self, path: str | Path, reason: str) -> None:
        self.path, self.reason = str(path), reason
        super().__init__(f"{path}: cannot be written ({reason}); name a place where you may write")


class DiskFull(CannotWrite):
    """The disk, or the user's share of it, is full; ``needed`` and ``free`` are bytes, None where not known."""

    code = ErrorCode.DISK_FULL

    def __init__(self, path: str | Path, needed: int | None = None, free: int | None = None) -> None:
        super().__init__(path, "disk full")
        self.needed, self.free = needed, free
        room = [f"{megabytes(free)} free"] if free is not None else []
        room += [f"{megabytes(needed)} needed"] if needed is not None else []
        self.args = (f"{', '.join([f'{path}: disk full', *room])}; make room, or name a folder on another disk",)


class DiskFails(CannotWrite):
    """The disk did not keep what was written; what it holds of it is not known."""

    code = ErrorCode.DISK_FAILS

    def __init__(self, path: str | Path, reason: str) -> None:
        super().__init__(path, reason)
        self.args = (
            f"{path}: the disk fails ({reason}), expected it to keep what is written; copy what is there to "
            "another disk, and go on there",
        )


def cannot_write(path: str | Path, error: OSError, needed: int | None = None) -> CannotWrite:
    """Return what the system reported of a write as the refusal of ``path``; ``needed`` is bytes, where known."""
    if error.errno in {errno.ENOSPC, errno.EDQUOT}:
        return DiskFull(path, needed)
    if error.errno == errno.EIO:
        return DiskFails(path, error.strerror or str(error))
    return CannotWrite(path, error.strerror or str(error))


def shortened(text: str) -> str:
    """Return text for a message: what somebody put into a file may be a million characters long."""
    return text if len(text) <= MAX_LISTED else f"{text[: MAX_LISTED - 3]}..."


def megabytes(size: int) -> str:
    """Return bytes in words, rounded up to what is worth saying."""
    return f"{math.ceil(size / 1e6)} MB" if size > 1e6 else f"{math.ceil(size / 1e3)} kB"


class Incomplete(StationError, ValueError):
    """A certificate lacks what it must say; ``missing`` holds field and where to give it, all of them."""

    code = ErrorCode.CERTIFICATE

    def __init__(self, what: str, missing: Sequence[tuple[str, str]]) -> None:
        self.what, self.missing = what, tuple(missing)
        fields = "; ".join(f"{field} ({where})" for field, where in self.missing)
        super().__init__(f"{what}: found no {fields}; expected all that ISO/IEC 17025 asks; nothing was issued")


class NoPdf(StationError, RuntimeError):
    """PDF cannot be made here; the HTML was written."""

    code = ErrorCode.CERTIFICATE

    def __init__(self, html: str | Path, reason: str) -> None:
        self.html, self.reason = str(html), reason
        super().__init__(
            f"no PDF ({reason}): run `make extra-pdf`, install the library pango, then ask for a --copy with "
            f"--pdf; {html} is written"
        )


class NoXml(StationError, LookupError):
    """A certificate was issued without an XML, and a copy of it has none."""

    code = ErrorCode.CERTIFICATE

    def __init__(self, number: str) -> None:
        self.number = number
        super().__init__(
            f"certificate No. {number}: found no XML, expected one; it was issued without: issue it again with "
            f"--amend REASON --dcc"
        )


class BadXml(StationError, ValueError):
    """A digital certificate breaks its schema or a rule; nothing was issued. It should not come to this."""

    code = ErrorCode.CERTIFICATE

    def __init__(self, number: str, first: str, count: int) -> None:
        self.number, self.first, self.count = number, first, count
        super().__init__(
            f"digital certificate No. {number}: found {count} against schema or rules, expected none; nothing was "
            f"issued; please report the first: {first}"
        )


class Altered(StationError):
    """A recorded file or a stored row differs from the hash taken when it was accepted."""

    code = ErrorCode.ALTERED

    def __init__(
        self,
        file: str | Path,
        found: str,
        recorded: str,
        remedy: str = "restore the file from a copy or record the step again",
    ) -> None:
        self.file, self.found, self.recorded = str(file), found, recorded
        super().__init__(f"{file}: found {found}, expected {recorded} as recorded; {remedy}")


class DatabaseAltered(StationError):
    """A database disagrees with its own journal or chains, or with what was kept elsewhere."""

    code = ErrorCode.ALTERED

    def __init__(self, row: str, found: str, expected: str) -> None:
        self.row, self.found, self.expected = row, found, expected
        remedy = "find out who changed it, restore the database from a copy"
        super().__init__(f"{row}: found {found}, expected {expected}; {remedy}")


LONGEST_LINE = 2000  # characters of what is reported of an error
CANCELLED = 130
BUG = 70
MEANINGS = {
    0: "done",
    1: "done, but the verdict is FAIL, or something was altered",
    2: "wrong usage, or a result cannot be written",
    3: "data refused",
    4: "a device, its port or a service fails",
    5: "not observable: the data do not determine what was asked",
    BUG: "a bug of the program: please report it; STATION_TRACEBACK=1 shows where",
    CANCELLED: "cancelled",
}
EXIT_CODES = {
    "station.errors.DataRefused": 3,
    "station.errors.TimeUnitAsked": 2,
    "station.errors.ClocksContradict": 2,
    "station.errors.CannotWrite": 2,
    "station.errors.Altered": 1,
    "station.errors.DatabaseAltered": 1,
    "station.errors.Incomplete": 3,
    "station.errors.NoPdf": 2,
    "station.errors.NoXml": 3,
    "station.errors.BadXml": 3,
    "station.errors.SignatureBroken": 1,
    "station.errors.NotVerified": 1,
    "station.errors.NoTimeStamp": 4,
    "station.results.resolve.work_item.NoCluster": 2,
    "station.results.resolve.work_item.ClusterLost": 4,
    "station.sending.outputs.BadAddress": 2,
    "station.tui.web.CannotServe": 2,
    "procedures.optional_libraries.ExtraMissing": 2,
    "procedures.errors.NotObservable": 5,
    "procedures.errors.WrongFace": 3,
    "procedures.errors.ProcedureError": 3,
    "drivers.errors.BadDeviceUrl": 2,
    "drivers.errors.BadCanFile": 3,
    "drivers.errors.DriverError": 4,
    "fixtures_db.errors.SchemaAltered": 1,
    "fixtures_db.errors.NotADatabase": 2,
    "fixtures_db.errors.NotWritten": 2,
    "fixtures_db.errors.DatabaseError": 3,
}


def exit_code(error: BaseException) -> int | None:
    """Return the exit code of what was refused; None where it is no refusal but a bug."""
    for kind in type(error).__mro__:
        if (code := EXIT_CODES.get(f"{kind.__module__}.{kind.__qualname__}")) is not None:
            return code
    return None


def error_code(error: BaseException) -> ErrorCode:
    """Return the stable code of what a command raised."""
    import typer  # not before something was raised: the engine needs no command line

    if isinstance(error, KeyboardInterrupt | typer.Abort):
        return ErrorCode.CANCELLED
    if isinstance(error, SystemExit | typer.Exit) or callable(getattr(error, "format_message", None)):
        return ErrorCode.USAGE
    code = getattr(error, "code", None)
    return code if isinstance(code, ErrorCode) and exit_code(error) is not None else ErrorCode.BUG


def explain(error: BaseException) -> tuple[int, str]:
    """Return the exit code of what a command raised, and the line to say."""
    import typer  # not before something was raised: the engine needs no command line

    if isinstance(error, KeyboardInterrupt | typer.Abort):
        return CANCELLED, "cancelled"
    if isinstance(error, SystemExit | typer.Exit):
        code = error.code if isinstance(error, SystemExit) else error.exit_code
        return (code, "") if isinstance(code, int) else (2 if code else 0, str(code or ""))
    if callable(usage := getattr(error, "format_message", None)):  # every usage error of typer's click has one
        context = getattr(error, "ctx", None)
        return 2, f"{usage().rstrip('.')}. Try `{context.command_path if context else 'station'} --help`."
    if (code := exit_code(error)) is not None:
        return code, str(error)
    return (
        BUG,
        f"{type(error).__name__}: {error}; a bug: run again with STATION_TRACEBACK=1 and report what it says",
    )


def one_line(text: str) -> str:
    """Return text as one printable line, cut where a value in it is longer than anybody reads."""
    seen = "".join(c if c.isprintable() else " " for c in text[: LONGEST_LINE + 1]).strip()
    return seen if len(text) <= LONGEST_LINE else f"{seen[:LONGEST_LINE]} ..."


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
        text = "; ".join(f"{name} {words.removeprefix('found ')}" for name, words in faults.items())
        super().__init__(f"{file}: found {text}; do not use it, {remedy}")


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
