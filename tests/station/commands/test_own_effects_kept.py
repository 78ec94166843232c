"""Effects of one's own in the database, and written from a diagnosis."""

import hashlib
import json
from pathlib import Path

import pytest

from station import cli
from station.files.effect_file import read_effect
from tests.station.effect_examples import WARMING


@pytest.fixture
def warming(tmp_path: Path) -> Path:
    """Return an effect's file."""
    (tmp_path / "effect.toml").write_text(WARMING)
    return tmp_path / "effect.toml"


def test_the_life_of_an_effect_in_the_database(
    warming: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    db, of = ["--db", str(tmp_path / "station.db")], ["--model", "FOG-3", "--serial", "S1"]
    sha256, name = read_effect(warming).sha256, "gyroscope.warming_while_warm"

    def said(*arguments: str, code: int = 0) -> str:
        assert cli.run(["effects", *arguments, *db]) == code
        out, error = capsys.readouterr()
        assert "Traceback" not in error
        return out + error

    assert "no effect" in said("list")
    for empty in (["--model", " "], ["--model", "FOG-3", "--serial", ""]):
        assert "empty" in said("add", str(warming), *empty, code=2)
    assert sha256 in (added := said("add", str(warming), *of))
    assert "FOG-3 S1 is not known yet" in added
    assert "is in force already with these bytes; nothing to do" in said("add", str(warming), *of, code=3)
    assert name in said("show", "gyroscope.magic", code=3)
    assert name in said("list")
    assert "FOG-3 S1" in said("list")
    assert "catalogue" in said("list", "--catalogue")
    assert "in force for FOG-3 S1 since" in said("show", name)
    assert cli.run(["verify", *db]) == 0
    capsys.readouterr()
    assert "withdrawn from FOG-3 S1" in said("withdraw", name, *of)
    assert "no effect" in said("list")
    assert "not in force" in said("withdraw", name, *of, code=3)


def test_an_effect_of_a_diagnosis_is_written_with_its_origin(
    warming: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = read_effect(warming)
    entry = {"effect": file.name, "definition": file.text, "sha256": file.sha256}
    origin = {"model": "FOG-3", "serial": "S1", "files": {"campaign.toml": "ab" * 32}}
    document = {
        "format": "diagnosis/1",
        "findings": [{"effect": "slab.tilt"}, entry],
        "solution": {"provenance": origin},
    }
    diagnosis, out = tmp_path / "diagnosis.json", tmp_path / "adopted.toml"
    diagnosis.write_text(json.dumps(document))
    assert cli.run(["effects", "adopt", str(diagnosis), "--out", str(out)]) == 0
    found = read_effect(out)
    assert found.term == file.term
    assert found.origin is not None
    assert found.origin.campaigns == [f"FOG-3 S1 campaign.toml {'ab' * 32}"]
    assert found.origin.diagnosis_sha256 == hashlib.sha256(diagnosis.read_bytes()).hexdigest()
    assert cli.run(["effects", "adopt", str(diagnosis), "--finding", "2", "--out", str(out)]) == 0
    assert cli.run(["effects", "adopt", str(diagnosis), "--finding", file.name, "--out", str(out)]) == 0
    capsys.readouterr()
    for number in ("1", "3"):
        assert cli.run(["effects", "adopt", str(diagnosis), "--finding", number, "--out", str(out)]) == 3
        assert (
            f"finding {number} without a term of its own, expected one of 2 {file.name}" in capsys.readouterr().err
        )
    for text, expected in (
        (json.dumps({**document, "findings": []}), "the catalogue's effects need no file"),
        (json.dumps({**document, "findings": [entry, entry]}), "give --finding N"),
        (json.dumps({**document, "findings": [{**entry, "sha256": "0" * 64}]}), "take what was stored"),
        ("{", "no diagnosis/1"),
        ("[]", "no diagnosis/1"),
    ):
        diagnosis.write_text(text)
        assert cli.run(["effects", "adopt", str(diagnosis), "--out", str(out)]) == 3
        (said,) = capsys.readouterr().err.strip().splitlines()
        assert expected in said
    assert read_effect(out).sha256 == found.sha256


def test_the_page_states_the_hash_of_its_example() -> None:
    page = (Path(__file__).parents[3] / "docs/own-effects.md").read_text()
    example = page.split("```toml\n")[1].split("```")[0]
    assert f'sha256 = ["{hashlib.sha256(example.encode()).hexdigest()}"]' in page
