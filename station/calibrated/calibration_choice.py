"""Which calibration a monitor applies: a file, or the newest one that is stored of the unit."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from drivers.wire import NominalScale, WireFormat
from fixtures_db.database import open_db
from fixtures_db.stored_calibrations import last_calibration
from procedures.campaign.campaign import UNKNOWN
from procedures.frames import TRIADS
from station.calibrated.calibration_in_use import InUse
from station.errors import DataRefused
from station.files.toml_reading import read_text_file
from station.stream.recorder.connected_unit import Unit

FORMAT = "calibration/1"
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
        If the file is no calibration/1 with both triads, or there is neither a calibration nor a nominal scale.
    """
    now = datetime.now(UTC)
    if file is not None:
        return _applied(_checked(_read(file), str(file)), file.name, unit, now)
    with open_db(database) as opened, opened.read() as session:
        row = last_calibration(session, unit.model, unit.serial)
        stored = None if row is None else (json.loads(row.document), row.sha256)
    if stored is not None:
        return _applied(_checked(stored[0], stored[1][:12]), stored[1][:12], unit, now)
    nominal = next(iter(wire.scales.values()), None) if len(wire.scales) == 1 else wire.scales.get(unit.model)
    if nominal is None:
        raise _nothing_of(unit)
    return AppliedCalibration(
        None, nominal, InUse(f"NONE: nominal scale factors of {nominal.model}", nominal.source)
    )


def _nothing_of(unit: Unit) -> DataRefused:
    found, remedy = f"no calibration of {unit.model} {unit.serial}", "calibrate it"
    if UNKNOWN in {unit.model, unit.serial}:
        found, remedy = "a device that does not say who it is", "give --model and --serial"
    return DataRefused(
        "the database", None, found, "a stored calibration, or a device with nominal scale factors",
        f"{remedy}, or give --calibration FILE",
    )  # fmt: skip


def _applied(document: Mapping[str, Any], name: str, unit: Unit, now: datetime) -> AppliedCalibration:
    accepted = datetime.fromisoformat(document["accepted_utc"])
    age = (now - accepted).total_seconds() / DAY_S
    text = f"{name} of {accepted:%Y-%m-%d}, {document['status']}, {age:.0f} days old"
    return AppliedCalibration(document, None, InUse(text, _note(document, unit, now)))


def _note(document: Mapping[str, Any], unit: Unit, now: datetime) -> str:
    said = list[str]()
    if document["serial"] != unit.serial:
        said.append(f"it is of {document['model']} {document['serial']}, connected is {unit.model} {unit.serial}")
    until = document.get("valid_until")
    if until is not None and datetime.fromisoformat(until) < now:
        said.append(f"it expired on {until[:10]}")
    if document["status"] != "calibrated":
        said.append(str(document.get("status_reason", "")))
    return "; ".join(filter(None, said))


def _read(file: Path) -> Any:
    content = read_text_file(file)
    try:
        return json.loads(content)
    except ValueError as error:
        raise DataRefused(file, None, f"no JSON ({error})", f"a {FORMAT}") from None


def _checked(document: Any, where: str) -> Mapping[str, Any]:
    found = document.get("format") if isinstance(document, dict) else None
    if not isinstance(document, dict) or found != FORMAT:
        raise DataRefused(where, None, f"format {found!r}", repr(FORMAT), "name the file of a stored calibration")
    if missing := [name for name in TRIADS if name not in document]:
        raise DataRefused(where, None, f"no {missing[0]}", "both triads", "calibrate both")
    return document
