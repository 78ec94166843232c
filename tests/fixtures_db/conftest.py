from collections.abc import Iterator
from pathlib import Path

import pytest

from fixtures_db.database import Database, open_db


@pytest.fixture
def db(tmp_path: Path) -> Iterator[Database]:
    with open_db(tmp_path / "station.db") as opened:
        yield opened
