"""A digital certificate of every kind of campaign holds its schema and the rules of dcclib."""

import json
import re
from pathlib import Path

import pytest

from fixtures_db.database import open_db
from station.files.sha256sums import sha256_of
from station.results.certificate.dcc.validation import SCHEMA_FOLDER, rule_faults, schema_faults
from station.results.certificate.dcc.xml_writing import certificate_xml
from tests.paths import ROOT
from tests.station.results.certificate.dcc_kinds import KINDS, content, of_kind
from tests.station.results.certificate.factory import accepted


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    """Return the XML of every kind."""
    found = {}
    for number, kind in enumerate(KINDS):
        with open_db(tmp_path_factory.mktemp("db") / f"{number}.db") as database, database.write() as session:
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
    with open_db(tmp_path / "station.db") as database, database.write() as session:
        document = json.loads(accepted(session).document) | {"manifest": "5e" * 32}  # of a campaign with its steps
    page = (ROOT / "docs" / "certificate.md").read_text()
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
