"""User-defined error terms written from a diagnosis, with where they were found."""

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


def test_an_effect_of_a_diagnosis_is_written_with_its_origin(
    warming: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = read_effect(warming)
    entry = {"effect": file.name, "definition": file.text, "sha256": file.sha256}
    origin = {"model": "FOG-3", "serial": "S1", "files": {"campaign.toml": "ab" * 32}}
    document = {
        "format": "diagnosis/2",
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
        assert file.name in capsys.readouterr().err
    for findings in ([], [entry, entry], [{**entry, "sha256": "0" * 64}]):
        diagnosis.write_text(json.dumps({**document, "findings": findings}))
        assert cli.run(["effects", "adopt", str(diagnosis), "--out", str(out)]) == 3
    assert read_effect(out).sha256 == found.sha256


def test_the_page_states_the_hash_of_its_example() -> None:
    page = (Path(__file__).parents[3] / "docs/how-to/own-effects.md").read_text()
    example = page.split("```toml\n")[1].split("```")[0]
    assert f'sha256 = ["{hashlib.sha256(example.encode()).hexdigest()}"]' in page
