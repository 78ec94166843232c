"""Which calibration is applied to a live unit: a file, or the newest one that is stored of it.

A monitor falls back to a maker's nominal scale factors; what is streamed never has them unasked.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from drivers.wire import NominalScale, WireFormat
from fixtures_db.database import open_db
from fixtures_db.schema import CalibrationRow
from fixtures_db.stored_calibrations import history, last_calibration
from procedures.campaign.campaign import UNKNOWN
from procedures.errors import ErrorCode
from procedures.frames import TRIADS
from station.calibrated import InUse
from station.errors import DataRefused
from station.files.calibration_document import FORMAT, doubts, is_of_counts, parsed_calibration, read_calibration
from station.stream.connected_unit import Unit

DAY_S = 86400.0


@dataclass(frozen=True, slots=True, eq=False)
class AppliedCalibration:
    """``document`` is calibration/1, or None with a maker's scale factors in ``nominal``."""

    document: Mapping[str, Any] | None
    nominal: NominalScale | None
    in_use: InUse


def find_calibration(file: Path | None, database: str | None, unit: Unit, wire: WireFormat) -> AppliedCalibration:
    """Return what to apply to a unit's counts.

    Raise `DataRefused` if the file is no calibration/1 with both triads or is of another model, or there is
    neither a calibration nor a nominal scale.
    """
    if file is not None:
        document = _with_both(read_calibration(file), str(file))
        if unit.model not in {UNKNOWN, document.get("model")}:  # a sister unit's is used, with a note
            raise another_units(document, str(file), unit)
        return _applied(document, file.name, unit)
    with open_db(database) as opened, opened.read() as session:
        row = last_calibration(session, unit.model, unit.serial)
        if row is not None:
            return stored_calibration(row, unit)
    nominal = nominal_scales(unit, wire)
    if nominal is None:
        raise _nothing_of(unit)
    return nominal


def stored_calibration(row: CalibrationRow, unit: Unit) -> AppliedCalibration:
    """Return a calibration of the database as it is applied to a unit; raises as `find_calibration`."""
    name = row.sha256[:12]
    document = _with_both(parsed_calibration(row.document, name), name)
    return _applied(document, name, unit)


def nominal_scales(unit: Unit, wire: WireFormat) -> AppliedCalibration | None:
    """Return the maker's scale factors, None where they are not known."""
    found = next(iter(wire.scales.values()), None) if len(wire.scales) == 1 else wire.scales.get(unit.model)
    if found is None:
        return None
    return AppliedCalibration(None, found, InUse(f"NONE: nominal scale factors of {found.model}", found.source))


def _nothing_of(unit: Unit) -> DataRefused:
    found, remedy = f"no calibration of {unit.model} {unit.serial}", "calibrate it"
    if UNKNOWN in {unit.model, unit.serial}:
        found, remedy = "a device that does not send its model and serial number", "give --model and --serial"
    return DataRefused(
        "the database", None, found, "a stored calibration, or a device with nominal scale factors",
        f"{remedy}, or give --calibration FILE", ErrorCode.CALIBRATION,
    )  # fmt: skip


def _applied(document: Mapping[str, Any], name: str, unit: Unit) -> AppliedCalibration:
    if missing := [each for each in ("accepted_utc", "status") if each not in document]:
        raise DataRefused(name, None, f"no {missing[0]}", f"a {FORMAT} as it was stored", "name such a file")
    accepted, now = datetime.fromisoformat(document["accepted_utc"]), datetime.now(UTC)
    age = (now - accepted).total_seconds() / DAY_S
    text = f"{name} of {accepted:%Y-%m-%d}, {document['status']}, {age:.0f} days old"
    other = f"it is of {document['model']} {document['serial']}, connected is {unit.model} {unit.serial}"
    notes = [other if document["serial"] != unit.serial else "", *doubts(document, now)]
    return AppliedCalibration(document, None, InUse(text, "; ".join(filter(None, notes))))


def another_units(document: Mapping[str, Any], name: str, unit: Unit) -> DataRefused:
    """Return the refusal of a calibration, called ``name``, of another unit than the one connected."""
    return DataRefused(
        name, None, f"a calibration of {document.get('model')} {document.get('serial')}",
        f"one of {unit.model} {unit.serial}, which is connected", "name that unit's", ErrorCode.CALIBRATION,
    )  # fmt: skip


def _with_both(document: Mapping[str, Any], where: str) -> Mapping[str, Any]:
    if missing := [name for name in TRIADS if name not in document]:
        raise DataRefused(where, None, f"no {missing[0]}", "both triads", "calibrate both")
    return document


def chosen_calibration(
    asked: str, database: str | None, unit: Unit, wire: WireFormat, *, nominal: bool = False
) -> AppliedCalibration:
    """Return the calibration of a file or a serial number; where nothing is ``asked`` the unit's newest one.

    With ``nominal`` it is the maker's scale factors, and nothing else ever is. Raise `DataRefused` if there is
    none, or it is of another unit.
    """
    if nominal:
        if (found := nominal_scales(unit, wire)) is None:
            raise DataRefused(
                "--nominal", None, f"no nominal scale factors of {unit.model} in format {wire.name}",
                f"a model that has them ({', '.join(wire.scales) or 'none'})",
                "calibrate it, or give --calibration FILE", ErrorCode.CALIBRATION,
            )  # fmt: skip
        return found
    if asked and Path(asked).exists():
        found = find_calibration(Path(asked), database, unit, wire)
    elif not asked and UNKNOWN in {unit.model, unit.serial}:
        raise _none_of("a device that does not say who it is")
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
    of = {"model": unit.model, "serial": unit.serial}
    if any(value not in {UNKNOWN, applied.document.get(key)} for key, value in of.items()):
        raise another_units(applied.document, name, unit)
    of_counts = is_of_counts(applied.document)
    if of_counts != (wire.output == "increments"):
        wrong, sent = ("counts", "rates") if of_counts else ("rates", "counts")
        raise DataRefused(
            "--calibration", None, f"one of {wrong}", f"one of {sent}, which {wire.name} sends",
            "name one that was made of this output", ErrorCode.CALIBRATION,
        )  # fmt: skip


def _stored(serial: str, database: str | None, unit: Unit) -> AppliedCalibration:
    """Return the newest calibration that is stored of a serial number, where it is empty of the unit."""
    with open_db(database) as opened, opened.read() as session:
        row = last_calibration(session, unit.model, serial or unit.serial)
        if row is None and serial:
            row = next(reversed(history(session, serial)), None)
        if row is None and serial:
            raise _none_of(f"no such file, and no calibration of a unit {serial} in the database")
        if row is None:
            raise _none_of(f"no stored calibration of {unit.model} {unit.serial}")
        return stored_calibration(row, unit)


def _none_of(found: str) -> DataRefused:
    return DataRefused(
        "--calibration", None, found, "a calibration/1",
        "name a FILE or a SERIAL that has one, or take the maker's scale factors with station stream --nominal",
        ErrorCode.CALIBRATION,
    )  # fmt: skip
