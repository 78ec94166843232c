"""A guide in memory for each test."""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.station.guide.rig import GuideRig


@pytest.fixture
def rig(tmp_path: Path) -> Iterator[Callable[..., GuideRig]]:
    made = list[GuideRig]()

    def make(*args: Any, **kwargs: Any) -> GuideRig:
        made.append(GuideRig(tmp_path, *args, **kwargs))
        return made[-1]

    yield make
    for each in made:
        each.database.close()
