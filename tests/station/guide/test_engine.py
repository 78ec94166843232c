"""The engine as a process: a whole campaign over a pty, watched and steered through its socket."""

import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import pytest
from sqlalchemy import inspect, text

from drivers.simulated.server import SimulatedDevice
from drivers.simulated.truth import Truth
from fixtures_db.database import Database, open_db
from station.files.campaign_folder.campaign_reading import read_campaign
from station.files.campaign_setup import Setup
from station.guide.client import EngineConnection, engine_process
from station.guide.options import EngineOptions
from station.guide.start_screen import unfinished_campaigns
from station.guide.view import CalibrationView, OperatorCommand
from tests.patience import HANG_S, paced

SPEED = 100.0


@pytest.fixture
def device() -> Iterator[SimulatedDevice]:
    with SimulatedDevice(slow_unit(5), 5, speed=paced(SPEED)) as served:
        yield served


def slow_unit(seed: int) -> Truth:
    """Return a unit of few samples: what is told of a campaign does not hang on how many."""
    return replace(Truth.example(seed), sample_period_s=0.05)


def setup_for(device: SimulatedDevice, folder: Path) -> Setup:
    return Setup(
        url=device.url, latitude_deg=31.17, gravity_m_s2=device.truth.local_gravity, dwell_s=10.0, revolutions=1,
        folder=str(folder / "c"),
    )  # fmt: skip


def short_plan(folder: Path, turns: int = 0) -> Path:
    """Write a plan of a dwell on each of six faces, which is enough to solve, and of some turns about x."""
    steps = [f"[[dwell]]\nposition = {position}\nseconds = 8\n" for position in (1, 3, 5, 7, 9, 11)]
    steps += [f'[[turn]]\naxis = "x"\ndirection = "{way}"\nrevolutions = 1\n' for way in "+-"[:turns]]
    (path := folder / "plan.toml").write_text('format = "plan/1"\n' + "".join(steps))
    return path


def options_for(device: SimulatedDevice, folder: Path, first: OperatorCommand | None = None) -> EngineOptions:
    return EngineOptions(
        root=folder, database=str(folder / "s.db"), hands=device.control, move_s=5.0, warms_up=False, first=first
    )


class Screen(EngineConnection):
    """A screen that waits for what it is told to."""

    def __init__(self, path: Path) -> None:
        self._news = threading.Event()
        super().__init__(path, self._news.set)

    def wait(self, until: Callable[[CalibrationView], bool]) -> CalibrationView:
        """Return the first view that shows what is waited for."""
        deadline = time.monotonic() + HANG_S
        while time.monotonic() < deadline:
            if until(view := self.view):
                return view
            self._news.wait(1.0)
            self._news.clear()
        raise AssertionError(f"not within {HANG_S:g} s: {self.view.stage}, {self.view.line}")


def at(*stages: str) -> Callable[[CalibrationView], bool]:
    return lambda view: view.stage in stages


@pytest.mark.parametrize("when", ["connecting", "dwell"])
def test_cancel_leaves_the_database_as_it_was_and_the_files(
    device: SimulatedDevice, tmp_path: Path, when: str
) -> None:
    with open_db(tmp_path / "s.db") as database:
        before = dump(database)
    first = OperatorCommand(verb="begin", setup=setup_for(device, tmp_path))
    options = options_for(device, tmp_path, first).model_copy(update={"plan": short_plan(tmp_path)})
    with engine_process(options) as socket, Screen(socket) as screen:
        if when == "dwell":
            screen.wait(lambda v: v.stage == "dwell" and v.done >= 2)
        screen.wait(at(when))
        screen.send(OperatorCommand(verb="cancel"))
        view = screen.wait(at("cancelled"))
        assert "the database is unchanged" in view.line
    with open_db(tmp_path / "s.db") as database:
        assert dump(database) == before
    if when == "dwell":
        assert len(read_campaign(tmp_path / "c").campaign.dwells) >= 2


def dump(database: Database) -> list[str]:
    """Return every row of every table but the journal, which only grows, as text."""
    with database.read() as session:
        return [
            f"{table} {tuple(row)}"
            for table in sorted({*inspect(session.get_bind()).get_table_names()} - {"journal"})
            for row in session.execute(text(f"SELECT * FROM {table}"))
        ]


def test_a_killed_engine_is_reported_and_its_campaign_continues(device: SimulatedDevice, tmp_path: Path) -> None:
    first = OperatorCommand(verb="begin", setup=setup_for(device, tmp_path))
    options = options_for(device, tmp_path, first).model_copy(update={"plan": short_plan(tmp_path, 2)})
    socket = tmp_path / "engine"
    process = subprocess.Popen(
        [sys.executable, "-P", "-m", "station.guide.server", str(socket)], stdin=subprocess.PIPE, text=True
    )
    assert process.stdin is not None
    process.stdin.write(options.model_dump_json() + "\n")
    process.stdin.flush()
    with Screen(socket) as screen:
        screen.wait(lambda v: v.done >= 4)
        os.kill(process.pid, signal.SIGKILL)
        process.wait()
        process.stdin.close()
        view = screen.wait(at("failed"))
    assert "station resume" in view.error
    with open_db(tmp_path / "s.db") as database:
        [found] = unfinished_campaigns(database)
    assert found.done >= 4
    assert "of 8 done" in found.title
    assert found.state == "free"
    again = OperatorCommand(verb="resume", folder=found.folder)
    with engine_process(options_for(device, tmp_path, again)) as path, Screen(path) as screen:
        view = screen.wait(at("verdict"))
        assert view.done == 8
        assert all(step.attempts == 1 for step in view.steps)
    steps = read_campaign(tmp_path / "c").campaign
    assert (len(steps.dwells), len(steps.turns)) == (6, 2)


def test_another_unit_may_not_go_on_with_a_campaign(device: SimulatedDevice, tmp_path: Path) -> None:
    begin = OperatorCommand(verb="begin", setup=setup_for(device, tmp_path))
    with engine_process(options_for(device, tmp_path, begin)) as socket, Screen(socket) as screen:
        screen.wait(lambda v: v.done >= 1)
        screen.send(OperatorCommand(verb="leave"))
        screen.wait(at("left"))
    with SimulatedDevice(slow_unit(6), 6, speed=paced(SPEED)) as other:
        resume = OperatorCommand(verb="resume", folder=str(tmp_path / "c"))
        options = options_for(other, tmp_path, resume).model_copy(update={"setup": Setup(url=other.url)})
        with engine_process(options) as socket, Screen(socket) as screen:
            view = screen.wait(lambda v: v.start is not None and bool(v.start.refused))
            assert "serial number SIM-6 is connected, expected SIM-5" in view.start.refused
