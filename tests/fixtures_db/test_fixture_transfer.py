from datetime import date

import numpy as np
import pytest

from fixtures_db.append_only_rows import newest_hash, verify_dates, verify_rows
from fixtures_db.database import Database, open_db
from fixtures_db.errors import DiffersFromStored, NotInDatabase
from fixtures_db.fixture_measurements import add_level, certify_faces, cube, drawing, dump, restore
from fixtures_db.fixtures import add_fixture, due, fixture_row
from fixtures_db.schema import CubeMeasurementRow, CubeRow, FaceCertificateRow, SiteRow, SlabLevelRow, SlabRow
from fixtures_db.stored_calibrations import accept_calibration
from procedures.campaign.campaign import FaceCertificate
from tests.fixtures_db.factory import LATER, NOON, facts, fill_fixtures, level_row, solution, survey_columns

CHAINED = (FaceCertificateRow, CubeMeasurementRow, SlabLevelRow)


@pytest.fixture
def filled(db: Database) -> Database:
    with db.write() as session:
        fill_fixtures(session)
    return db


def test_a_dump_taken_into_an_empty_database_is_equal_down_to_the_hashes(filled: Database) -> None:
    with filled.read() as session:
        rows = dump(session)
        heads = [newest_hash(session, table) for table in CHAINED]
    with open_db("sqlite://") as other:
        with other.write() as session:
            added = restore(session, rows)
        with other.read() as session:
            assert dump(session) == rows
            assert [newest_hash(session, table) for table in CHAINED] == heads
            assert all(verify_rows(session, table) == [] for table in CHAINED)
            assert verify_dates(session) == []
        with other.write() as session:
            assert set(restore(session, rows).values()) == {0}
    assert added["certificate"] == 3
    assert added["cube"] == 1  # P1 comes with every database


def test_what_would_change_a_stored_row_is_refused_and_nothing_is_added(filled: Database) -> None:
    with filled.read() as session:
        before = dump(session)
    for table, column, value in (
        ("cube", "side_mm", 300.0),
        ("site", "gravity_m_s2", 9.81),
        ("level", "std_east_rad", 1e-4),
    ):
        rows = {name: [dict(row) for row in table_rows] for name, table_rows in before.items()}
        rows["slab"].append({"id": "NEW", "certificate_date": None, "due_date": None})
        rows[table][-1][column] = value
        with pytest.raises(DiffersFromStored, match=column), filled.write() as session:
            restore(session, rows)
    orphan = {"tolerance": [{**before["tolerance"][0], "cube_id": "CUBE-9"}]}
    with pytest.raises(NotInDatabase, match="CUBE-7, P1"), filled.write() as session:
        restore(session, orphan)
    with filled.read() as session:
        assert dump(session) == before


def test_what_was_measured_earlier_supersedes_nothing(db: Database) -> None:
    with db.write() as session:
        add_fixture(session, CubeRow(id="CUBE-7", side_mm=400.0))
        for at, tilt in ((LATER, 2e-5), (NOON, 1e-5)):
            face = FaceCertificate(np.full(2, tilt), np.eye(2) * 25e-12)
            certify_faces(session, "CUBE-7", {"x_up": face}, source="CMM", measured_utc=at, due_date=at.date())
    with db.read() as session:
        np.testing.assert_array_equal(cube(session, "CUBE-7").faces["x_up"].up_tilt, [2e-5, 2e-5])
        assert fixture_row(session, CubeRow, "CUBE-7").due_date == LATER.date()


def test_what_expires_is_listed_by_day(filled: Database) -> None:
    with filled.write() as session:
        accept_calibration(session, solution(), facts("S1", date(2026, 9, 1)))
        accept_calibration(session, solution(), facts("S1", date(2027, 9, 1)))
    with filled.read() as session:
        assert [one.name for one in due(session, date(2027, 1, 1))] == ["SITE-1"]
        found = [(one.kind, one.name) for one in due(session, date(2030, 1, 1))]
    assert found == [("site", "SITE-1"), ("cube", "CUBE-7"), ("slab", "SLAB-1"), ("imu", "FOG-3 S1")]


def test_a_slab_keeps_every_level_and_a_site_its_survey(filled: Database) -> None:
    with filled.read() as session:
        assert [row.tilt_east_rad for row in fixture_row(session, SlabRow, "SLAB-1").levels] == [1e-5, 3e-5]
        assert fixture_row(session, SlabRow, "SLAB-1").due_date == date(2027, 6, 4)
        assert fixture_row(session, SiteRow, "SITE-1").gravity_source == "survey 12"


def test_what_is_no_slab_site_or_drawing_is_refused(filled: Database) -> None:
    with filled.write() as session:
        add_fixture(session, SlabRow(id="S2"))
        with pytest.raises(ValueError, match="1 sigma"):
            add_level(session, level_row("S2", std=(1e-5, 0), source="x", measured_utc=NOON))
        with pytest.raises(NotInDatabase, match="S2, SLAB-1"):
            fixture_row(session, SlabRow, "S3")
        with pytest.raises(ValueError, match="latitude"):
            add_fixture(session, SiteRow(id="far", latitude_deg=91.0))
        with pytest.raises(ValueError, match="gravity"):
            add_fixture(session, SiteRow(id="moon", latitude_deg=1.0, **survey_columns(1.62, 1e-5, "x")))
    with pytest.raises(ValueError, match="t1"):
        drawing({"t11": 0.04})
    assert [item.item for item in drawing({"t10": 0.02, "t1": 0.01})] == ["t1", "t10"]
