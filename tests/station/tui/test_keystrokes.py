"""How many keys a whole calibration takes beside what is typed into the form: as few as the page says."""

import re
from dataclasses import replace
from pathlib import Path

from drivers.simulated.server import SimulatedDevice
from fixtures_db.database import open_db
from station.demo.example_bench import GRAVITY_STD, add_example
from station.files.setup import Setup
from station.guide.client import EngineConnection
from station.guide.start_engine import EngineOptions, engine_process
from station.tui.app import StationApp
from tests.patience import paced
from tests.station.tui.test_page import PAGE
from tests.station.tui.test_whole_campaign import SPEED, seen

SEED, MOST = 7, 12


async def test_a_calibration_from_the_filled_form_to_the_stored_pass_takes_the_keys_the_page_says(
    tmp_path: Path,
) -> None:
    with open_db(tmp_path / "s.db") as database, database.write() as session:
        bench = add_example(session, SEED)
    pressed = list[str]()
    with SimulatedDevice(replace(bench.truth, sample_period_s=0.05), SEED, speed=paced(SPEED)) as device:
        setup = Setup(
            url=device.url, cube=bench.cube, slab=bench.slab, operator="M. Huber", dwell_s=4.0, revolutions=1,
            latitude_deg=bench.truth.latitude_deg, gravity_m_s2=bench.truth.local_gravity,
            gravity_std_m_s2=GRAVITY_STD, folder=str(tmp_path / "c"),
            heading_std_deg=bench.truth.heading_std_deg, closure_std_deg=bench.truth.closure_std_deg,
        )  # fmt: skip
        options = EngineOptions(
            root=tmp_path, database=str(tmp_path / "s.db"), setup=setup, hands=device.control, move_s=5.0
        )
        with engine_process(options) as socket, EngineConnection(socket) as screen:
            async with StationApp(screen, is_quiet=True).run_test(size=(80, 24)) as pilot:

                async def press(*keys: str) -> None:
                    pressed.extend(keys)
                    await pilot.press(*keys)

                # once the port was looked at: a set-up that cannot certify is asked about first
                await seen(pilot, screen, lambda v: bool(v.start and (r := v.start.readiness) and r.can_certify))
                ready = screen.view.start.readiness
                await press("ctrl+s")
                verdict = (await seen(pilot, screen, lambda v: v.stage == "verdict")).verdict
                await press("s", "y")
                await seen(pilot, screen, lambda v: v.stage == "stored")
                await press("q")
                assert not pilot.app.is_running
    assert ready.can_certify
    assert (verdict.word, verdict.status) == ("PASS", "calibrated")
    said = re.search(r"takes (\d+) keys, besides what is typed into the form", PAGE)
    assert said is not None
    assert int(said[1]) == len(pressed) <= MOST
