"""What a kept anchor and a printed hash are held against, one by one."""

from dataclasses import replace
from typing import Any

import pytest

from fixtures_db.append_only_rows import ROW_TITLES, newest_hash
from fixtures_db.campaigns import campaign
from fixtures_db.database import Database
from fixtures_db.hash_chain import GENESIS, ChainFault
from fixtures_db.schema import (
    CalibrationRow,
    CubeMeasurementRow,
    EffectEventRow,
    FaceCertificateRow,
    IssuedCertificateRow,
    SignedFileRow,
    SlabLevelRow,
)
from fixtures_db.verification import alterations, missing_head, take_anchor

UNKNOWN = "ab" * 32
HEADS: dict[str, type[Any]] = {
    "calibration": CalibrationRow,
    "certificate": FaceCertificateRow,
    "level": SlabLevelRow,
    "measurement": CubeMeasurementRow,
    "issued": IssuedCertificateRow,
    "signed": SignedFileRow,
    "effect": EffectEventRow,
}


@pytest.mark.parametrize("name", HEADS)
def test_a_kept_head_that_no_row_has_is_found_in_its_own_table(rolled_back: Database, name: str) -> None:
    with rolled_back.read() as session:
        anchor = take_anchor(session)
        assert alterations(session, anchor) == []
        fault = ChainFault(f"newest {ROW_TITLES[HEADS[name]]}", newest_hash(session, HEADS[name]), UNKNOWN)
        other: dict[str, Any] = {name: UNKNOWN}
        assert alterations(session, replace(anchor, **other)) == [fault]


@pytest.mark.parametrize(
    ("kept", "row"),
    [
        ({"manifests": {"never": (2, UNKNOWN)}}, "campaign never"),
        ({"manifests": {"c1": (2, UNKNOWN)}}, "steps of campaign c1"),
        ({"journal": UNKNOWN}, "journal "),
        ({"entries": 9999}, "journal 9999"),
    ],
)
def test_kept_steps_and_a_kept_journal_are_held_against_what_is_there(
    rolled_back: Database, kept: dict[str, Any], row: str
) -> None:
    with rolled_back.read() as session:
        [fault] = alterations(session, replace(take_anchor(session), **kept))
        assert fault.row.startswith(row)


def test_a_printed_hash_is_that_of_any_chained_row_or_of_the_steps_of_a_campaign(rolled_back: Database) -> None:
    with rolled_back.read() as session:
        steps = campaign(session, "c3").manifest_sha256
        there = [steps, GENESIS, *(newest_hash(session, table) for table in HEADS.values())]
        assert [missing_head(session, sha256) for sha256 in there] == [[]] * 9
        for other in (UNKNOWN, steps[:12], steps[1:] + steps[0], ""):
            assert missing_head(session, other) == [ChainFault("stored rows", "none with the hash given", other)]
