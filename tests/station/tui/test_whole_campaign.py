"""A whole guided campaign on a simulated IMU over a pty: keys on the screen, and hands that follow the screen."""

import asyncio
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from textual.pilot import Pilot

from drivers.simulated.server import SimulatedDevice
from drivers.simulated.truth import Truth
from fixtures_db.database import open_db
from fixtures_db.stored_calibrations import history
from procedures.campaign.plan_steps import Dwell, turn_steps
from station.files.campaign_folder.campaign_reading import read_campaign
from station.files.campaign_folder.plan_file import write_plan
from station.files.campaign_setup import Setup
from station.guide.client import EngineConnection, engine_process
from station.guide.options import EngineOptions
from station.guide.view import CalibrationView
from station.tui.app import StationApp
from tests.patience import HANG_S, paced

SPEED = 60.0  # device seconds per second, on a machine of its own


async def seen(
    pilot: Pilot[None], screen: EngineConnection, until: Callable[[CalibrationView], bool]
) -> CalibrationView:
    """Let the screen run until its view shows what is waited for."""
    deadline = time.monotonic() + HANG_S
    while not until(view := screen.view):
        assert time.monotonic() < deadline, view
        assert view.start is None or not view.start.refused, view.start.refused
        await asyncio.sleep(0.05)
        await pilot.pause()
    assert isinstance(pilot.app, StationApp)
    pilot.app.pull()  # a key is for what the screen shows
    await pilot.pause()
    return screen.view


async def test_a_campaign_is_begun_redone_paused_stored_and_left_by_keys(tmp_path: Path) -> None:
    with SimulatedDevice(replace(Truth.example(5), sample_period_s=0.05), 5, speed=paced(SPEED)) as device:
        setup = Setup(
            url=device.url, latitude_deg=31.17, gravity_m_s2=device.truth.local_gravity,
            folder=str(tmp_path / "c"), operator="M. Huber",
        )  # fmt: skip
        plan = tmp_path / "plan.toml"
        write_plan(plan, (*(Dwell(position, 10.0) for position in (1, 3, 5, 7, 9, 11)), *turn_steps(1, 5.0)[:2]))
        options = EngineOptions(
            root=tmp_path, database=str(tmp_path / "s.db"), setup=setup, hands=device.control, move_s=5.0,
            plan=plan,
        )  # fmt: skip
        with engine_process(options) as socket, EngineConnection(socket) as screen:
            async with StationApp(screen, is_quiet=True).run_test(size=(80, 24)) as pilot:
                await seen(pilot, screen, lambda v: bool(v.start and v.start.readiness))
                await pilot.press("ctrl+s", "y")  # it has no cube, slab and limits, and says so
                await seen(pilot, screen, lambda v: v.stage == "warm_up")
                await seen(pilot, screen, lambda v: v.done >= 2)
                await pilot.press("r")
                await seen(pilot, screen, lambda v: any(step.superseded for step in v.steps))
                await pilot.press("p")
                await seen(pilot, screen, lambda v: v.stage == "paused")
                await pilot.press("p")
                verdict = (await seen(pilot, screen, lambda v: v.stage == "verdict")).verdict
                await pilot.press("s", "y")
                stored = await seen(pilot, screen, lambda v: v.stage == "stored")
                await pilot.press("q")
                assert not pilot.app.is_running
    assert verdict.word == "NOT_MEASURED"
    with open_db(tmp_path / "s.db") as database, database.read() as session:
        assert [row.sha256 for row in history(session, "SIM-5")] == [stored.verdict.stored_sha256]
    campaign = read_campaign(tmp_path / "c").campaign
    assert (len(campaign.dwells), len(campaign.turns)) == (6, 2)
