"""From a recorded campaign to its certificate, through the database alone."""

import json
from datetime import UTC, date, datetime
from pathlib import Path

import numpy as np
import pytest

from fixtures_db.campaigns import accept_step, campaign, references
from fixtures_db.database import Database, open_db
from fixtures_db.fixture_measurements import add_level, certify_faces
from fixtures_db.fixtures import add_fixture
from fixtures_db.imu_models import set_limits
from fixtures_db.schema import CubeRow, SiteRow, SlabRow
from fixtures_db.stored_calibrations import calibration
from procedures.campaign.campaign import FaceCertificate
from procedures.positions import FACES
from station.files.campaign_folder.campaign_schema import SiteTable
from station.files.campaign_folder.plan_file import UnitRecord, write_note
from station.files.campaign_setup import Setup
from station.results.campaign_results import make_results, store
from station.results.certificate.issuing import issue
from station.results.certificate.missing_statements import missing
from station.results.parameters_by_name import applied, parameters
from station.stream.recorder.accepted_step_writer import open_campaign
from tests.fixtures_db.factory import level_row, survey_columns
from tests.station.guide.recorded import UNIT
from tests.station.guide.stored import recorded
from tests.station.results.certificate.dcc_numbers import NS, of_type, parsed, results
from tests.station.results.certificate.factory import LIMITS, laboratory
from tests.station.results.certificate.test_certificate_inputs import seen

SURVEY = survey_columns(9.8072914, 2e-7, "gravimeter, survey 12", date(2024, 5, 1), date(2090, 5, 1))
LONG_AGO, AHEAD = datetime(2020, 1, 1, 12, tzinfo=UTC), datetime(2090, 1, 1, 12, tzinfo=UTC)


def furnish(database: Database, due: date = date(2090, 1, 1)) -> None:
    """Add a certified cube, a level slab and limits of the model."""
    face = FaceCertificate(np.zeros(2), np.eye(2) * 25e-12)
    with database.write() as session:
        add_fixture(session, CubeRow(id="CUBE-7", side_mm=400.0))
        for measured, by in ((LONG_AGO, "CMM 12"), (AHEAD, "CMM of the future")):
            faces = dict.fromkeys(FACES, face)
            certify_faces(session, "CUBE-7", faces, source=by, measured_utc=measured, due_date=due)
        add_fixture(session, SlabRow(id="SLAB-2"))
        level = level_row(
            "SLAB-2", (1e-5, 0.0), (5e-6, 5e-6), source="level 17", measured_utc=LONG_AGO, due_date=due
        )
        add_level(session, level)
        set_limits(session, "SIM-FOG3", LIMITS[:1])


@pytest.mark.parametrize("expired", [False, True])
def test_a_campaign_comes_to_a_certificate(tmp_path: Path, expired: bool) -> None:
    with open_db(tmp_path / "station.db") as database:
        furnish(database, date(2021, 1, 1) if expired else date(2090, 1, 1))
        folder = recorded(tmp_path / "c", database, cube_id="CUBE-7", slab_id="SLAB-2")
        write_note(folder, Setup(operator="M. Curie"))
        sha256 = store(make_results(folder, database), database)
        with database.read() as session:
            document = json.loads(calibration(session, sha256).document)
        assert document["diagnosis"]["verdict"]
        cube = next(one for one in document["references"] if one["kind"] == "cube")
        assert (cube["source"], cube["side_mm"]) == ("CMM 12", 400.0)  # not the one measured after the campaign
        assert document["procedure"]["name"].startswith("twelve-position calibration")
        assert len(document["procedure"]["steps"]) == 12
        lacks = {field for field, _ in missing(document, laboratory())} - {"software.commit"}  # outside a checkout
        assert lacks == {"site.gravity_source"}
        lab = laboratory().given("traceability", {"gravity_source": "gravimeter"})
        if "software.commit" in {field for field, _ in missing(document, lab)}:
            pytest.skip("no checkout: the software has no commit to name")
        row = issue(database, sha256, lab, digital=True)
    text = seen(row.html)
    assert row.dcc is not None
    root = parsed(row.dcc.encode())
    assert set(results(root)) == set(applied(parameters(document)))
    [block, *_] = of_type(root, "fog_covarianceBlock", "quantity")
    solved = document["accelerometer"]["scale_factor"]["std"][0]  # [count/(g s)]
    first = float(block.findtext(".//si:valueXMLList", None, NS).split()[0])
    assert first == pytest.approx((solved / 9.80665) ** 2, rel=1e-9)
    assert ("Measurement report" if expired else "Calibration certificate") in text
    assert ("cube CUBE-7 expired on 2021-01-01; the certificate of slab SLAB-2" in text) == expired
    assert ("For information only" in text) == expired
    assert "simulated device" in text
    assert "within all" not in text
    assert "1 limited parameters" not in text


def test_what_was_done_otherwise_is_stored_with_the_calibration(tmp_path: Path) -> None:
    with open_db(tmp_path / "station.db") as database:
        folder = recorded(tmp_path / "c", database)
        write_note(folder, UnitRecord(model="SIM-FOG3", serial="SIM-7", serial_from_wire=False, period=0.02))
        toml = folder / "campaign.toml"
        skipped = "unsettled_gyro_deg_h = 0.2\nunsettled_accelerometer_g = 3e-5"
        toml.write_text(toml.read_text().replace("[procedure]", f"[procedure]\n{skipped}"))
        with database.write() as session:
            row = campaign(session, str(folder)).steps[0]
            again = {"name": row.name, "file": row.file, "sha256": row.sha256, "accepted_utc": row.accepted_utc}
            accept_step(session, str(folder), **again)
        sha256 = store(make_results(folder, database), database)
        with database.read() as session:
            document = json.loads(calibration(session, sha256).document)
    assert document["procedure"]["deviations"] == [
        "the serial number was typed in: the unit does not send one",
        "warm-up was skipped: biases may drift by 0.2 deg/h and 30 ug (standard uncertainty)",
        "dwell_01 was recorded 2 times, the last one is used",
    ]


@pytest.mark.parametrize(
    ("entered", "site"),
    [
        ({"gravity_m_s2": 9.80729, "gravity_std_m_s2": 1e-5}, "LAB-1"),
        ({"gravity_m_s2": 9.80729, "gravity_std_m_s2": 1e-7}, None),  # better than the survey is
        ({"gravity_m_s2": 9.8070, "gravity_std_m_s2": 1e-5}, None),
        ({"latitude_deg": 48.2, "gravity_m_s2": 9.8072914, "gravity_std_m_s2": 1e-5}, None),
        ({}, None),
    ],
)
def test_gravity_entered_by_hand_is_known_by_its_survey(
    tmp_path: Path, entered: dict[str, float], site: str | None
) -> None:
    with open_db(tmp_path / "station.db") as database:
        with database.write() as session:
            add_fixture(session, SiteRow(id="LAB-1", latitude_deg=48.1374, **SURVEY))
        (tmp_path / "c").mkdir()
        open_campaign(tmp_path / "c", UNIT, SiteTable(**{"latitude_deg": 48.1374, **entered}), database)
        with database.read() as session:
            row = campaign(session, str(tmp_path / "c"))
            assert row.site_id == site
            found = references(session, row.folder)
    if site is None:
        assert found == []
    else:
        reported = {"source": SURVEY["gravity_source"], "measured_utc": "2024-05-01", "due_date": "2090-05-01"}
        assert found == [{"kind": "site", "id": site, **reported}]


def test_the_height_is_that_of_the_surveyed_site(tmp_path: Path) -> None:
    with open_db(tmp_path / "station.db") as database:
        with database.write() as session:
            add_fixture(session, SiteRow(id="LAB-1", latitude_deg=48.1374, height_m=519.0, **SURVEY))
        folder = recorded(tmp_path / "c", database)
        with database.write() as session:
            campaign(session, str(folder)).site_id = "LAB-1"
        sha256 = store(make_results(folder, database), database)
        with database.read() as session:
            assert json.loads(calibration(session, sha256).document)["site"]["height_m"] == 519.0
