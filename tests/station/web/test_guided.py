"""A guided calibration in a browser: tabs come and go, the campaign is the engine's."""

import threading
from collections.abc import Callable
from pathlib import Path

from drivers.simulated.server import SimulatedDevice
from drivers.simulated.truth import Truth
from station.guide.client import Connection
from station.guide.view import View
from tests.station.commands.program import Program
from tests.station.web.chromium import Chromium
from tests.station.web.engine import DEADLINE_S, has_ended


class Watch:
    """A look at the engine beside the screens."""

    def __init__(self, socket: Path) -> None:
        self._changed = threading.Event()
        self._connection = Connection(socket, self._changed.set)

    def until(self, holds: Callable[[View], bool]) -> View:
        while not holds(view := self._connection.view):
            assert self._changed.wait(DEADLINE_S), view
            self._changed.clear()
        return view

    def close(self) -> None:
        self._connection.close()


def screens_of(process: int) -> dict[int, Path]:
    """Return the socket that each screen of a web server looks at, by the screen's process."""
    children = Path(f"/proc/{process}/task/{process}/children").read_text().split()
    commands = {int(child): Path(f"/proc/{child}/cmdline").read_text().split("\0") for child in children}
    return {child: Path(words[-2]) for child, words in commands.items() if "station.tui" in words}


def test_tabs_come_and_go_and_the_campaign_goes_on(browser: Chromium, tmp_path: Path) -> None:
    where = ("--out", str(tmp_path / "c"), "--db", str(tmp_path / "s.db"))
    site = ("--latitude", "31.17", "--dwell-s", "10", "--no-warm-up", "--move-s", "5")
    with SimulatedDevice(Truth.example(5), 5, speed=60) as device:
        simulated = ("--device", device.url, "--hands", device.control)
        with Program("calibrate", "--web", "--port", "0", *simulated, *site, *where) as program:
            url = program.until("http://127.0.0.1:")[-1].strip()
            first, second = (browser.open(url) for _ in range(2))
            for page in (first, second):
                page.until("document.body.classList.contains('-first-byte')")
            screens = screens_of(program.process.pid)
            assert len(screens) == 2
            watch = Watch(next(iter(screens.values())))
            watch.until(lambda view: view.stage == "dwell")
            first.press("p")
            watch.until(lambda view: view.stage == "paused")
            second.press("p")
            done = watch.until(lambda view: view.stage != "paused").done
            for page in (first, second):
                page.close()
            assert all(has_ended(screen) for screen in screens)
            watch.until(lambda view: view.done >= done + 2)
            third = browser.open(url)
            third.until("document.body.classList.contains('-first-byte')")
            third.press("p")
            watch.until(lambda view: view.stage == "paused")
            third.close()
            watch.close()
            program.process.terminate()
            assert program.end() == (0, "", "")
    assert len(list((tmp_path / "c").glob("session_*.mcap"))) == 1  # one engine, one reader, all along
