"""A device that sends rates, not counts: its campaign is recorded as rates, guided like any other, and solves."""

import json
from pathlib import Path

import numpy as np
import pytest

from drivers.simulated.truth import Truth
from drivers.wire import FORMATS
from fixtures_db.database import open_db
from procedures.campaign.plan_steps import Dwell
from station import cli
from station.files.campaign_folder.campaign_reading import read_campaign
from station.stream.live.accepted_blocks import runs_of_blocks, series_of_runs
from station.stream.live.live_feed import open_feed
from station.stream.live.rates_as_counts import RATE_UNIT
from station.stream.live.stillness import Stillness
from station.stream.recorder.accepted_step_writer import open_campaign
from station.stream.recorder.raw_check import check_raw_bytes
from tests.station.stream.live.bench_in_memory import SITE, Source

TRUTH = Truth.example(4)
DWELL_S = 20


def test_twelve_dwells_of_a_kvh_1750_give_its_accelerometers(tmp_path: Path) -> None:
    folder = tmp_path / "c"
    folder.mkdir()
    source = Source(TRUTH, format="kvh1750")
    feed, still = open_feed(source), Stillness()
    unit = feed.identify("1750", "K-1")
    with open_db(tmp_path / "s.db") as database:
        recorder = open_campaign(folder, unit, SITE, database, output=feed.wire.output)
        for position in range(1, 13):
            source.device.obey(f"place {position} 5")
            moved = source.device.imu.done + 10.0
            blocks = feed.blocks()
            kept = []
            while len(kept) < DWELL_S:
                block = next(blocks)
                still.learn(block)
                if block.begins > moved and (not still.is_known or still.is_still(block)):
                    kept.append(block)
            recorder.accept(Dwell(position, DWELL_S), feed.buffer, runs_of_blocks(kept, None))
            g = series_of_runs(feed.buffer, runs_of_blocks(kept, None), unit.period).accel
            assert g is not None
            assert np.linalg.norm(g.mean(axis=0)) / unit.period / RATE_UNIT == pytest.approx(1.0, rel=0.1)
    assert 'output = "rate"' in (folder / "campaign.toml").read_text()
    for dwell in read_campaign(folder).campaign.dwells:
        assert check_raw_bytes(folder / dwell.name, FORMATS["kvh1750"]) == DWELL_S / TRUTH.sample_period_s
    out = tmp_path / "out.json"
    assert cli.run(["solve", str(folder), "--json", str(out), "--db", str(tmp_path / "s.db")]) == 0
    k = json.loads(out.read_text())["accelerometer"]["scale_factor"]
    assert k["unit"] == "output/g"
    off = np.array(k["value"]) - TRUTH.accel_k / 1000.0  # g per g
    assert np.all(np.abs(off) < 4 * np.array(k["std"]) + 1e-7)  # 32-bit floats: 6e-8


def test_a_unit_at_rest_is_still_and_one_that_is_shaken_is_not() -> None:
    source = Source(TRUTH, format="kvh1750")
    feed, still = open_feed(source), Stillness()
    feed.identify("1750", "K-1")
    blocks = feed.blocks()
    for _ in range(20):
        still.learn(next(blocks))
    assert still.is_still(next(blocks))
    source.device.obey("knock 3 0.01")
    assert not all(still.is_still(next(blocks)) for _ in range(3))
