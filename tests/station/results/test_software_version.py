"""What a result says of the program that made it."""

from importlib.metadata import FileHash, PackagePath
from types import SimpleNamespace

import pytest

from station.results import solution_json
from station.results.certificate.missing_statements import fields_of


def _installed(monkeypatch: pytest.MonkeyPatch, **hashes: str) -> str:
    files = [PackagePath(f"station/{name}.py") for name in hashes]
    for file, value in zip(files, hashes.values(), strict=True):
        file.hash = FileHash(f"sha256={value}")
    other = PackagePath("station/cli.pyc")
    other.hash = None
    monkeypatch.setattr(solution_json, "distribution", lambda name: SimpleNamespace(files=[*files, other]))
    return solution_json.installed_sources()


def test_an_installed_wheel_is_known_by_the_hash_of_its_sources(monkeypatch: pytest.MonkeyPatch) -> None:
    found = _installed(monkeypatch, cli="a", monitor="b")
    assert len(found) == 12
    assert found == _installed(monkeypatch, monitor="b", cli="a")
    assert found != _installed(monkeypatch, cli="a", monitor="c")
    assert _installed(monkeypatch) == ""
    software = fields_of({"software": f"fog-station 1.0.0 (sources {found})"})["software"]
    assert software["commit"] == found
