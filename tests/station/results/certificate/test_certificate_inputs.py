"""A certificate says all that it must, the same way twice, or says what is missing."""

import copy
import json
import re
from collections.abc import Iterator
from dataclasses import replace
from datetime import UTC, datetime
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import pytest

from fixtures_db.database import Database
from fixtures_db.hash_chain import utc_text
from station.results.certificate.content import Certificate
from station.results.certificate.issuing import issue
from station.results.certificate.missing_statements import (
    FROM_CALIBRATION,
    FROM_LABORATORY,
    LABORATORY_INSTEAD,
    missing,
)
from station.results.parameters_by_name import applied, parameters
from tests.empty_database import empty_db
from tests.station.results.certificate.factory import (
    NOON,
    REFERENCES,
    accepted,
    drifted,
    laboratory,
    rendered,
)


@pytest.fixture(scope="module")
def document(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    with empty_db(tmp_path_factory.mktemp("db") / "station.db") as database, database.write() as session:
        stored: dict[str, Any] = json.loads(accepted(session).document)
    return stored


@pytest.fixture
def db(tmp_path: Path) -> Iterator[Database]:
    with empty_db(tmp_path / "station.db") as opened:
        yield opened


def made(document: dict[str, Any], **changes: Any) -> Certificate:
    whole = Certificate("EX-2026-0001", NOON, document, "c0ffee" + "0" * 58, laboratory())
    return replace(whole, **changes)


def without(tree: Any, path: str) -> Any:
    """Return a copy of nested mappings without the value at a path; a list of references counts by kind."""
    tree = copy.deepcopy(tree)
    if path == "software.commit":
        tree["software"] = tree["software"].split(" (")[0]
        return tree
    *owners, last = path.split(".")
    node = tree
    for owner in owners:
        node = next(one for one in node if one["kind"] == owner) if isinstance(node, list) else node[owner]
    del node[last]
    return tree


class Text(HTMLParser):
    """Collects what a reader sees."""

    def __init__(self) -> None:
        super().__init__()
        self.parts = list[str]()
        self._hidden = 0

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self._hidden += tag == "style"

    def handle_endtag(self, tag: str) -> None:
        self._hidden -= tag == "style"

    def handle_data(self, data: str) -> None:
        if not self._hidden:
            self.parts.append(data)


def seen(html: str) -> str:
    parser = Text()
    parser.feed(html)
    return " ".join(" ".join(parser.parts).split())


def test_nothing_is_missing_of_the_whole_calibration(document: dict[str, Any]) -> None:
    assert missing(document, laboratory()) == []


@pytest.mark.parametrize("field", FROM_CALIBRATION)
def test_each_field_of_the_calibration_is_missed_by_name(document: dict[str, Any], field: str) -> None:
    lab = laboratory()
    if instead := LABORATORY_INSTEAD.get(field):  # the laboratory may say it
        assert missing(without(document, field), lab.model_validate(_filled(lab, instead))) == []
        lab = lab.model_validate(without(_filled(lab, instead), instead))
    assert missing(without(document, field), lab) == [(field, FROM_CALIBRATION[field])]


def _filled(lab: Any, path: str) -> dict[str, Any]:
    reported: dict[str, Any] = lab.model_dump()
    table, key = path.split(".")
    reported[table][key] = [21.0, 22.0] if key == "temperature_c" else "gravimeter"
    return reported


@pytest.mark.parametrize("field", FROM_LABORATORY)
def test_each_field_of_the_laboratory_is_missed_by_name(document: dict[str, Any], field: str) -> None:
    lab = laboratory()
    lacking = lab.model_validate(without(lab.model_dump(), field))
    assert missing(document, lacking) == [(field, FROM_LABORATORY[field])]


def test_a_parameter_without_uncertainty_is_missed(document: dict[str, Any]) -> None:
    for name in applied(parameters(document)):
        less = copy.deepcopy(document)
        less["uncertainty"]["parameters"] = [p for p in less["uncertainty"]["parameters"] if p["name"] != name]
        assert [field for field, _ in missing(less, laboratory())] == [f"uncertainty of {name}"]


def test_a_certificate_says_everything_the_standard_asks(document: dict[str, Any]) -> None:
    text = seen(rendered(made(document)))
    for reported in (
        "Calibration certificate", "No. EX-2026-0001", "Inertial Laboratory, Example Institute", "Marble Street 1",
        "Sky AG", "Am Flugplatz 3", "FOG-3", "S0101", "no damage seen", "2026-03-02",
        "2026-03-04 08:02 UTC to 2026-03-04 10:41 UTC", "Twelve-position calibration", "18 steps",
        "dwell_07 was recorded 2 times", "93474ad0c1de", "M. Curie", "Dr. A. Weber, Head of laboratory",
        "22.9 to 23.4 \u00b0C", "9.80729140 m/s\u00b2", "gravimeter, survey 12", "CMM 12, lab Weber",
        "electronic level 17", "2027-01-12", "2027-02-01", "held to UTC", "International System of Units",
        "coverage probability of approximately 95 %", "JCGM 106:2012", "5.1 % (r = 1.64), computed", "PASS",
        "first calibration of the unit", "c0ffee", "relate only to the item", "not be reproduced except in full",
        "End of calibration certificate EX-2026-0001",
    ):  # fmt: skip
        assert reported in text, reported
    html = rendered(made(document))
    assert 'content: "Page " counter(page) " of " counter(pages)' in html
    assert not re.search(r"(?:src|href)=|url\(|@import|<script", html)  # it needs no other file


def test_values_have_the_place_of_two_digits_of_their_uncertainty(document: dict[str, Any]) -> None:
    cells = re.findall(
        r'<td class="num value">([^<]+)</td><td class="num">([^<]+)</td><td>', rendered(made(document))
    )
    assert len(cells) >= 24
    for value, expanded in cells:
        value, expanded = value.rstrip("\u2007\u2008"), expanded.rstrip("\u2007\u2008")
        assert len(expanded.replace(".", "").lstrip("0")) == 2, expanded
        assert len(value.partition(".")[2]) == len(expanded.partition(".")[2])


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"due_date": "2026-03-03"}, "the certificate of cube CUBE-7 expired on 2026-03-03"),
        ({"due_date": "2026-03-04"}, None),  # the last day on which it holds
    ],
)
def test_an_expired_reference_makes_it_a_measurement_report(
    document: dict[str, Any], change: dict[str, str], reason: str | None
) -> None:
    document = {**document, "references": [{**REFERENCES[0], **change}, *REFERENCES[1:]]}
    certificate = made(document)
    text = seen(rendered(certificate))
    if reason is None:
        assert certificate.title.en == "Calibration certificate"
        return
    assert certificate.title.en == "Measurement report"
    assert text.index(f"Measured, not calibrated: {reason}") < text.index("Inertial measurement unit")
    assert "Calibration certificate" not in text
    assert "traceability to the SI is not claimed" in text


def test_a_calibration_stored_as_measured_stays_so_and_says_its_reason_once(document: dict[str, Any]) -> None:
    reason = "the certificate of slab SLAB-2 expired on 2026-02-01"
    references = [REFERENCES[0], {**REFERENCES[1], "due_date": "2026-02-01"}, REFERENCES[2]]
    document = {**document, "status": "measured", "status_reason": reason, "references": references}
    assert made(document).reasons == [reason]
    assert 'class="statement NOT"' in rendered(made(document))
    assert 'class="word PASS"' not in rendered(made(document))
    assert made({**document, "references": list(REFERENCES)}).title.en == "Measurement report"


def test_as_found_is_the_error_that_the_previous_parameters_left(db: Database) -> None:
    with db.write() as session:
        before = accepted(session, drifted(6.0), accepted_utc=datetime(2025, 3, 4, tzinfo=UTC))
        accepted(session)
    text = seen(issue(db, "S0101", laboratory()).html)
    assert "1 of 24 parameters had moved by more than U" in text
    sigma = 6 / 6**0.5  # both with sqrt 3 of the solve's sigma
    assert re.search(rf"gyroscope bias x\s+0\.862\S*\s+\u22120\.059\S*\s+0\.048\S* deg/h {sigma:.1f} moved", text)
    assert "accepted 2025-03-04 00:00 UTC, calibrated, verdict PASS" in text
    assert f"Previous calibration 2025-03-04 00:00 UTC {before.sha256}" in text
    assert utc_text(before.accepted_utc)[:10] in text


def test_what_people_write_is_text_not_html(document: dict[str, Any]) -> None:
    lab = laboratory().given("customer", {"name": "<script>alert(1)</script> & Sons"})
    html = rendered(made(document, laboratory=lab))
    assert "<script>" not in html
    assert "<script>alert(1)</script> & Sons" in seen(html)
