"""A digital certificate of every kind of campaign holds its schema and rules; what stands next to its results."""

import json
import re
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from station.files.sha256sums import sha256_of
from station.results.certificate.conformity import AsFound, Shift
from station.results.certificate.dcc.digital_certificate import (
    SCHEMA_FOLDER,
    certificate_xml,
    rule_faults,
    schema_faults,
)
from station.results.certificate.dcc.results import effects_and_global_test
from tests.empty_database import empty_db
from tests.paths import ROOT
from tests.station.results.certificate.dcc_kinds import KINDS, content, of_kind
from tests.station.results.certificate.dcc_numbers import NS, of_type
from tests.station.results.certificate.factory import accepted


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    """Return the XML of every kind."""
    found = {}
    for number, kind in enumerate(KINDS):
        with empty_db(tmp_path_factory.mktemp("db") / f"{number}.db") as database, database.write() as session:
            found[kind] = certificate_xml(of_kind(session, kind))
    return found


@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_holds_schema_and_rules(written: dict[str, bytes], kind: str) -> None:
    assert schema_faults(written[kind]) == []
    if (faults := rule_faults(written[kind])) is None:
        pytest.skip("dcclib is not installed: pip install -e '.[dcc]'")
    assert faults == []


@pytest.mark.parametrize(
    ("good", "bad"),
    [
        (b'schemaVersion="3.1.2"', b'schemaVersion="3.3.0"'),
        (b"<si:unit>", b"<si:unit> </si:unit><si:unit>"),
        (b"<dcc:uniqueIdentifier>EX-2026-0001</dcc:uniqueIdentifier>", b""),
    ],
)
def test_what_breaks_the_schema_is_found(written: dict[str, bytes], good: bytes, bad: bytes) -> None:
    whole = written["twelve positions"]
    assert good in whole
    assert schema_faults(whole.replace(good, bad)) != []


def test_the_page_names_what_stands_in_the_xml(written: dict[str, bytes], tmp_path: Path) -> None:
    with empty_db(tmp_path / "station.db") as database, database.write() as session:
        document = json.loads(accepted(session).document) | {"manifest": "5e" * 32}  # of a campaign with its steps
    page = (ROOT / "docs/how-to/certificate.md").read_text()
    named = set(re.findall(r"`?((?:fog|basic)_\w+)", page)) - {"fog_", "basic_", "fog_NAME"}
    assert len(named) > 40
    texts = b" ".join([*written.values(), certificate_xml(content(document))]).decode()
    assert {one for one in named if one not in texts} == set()
    written_names = set(" ".join(re.findall(r'refType="([^"]+)"', texts)).split())
    triads = re.compile(r"fog_(accelerometer|gyroscope|residual|own)\.")  # a parameter's, an effect's own name
    assert {one for one in written_names if not triads.match(one)} - named == set()


@pytest.mark.parametrize(
    ("name", "sha256"),
    [
        ("dcc.xsd", "daf869dc4d03b53ca2d33fc4894ffa4ec4e109b81fcd0ebcd74aa8a63f617e11"),
        ("SI_Format.xsd", "42e158ac16d0125b8cff32bedd5cf3e434955b729a00c9867f0510faa7905f2e"),
        ("COPYING.LESSER", "c8b2a6566cc9ffef6c2c73d9394cea85a4a0f6d64ac64c87850f6d6883fd0464"),
    ],
)
def test_the_schemas_are_those_of_the_institute_unmodified(name: str, sha256: str) -> None:
    assert sha256_of(SCHEMA_FOLDER / name) == sha256


SHIFT = Shift("gyroscope.bias.x", "deg/h", 1.5, -0.25, 0.125)
BEFORE = AsFound("ab" * 32, "2026-03-04T12:00:00Z", "calibrated", "PASS", "PASS", (SHIFT,))
EFFECT = {"name": "own.odd", "unit": "deg/h", "coefficients": {"c": {"value": 0.5, "std": 0.25}}}


def parts(before: AsFound | None = None, **document: Any) -> list[Any]:
    reported: Any = SimpleNamespace(document=document, before=before)
    return list(effects_and_global_test(reported))


def numbers_of(element: Any, *paths: str) -> list[str | None]:
    return [element.findtext(f".//si:{path}", None, NS) for path in paths]


@pytest.mark.parametrize(
    ("reported", "found"),
    [
        ({}, []),
        ({"residual": {}, "effects": ()}, []),
        ({"residual": {"chi2_of_others": 1.0}}, []),
        ({"before": replace(BEFORE, shifts=())}, []),
        ({"residual": {"dof": 27}}, ["fog_globalTest"]),
        ({"effects": (EFFECT,)}, ["fog_effects"]),
        ({"before": BEFORE}, ["fog_asFound"]),
        (
            {"residual": {"dof": 27}, "effects": (EFFECT,), "before": BEFORE},
            ["fog_globalTest", "fog_effects", "fog_asFound"],
        ),
    ],
)
def test_each_part_is_there_where_something_is_known_of_it(reported: dict[str, Any], found: list[str]) -> None:
    assert [one.find("dcc:data", NS).getparent().get("refType") for one in parts(**reported)] == found


@pytest.mark.parametrize(
    ("coefficient", "reported"),
    [
        ({"value": 0.5, "std": 0.25}, ["0.5", r"\degree\hour\tothe{-1}", "own.odd.c", "0.25", "1.0"]),
        ({"value": 0.5}, ["0.5", r"\degree\hour\tothe{-1}", "own.odd.c", None, None]),
        ({"value": 0.5, "std": 0.0}, ["0.5", r"\degree\hour\tothe{-1}", "own.odd.c", "0.0", "1.0"]),
    ],
)
def test_a_coefficient_has_its_sigma_where_it_has_one(coefficient: dict[str, float], reported: list[str]) -> None:
    (made,) = parts(effects=({**EFFECT, "coefficients": {"c": coefficient}},))
    assert numbers_of(made, "value", "unit", "label", "uncertainty", "coverageFactor") == reported


def test_a_shift_has_what_was_applied_the_error_with_its_u_and_how_many_sigmas_that_is() -> None:
    (made,) = parts(BEFORE)
    (shift,) = of_type(made, "fog_shift", "list")
    assert shift.get("refId") == "gyroscope.bias.x"
    found = {
        one.get("refType"): numbers_of(one, "value", "uncertainty", "coverageFactor")
        for one in shift.iterfind("dcc:quantity", NS)
    }
    assert found == {
        "fog_appliedBefore": ["1.5", None, None],
        "basic_measurementError": ["-0.25", "0.125", "2.0"],
        "fog_errorOverStandardUncertainty": [found["fog_errorOverStandardUncertainty"][0], None, None],
    }
    assert abs(float(found["fog_errorOverStandardUncertainty"][0] or 0)) == 4.0


def test_the_date_of_the_measurement_is_not_that_of_the_issue(tmp_path: Path) -> None:
    with empty_db(tmp_path / "station.db") as database, database.write() as session:
        document = json.loads(accepted(session).document)
    late = content(document, issued_utc=datetime(2026, 4, 1, 12, tzinfo=UTC))
    xml = certificate_xml(late).decode()
    dates = [re.search(rf"{name}Date>(.*?)<", xml) for name in ("beginPerformance", "endPerformance")]
    assert [found and found[1] for found in dates] == ["2026-03-04", "2026-03-04"]
