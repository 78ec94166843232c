"""Which calibration a monitor applies: a file, or the newest one that is stored of the unit."""

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from drivers.wire import NominalScale, WireFormat
from fixtures_db.database import open_db
from fixtures_db.schema import CalibrationRow
from fixtures_db.stored_calibrations import last_calibration
from procedures.campaign.campaign import UNKNOWN
from procedures.errors import ErrorCode
from procedures.frames import TRIADS
from station.calibrated import InUse
from station.errors import DataRefused
from station.files.calibration_document import FORMAT, doubts, parsed_calibration, read_calibration
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

    Raises
    ------
    DataRefused
        If the file is no calibration/1 with both triads or is of another model, or there is neither a
        calibration nor a nominal scale.
    """
    if file is not None:
        document = _with_both(read_calibration(file), str(file))
        if unit.model not in {UNKNOWN, document.get("model")}:  # a sister unit's is used, with a note
            raise another_units(document, str(file), unit)
        return _applied(document, file.name, unit, datetime.now(UTC))
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
    return _applied(document, name, unit, datetime.now(UTC))


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


def _applied(document: Mapping[str, Any], name: str, unit: Unit, now: datetime) -> AppliedCalibration:
    if missing := [each for each in ("accepted_utc", "status") if each not in document]:
        raise DataRefused(name, None, f"no {missing[0]}", f"a {FORMAT} as it was stored", "name such a file")
    accepted = datetime.fromisoformat(document["accepted_utc"])
    age = (now - accepted).total_seconds() / DAY_S
    text = f"{name} of {accepted:%Y-%m-%d}, {document['status']}, {age:.0f} days old"
    return AppliedCalibration(document, None, InUse(text, _note(document, unit, now)))


def another_units(document: Mapping[str, Any], name: str, unit: Unit) -> DataRefused:
    """Return the refusal of a calibration, called ``name``, of another unit than the one connected."""
    return DataRefused(
        name, None, f"a calibration of {document.get('model')} {document.get('serial')}",
        f"one of {unit.model} {unit.serial}, which is connected", "name that unit's", ErrorCode.CALIBRATION,
    )  # fmt: skip


def _note(document: Mapping[str, Any], unit: Unit, now: datetime) -> str:
    texts = list[str]()
    if document["serial"] != unit.serial:
        texts.append(f"it is of {document['model']} {document['serial']}, connected is {unit.model} {unit.serial}")
    return "; ".join(filter(None, [*texts, *doubts(document, now)]))


def _with_both(document: Mapping[str, Any], where: str) -> Mapping[str, Any]:
    if missing := [name for name in TRIADS if name not in document]:
        raise DataRefused(where, None, f"no {missing[0]}", "both triads", "calibrate both")
    return document
