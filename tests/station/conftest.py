"""No test touches what the user's station remembers; the same counts are estimated once a process."""

from pathlib import Path

import pytest

from tests.estimated_once import counts_are_estimated_once

__all__ = ["counts_are_estimated_once"]


@pytest.fixture(autouse=True)
def _own_configuration(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("STATION_CONFIG", str(tmp_path / "configuration"))
