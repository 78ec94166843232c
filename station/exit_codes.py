"""The exit code of each family of refusals, by full name, so that no command's imports are paid for by another."""

from procedures.errors import ErrorCode

LONGEST_LINE = 2000  # characters of what is said of an error
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
    "station.results.certificate.signing.errors.SignatureBroken": 1,
    "station.results.certificate.signing.errors.NotVerified": 1,
    "station.results.certificate.signing.errors.NoTimeStamp": 4,
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
