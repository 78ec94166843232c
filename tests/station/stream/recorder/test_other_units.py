"""Other units than the usual one: three gyros as one, a single gyro, rates: recorded, solved, or refused."""

import json
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

import numpy as np
import pytest

from drivers.simulated.server import SimulatedDevice
from drivers.simulated.truth import Truth
from drivers.wire import FORMATS
from fixtures_db.database import open_db
from procedures.campaign.plan_steps import Dwell, turn_steps
from station import cli
from station.files.mcap_files import read_step
from station.stream.live.live_feed import open_feed
from station.stream.live.stillness import runs_of_blocks
from station.stream.recorder.accepted_step_writer import open_campaign
from station.stream.recorder.sample_stream import check_raw_bytes
from tests.station.stream.live.bench_in_memory import SITE, Source

TRUTH = Truth.example(4)
DWELL_S, MARGIN_S = 10, 5.0


@pytest.mark.parametrize("format", ["triad", "stim300"])
def test_what_is_recorded_of_a_unit_is_solved(format: str, tmp_path: Path) -> None:
    (tmp_path / "c").mkdir()
    source = Source(TRUTH, format=format)
    feed = open_feed(source)
    unit = feed.identify("FOG", "T-1")
    hands, blocks = source.device, feed.blocks()
    with open_db(tmp_path / "s.db") as database:
        recorder = open_campaign(tmp_path / "c", unit, SITE, database)
        for position in range(1, 13):
            hands.execute(f"place {position} 5")
            begins, kept = hands.imu.done + MARGIN_S, []
            while len(kept) < DWELL_S:
                kept += [block for block in [next(blocks)] if block.begins > begins]
            recorder.accept(Dwell(position, DWELL_S), feed.buffer, runs_of_blocks(kept, None))
        for turn in turn_steps(1, MARGIN_S):
            hands.execute(f"place {turn.start_position} 5")
            begins = hands.imu.done + MARGIN_S
            hands.execute("rest 12")
            hands.execute(f"turn {turn.axis} {turn.direction} 1")
            ends, kept = hands.imu.done + MARGIN_S, []
            while not kept or kept[-1].ends < ends:
                kept += [block for block in [next(blocks)] if block.begins > begins]
            recorder.accept(turn, feed.buffer, runs_of_blocks(kept, None))
    assert cli.run(["solve", str(tmp_path / "c"), "--json", str(tmp_path / "s.json")]) == 0
    found = json.loads((tmp_path / "s.json").read_text())
    assert ("accelerometer" in found) == (format == "stim300")
    true = source.device.truth
    for name, k in (("accelerometer", true.accel_k), ("gyroscope", true.gyro_k)):
        if name in found:
            scale = found[name]["scale_factor"]
            assert np.all(np.abs(scale["value"] - k) < 5 * np.array(scale["std"])), name


@pytest.fixture
def single() -> Iterator[SimulatedDevice]:
    with SimulatedDevice(Truth.example(5), 5, "ch70", speed=4) as device:
        yield device


def test_one_gyro_alone_says_which_channels_are_none(
    single: SimulatedDevice, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.run(["record", single.url, "--seconds", "0.5", "--out", str(tmp_path / "r")]) == 0
    assert "ch70 does not measure gy, gz: 0 stands there" in capsys.readouterr().out


def test_a_guided_calibration_of_gyros_alone_is_refused(
    single: SimulatedDevice, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    where = ("--out", str(tmp_path / "c"), "--db", str(tmp_path / "s.db"), "--latitude", "31.17")
    unit = ("--model", "CH-70", "--serial", "1")
    assert cli.run(["calibrate", "--headless", "--device", single.url, *where, *unit]) == 3
    error = capsys.readouterr().err
    assert "found ch70 without ax, ay, az, gy, gz, expected an IMU with six channels" in error
    assert error.count("\n") == 1
    assert not (tmp_path / "c").exists()


def test_a_triad_is_recorded_like_one_device(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with ExitStack() as served:
        truth = Truth.example(5)
        devices = [served.enter_context(SimulatedDevice(truth, seed, "ch70", speed=4)) for seed in range(3)]
        ports = [device.url.partition("?")[0] for device in devices]
        url = f"triad:?x={ports[0]}&y={ports[1]}&z={ports[2]}&format=ch70"
        assert cli.run(["record", url, "--seconds", "0.5", "--out", str(tmp_path / "r")]) == 0
    assert "samples of triad" in capsys.readouterr().out
    path = tmp_path / "r/recording.mcap"
    contents = read_step(path)
    assert check_raw_bytes(path, FORMATS["triad"]) == len(contents) >= 90
    assert contents.gyro is not None
    assert (contents.gyro != 0).any(axis=0).all()
    assert contents.accel is None
