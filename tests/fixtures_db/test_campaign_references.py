"""With what a campaign was measured, and whether that makes it calibrated or only measured."""

from collections.abc import Iterator
from datetime import UTC, date, datetime, timedelta, timezone
from pathlib import Path

import numpy as np
import pytest

from fixtures_db.campaigns import accept_step, day_of, references, start_campaign, why_measured
from fixtures_db.database import Database, open_db
from fixtures_db.fixture_measurements import add_level, certify_faces
from fixtures_db.fixtures import add_fixture
from fixtures_db.schema import CubeRow, SiteRow, SlabRow
from procedures.campaign.campaign import FaceCertificate
from tests.fixtures_db.factory import level_row, survey_columns

NOON = datetime(2026, 5, 11, 12, tzinfo=UTC)
DAY = day_of(NOON)
BEFORE = DAY - timedelta(days=1)
LONG_AGO = datetime(2020, 1, 1, tzinfo=UTC)
OF, EXPIRED = "the certificate of", f"expired on {BEFORE}"
NEITHER = ["no cube is named", "no slab is named"]


@pytest.fixture
def db(tmp_path: Path) -> Iterator[Database]:
    with open_db(tmp_path / "station.db") as opened:
        with opened.write() as session:
            for name in ("bare", "dated", "good", "open", "old"):
                dated = {"certificate_date": LONG_AGO.date(), "due_date": DAY} if name == "dated" else {}
                add_fixture(session, CubeRow(id=name, side_mm=400.0, **dated))
                add_fixture(session, SlabRow(id=name, **dated))
            for name, due in (("good", DAY), ("open", None), ("old", BEFORE)):
                face = {"x_up": FaceCertificate(np.zeros(2), np.eye(2) * 1e-12)}
                reported = {"source": "CMM 12", "measured_utc": LONG_AGO, "due_date": due}
                certify_faces(session, name, face, **reported)
                add_level(session, level_row(name, std=(1e-6, 1e-6), **reported))
                survey = survey_columns(9.8, 1e-6, "gravimeter", due_date=due)
                add_fixture(session, SiteRow(id=name, latitude_deg=48.0, **survey))
        yield opened


@pytest.mark.parametrize(
    ("cube", "slab", "site", "expected"),
    [
        (None, None, None, NEITHER),
        ("good", None, None, ["no slab is named"]),
        (None, "good", None, ["no cube is named"]),
        ("bare", "good", None, ["cube bare has no certificate"]),
        ("dated", "dated", None, ["cube dated has no certificate", "slab dated has no certificate"]),
        ("good", "good", None, []),
        ("open", "open", "open", []),
        ("old", "bare", None, [f"{OF} cube old {EXPIRED}", "slab bare has no certificate"]),
        ("good", "good", "old", [f"{OF} site old {EXPIRED}"]),
        ("good", "good", "good", []),
    ],
)
def test_a_cube_or_a_slab_without_a_certificate_in_force_makes_it_measured_and_is_named(
    db: Database, cube: str | None, slab: str | None, site: str | None, expected: list[str]
) -> None:
    begun = {"model": "FOG-3", "serial": "S1", "started_utc": NOON - timedelta(days=2)}
    with db.write() as session:
        start_campaign(session, "/data/1", **begun, cube_id=cube, slab_id=slab, site_id=site)
        accept_step(session, "/data/1", name="dwell_01", file="a", sha256="0" * 64, accepted_utc=NOON)
    with db.read() as session:
        used = references(session, "/data/1")
        assert why_measured(used, DAY) == expected
        assert why_measured(references(session, "/data/9"), DAY) == NEITHER  # nothing is known of it


def test_a_certificate_made_after_the_campaign_does_not_count_for_it(db: Database) -> None:
    after = NOON + timedelta(days=1)
    with db.write() as session:
        face = {"x_up": FaceCertificate(np.zeros(2), np.eye(2) * 1e-12)}
        certify_faces(session, "bare", face, source="CMM 12", measured_utc=after, due_date=date(2090, 1, 1))
        start_campaign(
            session, "/data/1", model="FOG-3", serial="S1", started_utc=NOON, cube_id="bare", slab_id="good"
        )
    with db.read() as session:
        assert why_measured(references(session, "/data/1"), DAY) == ["cube bare has no certificate"]


def test_the_day_is_that_of_utc_wherever_the_laboratory_is() -> None:
    """Else a campaign that ends at 17:00 in Vancouver is calibrated, and its certificate finds an expired cube."""
    vancouver = timezone(timedelta(hours=-8))
    assert day_of(datetime(2026, 3, 4, 17, tzinfo=vancouver)) == date(2026, 3, 5)
    assert day_of(datetime(2026, 3, 5, 1, tzinfo=UTC)) == date(2026, 3, 5)
