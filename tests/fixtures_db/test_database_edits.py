"""Edits past the station are noticed, honest databases are not: a short `tests.benchmarks.database_edits`."""

import random
from pathlib import Path

import pytest

from fixtures_db.schema import Base
from tests.benchmarks.database_edits import CUT, REWRITTEN, Tally, filled, try_edits
from tests.benchmarks.edited_databases.file_edits import HOW, try_file_edits
from tests.benchmarks.edited_databases.honest_databases import false_alarms
from tests.benchmarks.edited_databases.row_edits import BY_COLUMN, EDITS, edits

SEEN_BY_ANCHOR_ALONE = {REWRITTEN, CUT}


def test_edits_of_any_table_and_column_are_noticed(db_url: str) -> None:
    with filled(db_url) as database:
        tally = try_edits(database, 200 if db_url.startswith("sqlite") else 50, seed=1)
    assert tally.missed == []
    assert sum(tally.made.values()) > 40
    for kind, made in tally.made.items():
        assert tally.alone[kind] == made or kind in SEEN_BY_ANCHOR_ALONE, kind


def test_edits_of_the_file_are_noticed_against_an_anchor(tmp_path: Path) -> None:
    tally = Tally()
    try_file_edits(tmp_path, len(HOW), random.Random(1), tally.record)
    assert tally.missed == []
    assert sum(tally.made.values()) == len(HOW)


def test_honest_databases_have_no_fault(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from tests.benchmarks.edited_databases import honest_databases

    monkeypatch.setattr(honest_databases, "KNOWN", ("0001", "0011"))
    assert false_alarms(tmp_path, 4, random.Random(1)) == []


def test_every_column_of_every_table_is_edited() -> None:
    drawn = {(kind, column.table.name, column.key) for kind, _, column in edits()}
    assert {(kind, table.name, column.key) for kind in BY_COLUMN for table in Base.metadata.sorted_tables
            for column in table.columns} <= drawn  # fmt: skip
    assert {kind for kind, _, _ in drawn} == set(EDITS)
