"""The exit code of each family of refusals, by full name, so that no command's imports are paid for by another."""

EXIT_CODES = {
    "station.errors.DataRefused": 3,
    "station.errors.CannotWrite": 2,
    "station.errors.Altered": 1,
    "station.errors.Incomplete": 3,
    "station.errors.NoPdf": 2,
    "station.results.cluster.errors.NoCluster": 2,
    "station.results.cluster.errors.ClusterLost": 4,
    "station.tui.web.errors.CannotServe": 2,
    "procedures.fusion.optional_libraries.ExtraMissing": 2,
    "procedures.errors.NotObservable": 5,
    "procedures.errors.WrongFace": 3,
    "procedures.errors.ProcedureError": 3,
    "drivers.errors.BadDeviceUrl": 2,
    "drivers.errors.BadCanFile": 3,
    "drivers.errors.DriverError": 4,
    "fixtures_db.errors.NotADatabase": 2,
    "fixtures_db.errors.DatabaseError": 3,
}


def exit_code(error: BaseException) -> int | None:
    """Return the exit code of what was refused; None where it is no refusal but a bug."""
    for kind in type(error).__mro__:
        if (code := EXIT_CODES.get(f"{kind.__module__}.{kind.__qualname__}")) is not None:
            return code
    return None
