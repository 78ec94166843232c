"""What a procedure can refuse, and the stable code of every refusal of all packages.

ProcedureError
├── NotObservable      the data do not determine what was asked for
├── WrongFace          a dwell's vertical axis is not the one its position names
├── FitsNoFace         a dwell's output is that of no face, as from a damaged sample
├── WrongMounting      the IMU does not sit in the cube as the campaign says
├── TurnsDisagree      two turns about one axis contradict each other's direction or revolutions
├── MoveContradicts    a transfer does not lead from one of its placements to the other
├── TooShort           a dwell has too few samples to say anything
├── TermRefused        an effect's term or unit is outside the grammar
├── DoesNotFit         a model with an effect in it cannot be fitted: of the effect, never of the data
└── ExtraMissing       a library that only an extra installs is missing (`procedures.optional_libraries`)
"""

from collections.abc import Sequence
from enum import StrEnum


class ErrorCode(StrEnum):
    """A code and one line that says what it means."""

    meaning: str

    def __new__(cls, code: str, meaning: str) -> "ErrorCode":
        """Return the member whose value is ``code``."""
        member = str.__new__(cls, code)
        member._value_ = code
        member.meaning = meaning
        return member

    # Recordings and logs
    DATA = "E-DATA", "A file or folder breaks a rule of its format."
    FILE_MISSING = "E-FILE-MISSING", "A file or folder that was named does not exist."
    TABLE = "E-TABLE", "A log holds no table that can be read, or its rows have different numbers of cells."
    DAMAGED_ROWS = (
        "E-DAMAGED-ROWS",
        "More than 1 % of the rows of a log are damaged; fewer are dropped and counted.",
    )
    COLUMNS = "E-COLUMNS", "The columns of a log cannot be assigned to sensors, or a named column is missing."
    TIME_UNIT = "E-TIME-UNIT", "The unit or the clock of the time is ambiguous: state --unit-time or --time."
    TIME_ORDER = "E-TIME-ORDER", "Time goes back, stands still, or repeats."
    UNIT = "E-UNIT", "The unit of a sensor's columns is unknown, contradictory or not one that the program knows."
    GRAVITY = "E-GRAVITY", "The specific force at rest is not 9.8 m/s2 within 20 %."
    RATE_AT_REST = "E-RATE-AT-REST", "The angular rate at rest is larger than any sensor's bias and noise explain."
    AXES = "E-AXES", "Axes or signs of gyroscopes and accelerometers contradict each other or are ambiguous."
    TOO_SHORT = "E-TOO-SHORT", "A recording has too few samples for what was asked."
    TURN_ANGLE = "E-TURN-ANGLE", "The true angle of a rotation is unknown: state it with --as turn:+z:ANGLEdeg."
    KIND = "E-KIND", "The kind of a recording cannot be recognised, or contradicts --as."
    SAMPLE_RATE = (
        "E-SAMPLE-RATE",
        "The sample rate is more than 1 % off the declared one or a reference time.",
    )
    # Results
    CALIBRATION = "E-CALIBRATION", "No calibration fits: none is stored, or it is of another unit or output."
    CANNOT_WRITE = "E-CANNOT-WRITE", "A result could not be written; the earlier file is unchanged."
    DISK_FULL = "E-DISK-FULL", "The disk or the user's quota is full."
    DISK_FAILS = "E-DISK-FAILS", "The disk failed to store written data."
    CERTIFICATE = "E-CERTIFICATE", "A certificate cannot be issued or copied as asked."
    KEY = "E-KEY", "A signing key, its password or its token cannot be used."
    SIGNATURE = "E-SIGNATURE", "A signature does not hold, or stands where none is expected."
    TIME_STAMP = "E-TIME-STAMP", "A time-stamping service gave no time stamp."
    ALTERED = "E-ALTERED", "A recorded file or stored row was changed."
    # Procedures
    NOT_OBSERVABLE = "E-NOT-OBSERVABLE", "The data do not determine what was asked for."
    PROCEDURE = "E-PROCEDURE", "The data contradict the declaration of a step."
    TERM = "E-TERM", "A user-defined error term is outside the grammar."
    # Devices
    DEVICE = "E-DEVICE", "A device, its port or its link fails."
    DEVICE_ADDRESS = "E-DEVICE-ADDRESS", "The address of a device cannot be read."
    WRONG_UNIT = "E-WRONG-UNIT", "The connected unit is not the one that was named or that started the campaign."
    CHANNELS = "E-CHANNELS", "A device does not measure all required channels."
    CAN_FILE = "E-CAN-FILE", "A DBC or a mapping file breaks a rule."
    # Database
    DATABASE = "E-DATABASE", "The database refuses an entry, or cannot be opened or written."
    # Other programs and machines
    OUTPUT = "E-OUTPUT", "The address of an output of samples cannot be read."
    BROWSER = "E-BROWSER", "The screen cannot be served to a browser."
    CLUSTER = "E-CLUSTER", "The computers that share the work cannot be reached, or were lost."
    # The command line
    USAGE = "E-USAGE", "An option or argument is missing, unknown or out of range."
    EXTRA_MISSING = "E-EXTRA-MISSING", "A library that only an extra installs is missing."
    CANCELLED = "E-CANCELLED", "The user cancelled."
    BUG = "E-BUG", "A bug in the program: please report it."


class ProcedureError(Exception):
    """The base of all that ``procedures`` raises on purpose."""

    code = ErrorCode.PROCEDURE


class NotObservable(ProcedureError):
    """The data do not determine what was asked for; ``missing`` says what would."""

    code = ErrorCode.NOT_OBSERVABLE

    def __init__(self, what: str, missing: Sequence[str]) -> None:
        self.what = what
        self.missing = tuple(missing)
        super().__init__(f"{what} cannot be determined: missing {', '.join(self.missing)}")


class WrongFace(ProcedureError, ValueError):
    """A dwell's vertical axis is not the one its position names."""

    def __init__(self, step: str, position: int, named: str, seen: str) -> None:
        self.step, self.position, self.named, self.seen = step, position, named, seen
        super().__init__(
            f"{step}: position {position} means {named}, but the counts show {seen}; "
            f"run `station diagnose` (it reports placement.label) or correct the position"
        )


class FitsNoFace(ProcedureError, ValueError):
    """One dwell's accelerometer output spoils the rest, and no other face would mend it."""

    def __init__(self, step: str, position: int) -> None:
        self.step, self.position = step, position
        super().__init__(
            f"{step}: found accelerometer outputs of no face, expected those of position {position}; "
            f"check it for damaged samples, or remove it"
        )


class WrongMounting(ProcedureError, ValueError):
    """The IMU does not sit in the cube as ``fixture.imu_axes`` says."""

    def __init__(self, named: str, seen: str) -> None:
        self.named, self.seen = named, seen
        super().__init__(f"imu_axes says {named}, but the counts show {seen}; correct fixture.imu_axes")


class TurnsDisagree(ProcedureError, ValueError):
    """Turns of one axis imply scale factors too far apart: a direction or a number of revolutions is wrong."""

    def __init__(self, first: str, per_turn: float, second: str, other_per_turn: float) -> None:
        self.first, self.per_turn, self.second, self.other_per_turn = first, per_turn, second, other_per_turn
        super().__init__(
            f"{first} shows {per_turn:.6g} and {second} {other_per_turn:.6g} per revolution, expected the same "
            f"within 10 %; correct the direction or the revolutions of one of them"
        )


class MoveContradicts(ProcedureError, ValueError):
    """A move does not lead from the one of its placements to the other: one of these has a wrong label."""

    def __init__(self, move: str, before: str, after: str, off_deg: float) -> None:
        self.move, self.before, self.after, self.off_deg = move, before, after, off_deg
        super().__init__(
            f"{move}: the gyroscopes show a rotation that differs by {off_deg:.0f} deg otherwise than from "
            f"{before} to {after}, expected less than 5; correct the position or axes of one of the two"
        )


class TooShort(ProcedureError, ValueError):
    """A dwell has too few samples to say anything."""

    code = ErrorCode.TOO_SHORT

    def __init__(self, step: str, samples: int, least: int) -> None:
        self.step, self.samples, self.least = step, samples, least
        super().__init__(f"{step} has {samples} samples, expected at least {least}; record it longer or remove it")


class DoesNotFit(ProcedureError, ValueError):
    """A model with effects added to it cannot be fitted: a word on the effects, never on the data."""


class TermRefused(ProcedureError, ValueError):
    """An effect's term or unit is outside the grammar; ``at`` counts characters of ``text`` from 0."""

    code = ErrorCode.TERM

    def __init__(self, text: str, at: int, found: str, expected: str) -> None:
        self.text, self.at, self.found, self.expected = text, at, found, expected
        super().__init__(f"column {at + 1} of {text!r}: found {found}, expected {expected}; correct the term")
