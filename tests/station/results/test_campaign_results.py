"""Solving writes a solution and a report and stores nothing; storing is one act, done once, and read back."""

import json
import shutil
from collections.abc import Iterator
from datetime import UTC, date, datetime
from pathlib import Path

import numpy as np
import pytest

from drivers.simulated.truth import Truth
from fixtures_db.campaigns import campaign
from fixtures_db.database import Database
from fixtures_db.errors import AlreadyStored, NotInDatabase
from fixtures_db.fixture_measurements import add_level, certify_faces
from fixtures_db.fixtures import add_fixture
from fixtures_db.imu_models import Limit, set_limits
from fixtures_db.schema import CubeRow, SlabRow
from fixtures_db.stored_calibrations import history, verify_chain
from procedures.campaign.campaign import FaceCertificate
from procedures.errors import ErrorCode
from procedures.positions import FACES
from station.errors import Altered, CannotWrite
from station.files.atomic_file import replace_file
from station.files.campaign_folder.campaign_reading import read_campaign
from station.files.campaign_folder.plan_file import write_note
from station.files.campaign_setup import Setup
from station.guide.campaign.interrupted_campaigns import cancel_campaign
from station.guide.campaign.verdict import verdict_view
from station.results import campaign_results as module
from station.results.campaign_results import make_results, store
from station.results.certificate.model_statement import diagnosis_in_words
from tests.empty_database import empty_db
from tests.fixtures_db.factory import level_row
from tests.procedures.diagnosis.planted import drifting
from tests.refusals import refused
from tests.station.campaign_writing import write_campaign
from tests.station.guide.recorded import everything
from tests.station.guide.stored import recorded

LIMITS = [
    Limit("accelerometer.bias", -0.05, 0.05, "g", 2.0),
    Limit("gyroscope.scale_factor", 34000, 38000, "count/deg"),
    Limit("residual.p_value", 1e-9, None, "1"),
]


@pytest.fixture
def db(tmp_path: Path) -> Iterator[Database]:
    with empty_db(tmp_path / "station.db") as opened:
        yield opened


def test_a_campaign_is_solved_judged_and_stored_once(db: Database, tmp_path: Path) -> None:
    folder = recorded(tmp_path / "c", db, turned=True)
    write_note(folder, Setup(operator="M. Curie"))
    with db.write() as session:
        set_limits(session, "SIM-FOG3", LIMITS)
    was = everything(db)
    results = make_results(folder, db)
    assert everything(db) == was
    assert not results.calibration_file.exists()
    verdict = verdict_view(results, db)
    assert verdict.word == "PASS"
    assert verdict.sentence.startswith(
        "PASS: SIM-FOG3 SIM-7 is within all 7 limits of its model. Closest to its limit: "
    )
    assert (verdict.change, verdict.status) == ("this is the first calibration of this unit", "measured")
    assert verdict.status_reason == "no cube is named; no slab is named"
    assert len(verdict.rows) == 25
    assert "the limit of 4" in verdict.worst_residual
    report = results.report_file.read_text()
    assert "is within all 7 limits" in report

    sha256 = store(results, db)
    stored = results.calibration_file.read_text()
    assert sha256 not in report
    assert sha256 in results.report_file.read_text()
    document = json.loads(stored)
    assert (document["verdict"], document["status"], document["operator"]) == ("PASS", "measured", "M. Curie")
    assert document["limits"][-1] == {"parameter": "residual.p_value", "low": 1e-9, "unit": "1", "guard_band": 0.0}
    assert document["uncertainty"]["format"] == "budget/1"
    assert len(document["uncertainty"]["parameters"]) == 24
    assert "Uncertainty budget" in report
    with db.read() as session:
        [row] = history(session, "SIM-7")
        assert (row.sha256, row.document) == (sha256, stored)
        assert verify_chain(session) == []
        assert campaign(session, str(folder.resolve())).state == "accepted"
    assert (
        verdict_view(results, db).change == "this is the first calibration of this unit"
    )  # itself does not count

    now = everything(db)
    results.calibration_file.unlink()  # as a kill between the row and the file leaves it
    with refused(AlreadyStored, None, sha256[:12]):
        store(make_results(folder, db), db)
    assert results.calibration_file.read_text() == stored
    assert everything(db) == now

    again = make_results(recorded(tmp_path / "c2", db, seed=2), db)
    moved = verdict_view(again, db)
    assert "of 12 parameters changed by more than 3 u; largest change" in moved.change
    assert sum(bool(row.change) for row in moved.rows) == 12  # this one has no gyroscope
    assert moved.word == "NOT_MEASURED"
    assert json.loads(db_document(db, store(again, db)))["previous"] == sha256


def test_an_unexplained_residual_is_in_the_uncertainty_and_a_pass_says_so(db: Database, tmp_path: Path) -> None:
    folder, truth = recorded(tmp_path / "c", db), Truth.example(7)
    plain = read_campaign(folder).campaign
    shutil.rmtree(folder)
    write_campaign(folder, drifting(plain, 3, 0.3), truth.sample_period_s)
    with db.write() as session:
        set_limits(session, "SIM-FOG3", [Limit("accelerometer.bias", -0.05, 0.05, "g", 2.0)])
    results = make_results(folder, db)
    assert results.diagnosis["verdict"] == "unexplained"
    reported = verdict_view(results, db).sentence
    assert reported.startswith("PASS: ")
    assert "the diagnosis cannot explain all residuals: the uncertainty treats them as scatter" in reported
    assert "as scatter" in results.report_file.read_text()
    document = json.loads(db_document(db, store(results, db)))
    bias = next(one for one in document["uncertainty"]["parameters"] if one["name"] == "accelerometer.bias.x")
    (left,) = [part for part in bias["contributions"] if part["source"] == "unexplained"]
    judged = next(one for one in document["judged"] if one["parameter"] == "accelerometer.bias.x")
    assert judged["std"] == pytest.approx(bias["std"])  # what the guard band was taken of
    assert judged["std"] > left["std"] > 0
    assert any(text.endswith("is included in U.") for text in diagnosis_in_words(document))


def db_document(db: Database, sha256: str) -> str:
    with db.read() as session:
        return next(row.document for row in history(session, "SIM-7") if row.sha256 == sha256)


@pytest.mark.parametrize("expired", ["cube", "slab", ""])
def test_an_expired_certificate_makes_it_measured_and_says_which(
    db: Database, tmp_path: Path, expired: str
) -> None:
    past, ahead = date(2020, 1, 1), date(2100, 1, 1)
    reported = {"source": "CMM 12", "measured_utc": datetime(2019, 1, 1, tzinfo=UTC)}
    face = FaceCertificate(np.zeros(2), np.eye(2) * 25e-12)
    with db.write() as session:
        add_fixture(session, CubeRow(id="CUBE-7", side_mm=400.0))
        due = past if expired == "cube" else ahead
        certify_faces(session, "CUBE-7", dict.fromkeys(FACES, face), **reported, due_date=due)
        add_fixture(session, SlabRow(id="SLAB-1"))
        due = past if expired == "slab" else ahead
        add_level(session, level_row("SLAB-1", std=(1e-5, 1e-5), **reported, due_date=due))
    results = make_results(recorded(tmp_path / "c", db, cube_id="CUBE-7", slab_id="SLAB-1"), db)
    names = {"cube": "CUBE-7", "slab": "SLAB-1"}
    reason = f"the certificate of {expired} {names[expired]} expired on 2020-01-01" if expired else ""
    status = "measured" if expired else "calibrated"
    assert (results.status, results.status_reason) == (status, reason)
    assert reason in results.report_file.read_text()
    verdict = verdict_view(results, db)
    assert (verdict.word, verdict.status, verdict.status_reason) == ("NOT_MEASURED", status, reason)
    document = json.loads(db_document(db, store(results, db)))
    assert (document["status"], document.get("status_reason", "")) == (status, reason)


def test_what_cannot_be_stored_leaves_no_calibration(
    db: Database, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    results = make_results(recorded(tmp_path / "c", db), db, tmp_path)
    assert results.solution_file == tmp_path / "solution.json"

    def garble(path: Path, content: bytes) -> None:
        replace_file(path, content.replace(b"SIM-7", b"SIM-8"))

    monkeypatch.setattr(module, "replace_file", garble)
    with refused(Altered, ErrorCode.ALTERED):
        store(results, db)
    monkeypatch.undo()
    with pytest.raises(AlreadyStored):  # it is; the file is written anew
        store(results, db)
    assert "SIM-7" in results.calibration_file.read_text()

    other = make_results(recorded(tmp_path / "c2", db, seed=3), db)
    cancel_campaign(tmp_path / "c2", db)
    with pytest.raises(NotInDatabase):
        store(other, db)
    assert not other.calibration_file.exists()
    with pytest.raises(CannotWrite):
        make_results(tmp_path / "c", db, tmp_path / "nowhere")
