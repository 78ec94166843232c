"""Fields that a certificate needs: found where they stand, missed where they are empty, named with their place."""

from datetime import UTC, date, datetime
from typing import Any

import pytest

from station.errors import DataRefused
from station.results.certificate.laboratory import Laboratory
from station.results.certificate.missing_statements import (
    FROM_CALIBRATION,
    FROM_LABORATORY,
    check_received,
    fields_of,
    missing,
    missing_before,
)

BEGIN: dict[str, Any] = {
    "model": "FOG", "serial": "7", "operator": "N. N.", "software": "station 1.2 (0123abc)",
    "references": [
        {"kind": "cube", "id": "C", "source": "PTB 12", "due_date": "2030-01-01"},
        {"kind": "slab", "id": "S", "source": "level", "due_date": "2030-01-01"},
    ],
}  # fmt: skip


def laboratory(**tables: Any) -> Laboratory:
    return Laboratory.model_validate({"format": "laboratory/1", **tables})


def test_what_is_needed_at_the_begin_is_looked_for_then() -> None:
    assert missing_before(BEGIN) == []
    assert missing_before({}) == [
        "model", "serial", "operator", "software.commit", "references.cube.id", "references.cube.source",
        "references.cube.due_date", "references.slab.id", "references.slab.source", "references.slab.due_date",
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("changed", "found"),
    [
        ({"operator": ""}, ["operator"]),
        ({"operator": None}, ["operator"]),
        ({"software": "station 1.2"}, ["software.commit"]),
        (
            {"references": BEGIN["references"][:1]},
            [f"references.slab.{each}" for each in ("id", "source", "due_date")],
        ),
    ],
)
def test_what_is_empty_is_missing(changed: dict[str, Any], found: list[str]) -> None:
    assert missing_before(BEGIN | changed) == found


def test_a_commit_is_read_out_of_the_software_and_a_reference_found_by_its_kind() -> None:
    said = fields_of(BEGIN | {"software": "station 1.2 (0123abc-dirty)"})
    assert said["software"] == {"name": "station 1.2 (0123abc-dirty)", "commit": "0123abc"}
    assert said["references"]["slab"]["id"] == "S"
    assert said["serial"] == "7"


def test_of_nothing_all_is_missing_each_with_where_it_is_given() -> None:
    assert missing({}, laboratory()) == [*FROM_CALIBRATION.items(), *FROM_LABORATORY.items()]


@pytest.mark.parametrize(
    ("field", "table"),
    [
        ("site.gravity_source", {"traceability": {"gravity_source": "survey"}}),
        ("temperature_range_c", {"environment": {"temperature_c": [20.0, 22.0]}}),
    ],
)
def test_the_laboratory_may_state_what_the_calibration_lacks(field: str, table: dict[str, Any]) -> None:
    given = missing({}, laboratory(**table))
    assert field not in dict(given)
    assert len(given) == len(FROM_CALIBRATION) + len(FROM_LABORATORY) - 1


@pytest.mark.parametrize(
    ("received", "said"),
    [
        (date(2026, 3, 4), ""),
        (date(2026, 3, 5), "no day after 2026-03-04, when its measurement began"),
        (date(2026, 3, 8), "no day after 2026-03-07, today"),
        (None, ""),
    ],
)
def test_a_unit_is_received_before_it_is_measured(received: date | None, said: str) -> None:
    stated = laboratory(item={"received": received}) if received else laboratory()
    document = {"procedure": {"started_utc": "2026-03-04T08:00:00+00:00"}}
    now = datetime(2026, 3, 7, 12, tzinfo=UTC)
    if not said:
        check_received(document, stated, now)
        return
    with pytest.raises(DataRefused, match=said):
        check_received(document, stated, now)
