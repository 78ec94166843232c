"""An engine, a web server before it, and a browser."""

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.station.tui.web import chromium
from tests.station.tui.web.engine import Engine, WebServer


@pytest.fixture
def engine(tmp_path: Path) -> Iterator[Engine]:
    with Engine(tmp_path / "engine") as made:
        yield made


@pytest.fixture
def web(engine: Engine) -> Iterator[WebServer]:
    app = Path(__file__).with_name("little_app.py")
    with WebServer([sys.executable, str(app), str(engine.server_address)]) as made:
        yield made


@pytest.fixture(scope="module")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[chromium.Chromium]:
    if chromium.PROGRAM is None:
        pytest.skip("chromium is not installed here")
    with chromium.Chromium(tmp_path_factory.mktemp("profile")) as made:
        yield made
