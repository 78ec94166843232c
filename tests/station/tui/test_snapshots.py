"""How the screens look: pictures to compare with, taken anew by `pytest tests/station/tui --snapshot-update`."""

from collections.abc import Callable

import pytest

from station.tui.app import StationApp
from tests.station.tui import views
from tests.station.tui.session import LARGE, SMALL, MemorySession

LOOKS = [  # the usual ones are the pictures of docs/how-to/guided-calibration.md, see test_page.py
    ("start", SMALL, "ctrl+s"),
    ("warming", SMALL, ""),
    ("silent", SMALL, ""),
    ("tilted", SMALL, ""),
    ("asking", SMALL, ""),
    ("holding", SMALL, "question_mark"),
    ("turning", SMALL, "c"),
    ("broken", SMALL, ""),
    ("turning", LARGE, ""),
    ("failed", LARGE, ""),
]


@pytest.mark.parametrize(
    ("name", "size", "keys"), LOOKS, ids=lambda part: part if isinstance(part, str) else f"{part[0]}x{part[1]}"
)
def test_it_looks_as_it_did(
    name: str, size: tuple[int, int], keys: str, snap_compare: Callable[..., bool]
) -> None:
    app = StationApp(MemorySession(views.VIEWS[name]), refresh_hz=0.001, is_quiet=True)
    assert snap_compare(app, terminal_size=size, press=keys.split())


def test_high_contrast_looks_as_it_did(snap_compare: Callable[..., bool]) -> None:
    app = StationApp(MemorySession(views.HOLDING), refresh_hz=0.001, is_quiet=True)
    app.theme = "high-contrast"
    assert snap_compare(app, terminal_size=SMALL)
