"""What a calibration rests on, held against the journal: the rows it used, and the limits of that day."""

import json
from collections.abc import Iterable, Mapping
from typing import Any

from fixtures_db.hash_chain import ChainFault
from fixtures_db.journal import Head
from fixtures_db.model_limits import Limit
from fixtures_db.used_rows import Find, used_hashes


def grounds_faults(row: Mapping[str, Any] | None, head: Head, find: Find) -> list[ChainFault]:
    """Return what of a calibration does not follow from the rows that stood when it was stored.

    ``row`` has its number, its ``campaign_id`` and its document as text, None if it is gone, which other checks
    say. ``head`` is the journal's then, ``find`` finds its rows. The verdict is found anew from the values judged
    and the limits that the journal had.
    """
    if row is None:
        return []
    name, document = f"calibration {row['id']}", json.loads(row["document"])
    model, used = document["model"], document.get("used")
    found = [ChainFault(name, f"journal {document.get('journal')}", f"{head._asdict()}")]
    found = found if document.get("journal") != head._asdict() else []
    expected = used_hashes(find, model, document["serial"], row["campaign_id"])
    found += [
        ChainFault(name, f"{kind} with sha256 {(used or {}).get(kind, 'none')}", f"{sha256} as on that day")
        for kind, sha256 in expected.items()
        if (used or {}).get(kind) != sha256
    ]
    if "verdict" in document:
        found += _verdict_faults(name, document, limits_as_found(find("imu_limits", "model", model)))
    return found


def carried_faults(row: Mapping[str, Any] | None) -> list[ChainFault]:
    """Return what is wrong with a calibration that was there before the journal: it cannot name an entry."""
    if row is None or not json.loads(row["document"]).keys() & {"journal", "used"}:
        return []
    found = "one that was there before the journal began"
    return [ChainFault(f"calibration {row['id']}", found, "an entry of when it was stored")]


def limits_as_found(rows: Iterable[tuple[str, str]]) -> list[Limit]:
    """Return limits in the order in which they were given, from keys and contents of their rows."""
    said = sorted((json.loads(content) for _, content in rows), key=lambda one: one["id"])
    return [_limit(one) for one in said]


def _limit(said: Mapping[str, Any]) -> Limit:
    ends = said.get("low"), said.get("high")
    return Limit(said["parameter"], *ends, said["unit"], said.get("guard_band", 0.0))


def _verdict_faults(name: str, document: Mapping[str, Any], limits: list[Limit]) -> list[ChainFault]:
    stated = [_limit(one) for one in document["limits"]]
    if stated != limits:
        lacking = [one.parameter for one in limits if one not in stated] or [one.parameter for one in stated]
        return [ChainFault(name, f"other limits, of {lacking[0]} for one", "those of that day")]
    judged = {one["parameter"]: one for one in document.get("judged", ())}
    if not judged.keys() >= {limit.parameter for limit in limits}:  # stored by hand: nobody says what was judged
        return []
    words = [_word(limit, judged[limit.parameter]) for limit in limits]
    verdict = next(
        (word for word in ("FAIL", "NOT_MEASURED") if word in words), "PASS" if words else "NOT_MEASURED"
    )
    return (
        []
        if verdict == document["verdict"]
        else [ChainFault(name, document["verdict"], f"{verdict} by its limits")]
    )


def _word(limit: Limit, judged: Mapping[str, Any]) -> str:
    if judged.get("unit") != limit.unit:
        return "NOT_MEASURED"
    low, high = limit.accepted(judged.get("std"))
    return "PASS" if low <= judged["value"] <= high else "FAIL"
