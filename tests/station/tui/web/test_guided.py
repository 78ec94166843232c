"""A guided calibration in a browser: tabs come and go, the campaign is the engine's."""

import threading
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from drivers.simulated.server import SimulatedDevice
from drivers.simulated.truth import Truth
from fixtures_db.database import open_db
from procedures.campaign.plan_steps import Dwell
from station.files.campaign_folder.plan_file import keep_plan
from station.guide.client import EngineConnection
from station.guide.view import CalibrationView, CommandVerb, OperatorCommand
from station.tui.app import STATION
from tests.patience import HANG_S, paced
from tests.station.commands.program import Program
from tests.station.guide.stored import recorded
from tests.station.tui.web.chromium import Chromium, Page
from tests.station.tui.web.engine import has_ended


class Watch:
    """A look at the engine next to the screens."""

    def __init__(self, socket: Path) -> None:
        self._changed = threading.Event()
        self._connection = EngineConnection(socket, self._changed.set)

    def until(self, holds: Callable[[CalibrationView], bool]) -> CalibrationView:
        while not holds(view := self._connection.view):
            assert self._changed.wait(HANG_S), view
            self._changed.clear()
        return view

    def send(self, verb: CommandVerb) -> None:
        self._connection.send(OperatorCommand(verb=verb))

    def __enter__(self) -> "Watch":
        return self

    def __exit__(self, *_: object) -> None:
        self._connection.close()


def children(process: int, module: str) -> dict[int, Path]:
    """Return the processes that run a module as children of another, and the last argument of each."""
    numbers = Path(f"/proc/{process}/task/{process}/children").read_text().split()
    commands = {int(child): Path(f"/proc/{child}/cmdline").read_text().split("\0") for child in numbers}
    return {child: Path(words[-2]) for child, words in commands.items() if module in words}


def open_screen(browser: Chromium, url: str) -> Page:
    """Open a tab and wait until the campaign is drawn in it."""
    page = browser.open(url)
    page.until_colour(STATION.background or "")
    return page


def test_tabs_come_and_go_and_the_campaign_goes_on(browser: Chromium, tmp_path: Path) -> None:
    where = ("--out", str(tmp_path / "c"), "--db", str(tmp_path / "s.db"))
    site = ("--latitude", "31.17", "--dwell-s", "5", "--no-warm-up", "--move-s", "5")
    with SimulatedDevice(replace(Truth.example(5), sample_period_s=0.05), 5, speed=paced(40.0)) as device:
        simulated = ("--device", device.url, "--hands", device.control)
        with Program("calibrate", "--web", "--port", "0", *simulated, *site, *where) as program:
            url = program.until("http://127.0.0.1:")[-1].strip()
            [socket] = children(program.process.pid, "station.guide.server").values()
            with Watch(socket) as watch:
                watch.until(lambda view: view.live != "")
                watch.send("pause")
                watch.until(lambda view: view.stage == "paused")
                first = open_screen(browser, url)
                first.press("p")
                watch.until(lambda view: view.stage != "paused")
                second = open_screen(browser, url)
                second.press("p")
                done = watch.until(lambda view: view.stage == "paused").done
                screens = children(program.process.pid, "station.tui")
                assert len(screens) == 2
                for page in (first, second):
                    page.close()
                assert all(has_ended(screen) for screen in screens)
                watch.send("go_on")
                watch.until(lambda view: view.done > done)
                watch.send("pause")
                watch.until(lambda view: view.stage == "paused")
                third = open_screen(browser, url)
                third.press("p")
                watch.until(lambda view: view.stage != "paused")
                third.close()
            program.process.terminate()
            assert program.end() == (0, "", "")
    assert len(list((tmp_path / "c").glob("session_*.mcap"))) == 1  # one engine, one reader, all along


def test_o_opens_the_report_in_another_tab(browser: Chromium, tmp_path: Path) -> None:
    database = tmp_path / "s.db"
    with open_db(database) as opened:
        folder = recorded(tmp_path / "c", opened)
        keep_plan(folder, tuple(Dwell(position, 4.0) for position in range(1, 13)))
    with Program("resume", str(folder), "--web", "--port", "0", "--db", str(database)) as program:
        reported = program.until("http://127.0.0.1:")
        assert "Open this address in a browser on this computer" in reported[0]
        url = reported[-1].strip()
        [socket] = children(program.process.pid, "station.guide.server").values()
        with Watch(socket) as watch:
            watch.until(lambda view: view.stage == "verdict")
            page = open_screen(browser, url)
            page.press("o")
            wait_for_tab(browser, page, f"{url}report", "Calibration report SIM-FOG3 SIM-7")
            page.close()
        program.process.terminate()
        assert program.end() == (0, "", "")


def wait_for_tab(browser: Chromium, page: Page, url: str, title: str) -> None:
    """Wait until a tab shows a document of this title at an address, and close it."""
    while True:
        for target in browser.ask("Target.getTargets")["targetInfos"]:
            if (target["url"], target["title"]) == (url, title):
                browser.ask("Target.closeTarget", targetId=target["targetId"])
                return
        page.value("new Promise(done => setTimeout(done, 100))")
