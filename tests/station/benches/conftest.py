"""A bench in memory for each test."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.station.benches.bench_in_memory import Rig


@pytest.fixture
def rig(tmp_path: Path) -> Iterator[Rig]:
    made = Rig(tmp_path)
    yield made
    made.database.close()
