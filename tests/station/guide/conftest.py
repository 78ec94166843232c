"""A guide in memory, or a database of its own, for each test that asks."""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from fixtures_db.database import Database
from tests.empty_database import empty_db
from tests.station.guide.rig import GuideRig


@pytest.fixture
def db(tmp_path: Path) -> Iterator[Database]:
    with empty_db(tmp_path / "station.db") as opened:
        yield opened


@pytest.fixture
def rig(tmp_path: Path) -> Iterator[Callable[..., GuideRig]]:
    made = list[GuideRig]()

    def make(*args: Any, **kwargs: Any) -> GuideRig:
        made.append(GuideRig(tmp_path, *args, **kwargs))
        return made[-1]

    yield make
    for each in made:
        each.database.close()
