"""The stable code of every refusal: what tests, scripts and support can rely on while the wording improves."""

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
