"""Which calibration is applied to what is streamed: the unit's own, and never a nominal scale unasked."""

from pathlib import Path

from drivers.wire import WireFormat
from fixtures_db.database import open_db
from fixtures_db.stored_calibrations import history, last_calibration
from procedures.campaign.campaign import UNKNOWN
from procedures.errors import ErrorCode
from station.calibrated.calibration_choice import (
    AppliedCalibration,
    another_units,
    find_calibration,
    nominal_scales,
    stored_calibration,
)
from station.errors import DataRefused
from station.files.calibration_document import is_of_counts
from station.stream.connected_unit import Unit


def chosen_calibration(
    asked: str, database: str | None, unit: Unit, wire: WireFormat, *, nominal: bool = False
) -> AppliedCalibration:
    """Return the calibration of a file or a serial number; where nothing is ``asked`` the unit's newest one.

    With ``nominal`` it is the maker's scale factors, and nothing else ever is.

    Raises
    ------
    DataRefused
        If there is none, or it is of another unit.
    """
    if nominal:
        return _nominal(unit, wire)
    if not asked:
        found = _newest(unit, database)
    elif Path(asked).exists():
        found = find_calibration(Path(asked), database, unit, wire)
    else:
        found = _stored(asked, database, unit)
    refuse_unfit(found, asked, unit, wire)
    return found


def refuse_unfit(applied: AppliedCalibration, name: str, unit: Unit, wire: WireFormat) -> None:
    """Raise `DataRefused` for what is not to be streamed of the device connected; ``name`` is what was asked for.

    No calibration at all, one of another unit, one of counts where the device sends rates, or the reverse.
    """
    if applied.document is None:
        raise _none_of(f"no stored calibration of {unit.model} {unit.serial}")
    _refuse_another_units(applied, name, unit)
    _refuse_another_output(applied, wire)


def _refuse_another_units(applied: AppliedCalibration, name: str, unit: Unit) -> None:
    """Raise `DataRefused` for a calibration, named as ``name``, of another unit than the one connected."""
    document = applied.document or {"model": unit.model, "serial": unit.serial}
    of = {"model": unit.model, "serial": unit.serial}
    if any(value not in {UNKNOWN, document.get(key)} for key, value in of.items()):
        raise another_units(document, name, unit)


def _refuse_another_output(applied: AppliedCalibration, wire: WireFormat) -> None:
    """Refuse a calibration of counts for a device that sends rates, and the reverse."""
    of_counts, counts = is_of_counts(applied.document or {}), wire.output == "increments"
    if of_counts != counts:
        found, sent = ("counts", "rates") if of_counts else ("rates", "counts")
        raise DataRefused(
            "--calibration", None, f"one of {found}", f"one of {sent}, which {wire.name} sends",
            "name one that was made of this output", ErrorCode.CALIBRATION,
        )  # fmt: skip


def _newest(unit: Unit, database: str | None) -> AppliedCalibration:
    if UNKNOWN in {unit.model, unit.serial}:
        raise _none_of("a device that does not say who it is")
    with open_db(database) as opened, opened.read() as session:
        row = last_calibration(session, unit.model, unit.serial)
        if row is None:
            raise _none_of(f"no stored calibration of {unit.model} {unit.serial}")
        return stored_calibration(row, unit)


def _stored(serial: str, database: str | None, unit: Unit) -> AppliedCalibration:
    with open_db(database) as opened, opened.read() as session:
        row = last_calibration(session, unit.model, serial) or next(reversed(history(session, serial)), None)
        if row is None:
            raise _none_of(f"no such file, and no calibration of a unit {serial} in the database")
        return stored_calibration(row, unit)


def _nominal(unit: Unit, wire: WireFormat) -> AppliedCalibration:
    found = nominal_scales(unit, wire)
    if found is None:
        known = ", ".join(wire.scales) or "none"
        raise DataRefused(
            "--nominal", None, f"no nominal scale factors of {unit.model} in format {wire.name}",
            f"a model that has them ({known})", "calibrate it, or give --calibration FILE",
            ErrorCode.CALIBRATION,
        )  # fmt: skip
    return found


def _none_of(found: str) -> DataRefused:
    return DataRefused(
        "--calibration", None, found, "a calibration/1",
        "name a FILE or a SERIAL that has one, or take the maker's scale factors with station stream --nominal",
        ErrorCode.CALIBRATION,
    )  # fmt: skip
