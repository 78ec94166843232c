"""No test touches what the user's station remembers; counts are estimated, diagnoses and tables made once.

Programs that tests start are forked from one that has imported what they import, see tests/warm_starts.py.
"""

import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.computed_once import computed_once
from tests.schema_made_once import schema_is_made_once
from tests.warm_starts import FRESH, warm_starts

__all__ = ["computed_once", "schema_is_made_once"]


@pytest.fixture(autouse=True)
def _own_configuration(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("STATION_CONFIG", str(tmp_path / "configuration"))


@pytest.fixture(scope="session", autouse=True)
def _warm_starts() -> Iterator[None]:
    with warm_starts():
        yield


@pytest.fixture
def begun_from_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    """What this test starts is begun as by anybody's shell, imports and all."""
    monkeypatch.setattr(subprocess, "Popen", FRESH)
