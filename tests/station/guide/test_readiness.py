"""How ready a campaign is before it begins is what its verdict and its certificate say afterwards."""

import json
from collections.abc import Iterator
from dataclasses import dataclass, replace
from datetime import UTC, date, datetime
from itertools import product
from pathlib import Path

import numpy as np
import pytest

from drivers.simulated.truth import Truth
from fixtures_db.campaigns import accept_step
from fixtures_db.database import Database, open_db
from fixtures_db.fixture_measurements import add_level, certify_faces
from fixtures_db.fixtures import add_fixture
from fixtures_db.imu_models import Limit, limits_of, set_limits
from fixtures_db.schema import CubeRow, SiteRow, SlabRow
from fixtures_db.stored_calibrations import calibration
from procedures.campaign.campaign import FaceCertificate
from procedures.positions import FACES
from station.files.campaign_folder.plan_file import write_note
from station.files.campaign_setup import Setup
from station.guide.campaign.campaign_start import usual_steps
from station.guide.campaign.campaign_tables import site_table
from station.guide.campaign.readiness import read_prior_knowledge, readiness
from station.guide.setup_view import PortCheck, Readiness
from station.results import campaign_results as module
from station.results.campaign_results import CampaignResults, make_results, store
from station.results.certificate.content import Certificate
from station.results.certificate.missing_statements import missing
from station.results.verdict import judge
from station.stream.connected_unit import Unit
from station.stream.recorder.accepted_step_writer import open_campaign
from tests.fixtures_db.factory import level_row, survey_columns
from tests.station.guide.stored import recorded
from tests.station.results.certificate.factory import laboratory

LONG_AGO, PAST, AHEAD = datetime(2020, 1, 1, tzinfo=UTC), date(2021, 1, 1), date(2090, 1, 1)
KINDS = ("", "bare", "good", "open", "old")  # none, without certificate, in force, never due, expired
BIAS = Limit("accelerometer.bias", -0.05, 0.05, "g", 2.0)
LIMITS = {
    "none": [],
    "good": [BIAS, Limit("gyroscope.scale_factor", 34000, 38000, "count/deg")],
    "never": [BIAS, Limit("gyroscope.bias_12_position.x", -1, 1, "deg/h")],
    "closed form": [Limit("accelerometer.bias_12_position", -1, 1, "g")],
    "bench": [Limit("slab.tilt", -1, 1, "rad"), Limit("fixture.parallelism", -1, 1, "rad")],
    "other output": [Limit("accelerometer.scale_factor", 0, 1e9, "output/g")],
}
SURVEYED = {"gravity_m_s2": 9.8, "gravity_std_m_s2": 1e-5}
SITES = {
    "normal": {"latitude_deg": 31.17},
    "unknown": {"latitude_deg": 31.17, **SURVEYED},
    "surveyed": {"latitude_deg": 48.0, **SURVEYED},
    "old survey": {"latitude_deg": 50.0, **SURVEYED},
}


@dataclass(frozen=True)
class Bench:
    """A database with every kind of reference, and a campaign that was solved once."""

    database: Database
    root: Path
    results: CampaignResults

    def before(self, setup: Setup, model: str = "SIM-FOG3") -> Readiness:
        check = PortCheck(
            url=setup.url, is_good=True, model=model, serial="SIM-7", output="increments", rate_hz=50.0
        )
        return readiness(setup, read_prior_knowledge(self.database, self.root, usual_steps(setup), 50.0), check)

    def after(self, setup: Setup, number: int) -> tuple[str, dict[str, object]]:
        """Have the campaign done with that set-up, as far as the database goes; return verdict and document."""
        folder = self.root / f"c{number}"
        folder.mkdir()
        write_note(folder, setup)
        unit = Unit("SIM-FOG3", "SIM-7", Truth.example(7).sample_period_s)
        used = {"cube_id": setup.cube or None, "slab_id": setup.slab or None}
        open_campaign(folder, unit, site_table(setup), self.database, **used)
        key = str(folder.resolve())
        with self.database.write() as session:
            accept_step(
                session, key, name="dwell_01", file="a", sha256=f"{number:064x}", accepted_utc=datetime.now(UTC)
            )
        with self.database.read() as session:
            reasons = module._why_measured(session, key)  # noqa: SLF001  as `make_results` has it
            std = {one.name: one.std for one in self.results.budgets}
            outcome = judge(self.results.document, limits_of(session, "SIM-FOG3"), std)
        site = self.results.tables.model_copy(update={"site": site_table(setup)})
        status = {"status": "measured" if reasons else "calibrated", "status_reason": "; ".join(reasons)}
        files = {"calibration_file": folder / "calibration.json", "report_file": folder / "report.html"}
        made = replace(self.results, folder=folder, outcome=outcome, tables=site, **files, **status)
        sha256 = store(made, self.database)
        with self.database.read() as session:
            return outcome.word, json.loads(calibration(session, sha256).document)


@pytest.fixture(scope="module")
def bench(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Bench]:
    root = tmp_path_factory.mktemp("readiness")
    face = dict.fromkeys(FACES, FaceCertificate(np.zeros(2), np.eye(2) * 25e-12))
    with open_db(root / "station.db") as database:
        with database.write() as session:
            for kind in KINDS[1:]:
                add_fixture(session, CubeRow(id=kind, side_mm=400.0))
                add_fixture(session, SlabRow(id=kind))
                due = {"good": AHEAD, "old": PAST}.get(kind)
                reported = {"source": "CMM 12", "measured_utc": LONG_AGO, "due_date": due}
                if kind != "bare":
                    certify_faces(session, kind, face, **reported)
                    add_level(session, level_row(kind, std=(5e-6, 5e-6), **reported))
            for name, latitude, due in (("LAB-1", 48.0, AHEAD), ("LAB-2", 50.0, PAST)):
                survey = survey_columns(9.8, 1e-6, "gravimeter", LONG_AGO.date(), due)
                add_fixture(session, SiteRow(id=name, latitude_deg=latitude, **survey))
        yield Bench(database, root, make_results(recorded(root / "c", database, turned=True), database))


def test_the_answer_before_a_campaign_is_the_one_after_it(bench: Bench, monkeypatch: pytest.MonkeyPatch) -> None:
    lab = laboratory().given("traceability", {"gravity_source": "gravimeter 7"})
    lab = lab.given("environment", {"temperature_c": [20.0, 21.0]})
    limits, answers = list(LIMITS), set[tuple[bool | None, bool | None]]()
    monkeypatch.setattr(
        "station.results.report.report.write_report", lambda *_: None
    )  # of the same numbers each time
    cases = [("good", "good", "M. Huber", site) for site in ("surveyed", "normal") for _ in LIMITS]
    cases += list(product(KINDS, KINDS, ("", "M. Huber"), SITES))[::7]  # each of each, in changing company
    for number, (cube, slab, operator, site) in enumerate(cases):
        setup = Setup(url="x", cube=cube, slab=slab, operator=operator, **SITES[site])
        case = (cube, slab, operator, site, limits[number % len(limits)])
        with bench.database.write() as session:
            set_limits(session, "SIM-FOG3", LIMITS[case[-1]])
        ready = bench.before(setup)
        word, document = bench.after(setup, number)
        lacks = [field for field, _ in missing(document, lab)]
        made = Certificate("1", datetime.now(UTC), document, "", lab)
        is_certificate = not lacks and made.title.en.startswith("Calibration certificate")
        assert (ready.can_pass, ready.can_certify) == (word != "NOT_MEASURED", is_certificate), case
        if not lacks and made.reasons:
            assert ready.no_certificate.startswith("a measurement report: ")
            assert all(reason in ready.no_certificate for reason in made.reasons), case
        answers.add((ready.can_pass, ready.can_certify))
    assert answers == {(True, True), (True, False), (False, True), (False, False)}


def test_what_is_not_known_before_the_port_was_looked_at_is_reported_as_such(bench: Bench) -> None:
    setup = Setup(url="x", cube="good", slab="good", operator="M. Huber", latitude_deg=31.17)
    facts = read_prior_knowledge(bench.database, bench.root, usual_steps(setup), None)
    for check in (None, PortCheck(url="y", is_good=True, model="SIM-FOG3"), PortCheck(url="x", is_good=False)):
        ready = readiness(setup, facts, check)
        assert ready.can_pass is None
        assert ready.can_certify
        assert ready.outcomes[0] == "can end in PASS: not known before the unit's model is known"
        assert ready.lines[0].state == "note"
