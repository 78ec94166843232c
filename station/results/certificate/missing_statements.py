"""What a certificate must say (ISO/IEC 17025:2017, 7.8.2.1, 7.8.4.1, 7.8.6.2), and where each can be given."""

import re
from collections.abc import Mapping
from datetime import datetime
from typing import Any

from station.errors import DataRefused
from station.files.effect_file import stored_effect
from station.results.certificate.laboratory import Laboratory
from station.results.parameters_by_name import applied, parameters

COMMIT = re.compile(r"\((?:sources )?(?P<commit>[0-9a-f]{7,40})(?P<dirty>-dirty)?\)")
_CALIBRATE_AGAIN = "a stored calibration is never changed; calibrate again"
_CONFIRM = (
    "a later campaign that shows it, `station effects adopt` of its diagnosis; then calibrate with that file"
)


FROM_CALIBRATION = {  # a field of a calibration by its path, and how it is given
    "model": _CALIBRATE_AGAIN,
    "serial": _CALIBRATE_AGAIN,
    "accepted_utc": _CALIBRATE_AGAIN,
    "operator": f"`station calibrate --operator`; {_CALIBRATE_AGAIN}",
    "software.commit": f"a station that runs from a checkout or an installed wheel; {_CALIBRATE_AGAIN}",
    "inputs": _CALIBRATE_AGAIN,
    "procedure.name": _CALIBRATE_AGAIN,
    "procedure.steps": _CALIBRATE_AGAIN,
    "procedure.started_utc": _CALIBRATE_AGAIN,
    "procedure.ended_utc": _CALIBRATE_AGAIN,
    "site.latitude_deg": _CALIBRATE_AGAIN,
    "site.gravity_m_s2": _CALIBRATE_AGAIN,
    "site.gravity_std_m_s2": _CALIBRATE_AGAIN,
    "site.gravity_source": (
        "[traceability] gravity_source of the laboratory's file, or `station fixtures add site` first"
    ),
    "references.cube.id": f"`station calibrate --cube`; {_CALIBRATE_AGAIN}",
    "references.cube.source": f"`station fixtures add certificate`; {_CALIBRATE_AGAIN}",
    "references.cube.due_date": f"`station fixtures add certificate --due`; {_CALIBRATE_AGAIN}",
    "references.slab.id": f"`station calibrate --slab`; {_CALIBRATE_AGAIN}",
    "references.slab.source": f"`station fixtures add level`; {_CALIBRATE_AGAIN}",
    "references.slab.due_date": f"`station fixtures add level --due`; {_CALIBRATE_AGAIN}",
    "temperature_range_c": "[environment] temperature_c of the laboratory's file: the unit measures none",
    "uncertainty": f"a station that makes an uncertainty budget; {_CALIBRATE_AGAIN}",
}
LABORATORY_INSTEAD = {  # fields of the laboratory's file that will do where the calibration has none
    "site.gravity_source": "traceability.gravity_source",
    "temperature_range_c": "environment.temperature_c",
}
NEEDED_AT_BEGIN = ("model", "serial", "operator", "software", "references")  # when a campaign begins
FROM_LABORATORY = {
    "laboratory.name": "[laboratory] name of the laboratory's file",
    "laboratory.address": "[laboratory] address",
    "authorised.name": "[authorised] name",
    "authorised.function": "[authorised] function",
    "customer.name": "[customer] name, or --customer",
    "customer.address": "[customer] address, or --customer-address",
    "item.received": "[item] received, or --received",
    "item.condition": "[item] condition, or --condition",
    "traceability.time_base": "[traceability] time_base",
}
FOR_DIGITAL = {  # what the form of a digital certificate asks for in addition
    "laboratory.country": "[laboratory] country, two letters of ISO 3166-1",
    "laboratory.email": "[laboratory] email",
    "customer.email": "[customer] email, or --customer-email",
}


def missing(
    document: Mapping[str, Any], laboratory: Laboratory, *, digital: bool = False
) -> list[tuple[str, str]]:
    """Return every field that neither a calibration/1 nor the laboratory says, and where to give it.

    ``digital``: also what a digital certificate must say.
    """
    stated, lab = fields_of(document), laboratory.model_dump()
    found = [
        (field, where)
        for field, where in FROM_CALIBRATION.items()
        if not _has(stated, field) and not _has(lab, LABORATORY_INSTEAD.get(field, ""))
    ]
    asked = FROM_LABORATORY | (FOR_DIGITAL if digital else {})
    found += [(field, where) for field, where in asked.items() if not _has(lab, field)]
    found += [(f"confirmation of {name}", _CONFIRM) for name in only_proposed(document)]
    if _has(stated, "uncertainty"):
        budget = {one["name"] for one in document["uncertainty"]["parameters"]}
        values = applied(parameters(document))
        found += [(f"uncertainty of {name}", _CALIBRATE_AGAIN) for name in values if name not in budget]
        if not values:
            found.append(("results", _CALIBRATE_AGAIN))
    return found


def only_proposed(document: Mapping[str, Any]) -> list[str]:
    """Return the effects of a calibration/1 that a search found and no other campaign confirmed."""
    own = [one for one in document.get("effects", ()) if "definition" in one]
    files = [stored_effect(one["definition"], one["sha256"], one["name"]) for one in own]
    return [file.name for file in files if file.is_only_proposed]


def missing_before(document: Mapping[str, Any]) -> list[str]:
    """Return every field of `NEEDED_AT_BEGIN` that is missing; no laboratory's file can give it later."""
    stated = fields_of(document)
    return [one for one in FROM_CALIBRATION if one.split(".")[0] in NEEDED_AT_BEGIN and not _has(stated, one)]


def check_received(document: Mapping[str, Any], laboratory: Laboratory, now: datetime) -> None:
    """Raise `DataRefused` if the unit was received after ``now`` or after it was measured, by days of ``now``."""
    received = laboratory.item.received
    started = datetime.fromisoformat(document["procedure"]["started_utc"]).astimezone(now.tzinfo)
    remedy = "give the day on which the unit came in with --received or [item] received"
    for latest, what in ((now, "today"), (started, "when its measurement began")):
        if received is not None and received > latest.date():
            expected = f"no day after {latest.date()}, {what}"
            raise DataRefused("--received", None, received.isoformat(), expected, remedy)


def fields_of(document: Mapping[str, Any]) -> dict[str, Any]:
    """Return a calibration's document with its references by kind, and the commit of its software."""
    software = {"name": document.get("software")}
    if found := COMMIT.search(document.get("software", "")):
        software["commit"] = found["commit"]
    return {
        **document,
        "references": {one["kind"]: one for one in document.get("references", ())},
        "software": software,
    }


def _has(tree: Mapping[str, Any], path: str) -> bool:
    value: Any = tree
    for part in path.split("."):
        if not isinstance(value, Mapping) or part not in value:
            return False
        value = value[part]
    return value is not None and value not in ("", [], {})
