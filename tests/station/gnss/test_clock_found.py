"""A simulated unit whose clock is off, beside a simulated receiver, recorded and diagnosed; in their own time."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np

from drivers.ports import parse_device_url
from drivers.simulated.autopilot import Autopilot
from drivers.simulated.autopilot_truth import AutopilotTruth
from drivers.simulated.device import ByteDevice
from drivers.simulated.truth import Truth
from fixtures_db.database import open_db
from procedures.steps import Dwell
from station import cli
from station.campaign_folder import read_campaign
from station.gnss import GnssFeed
from station.live import open_feed
from station.reader import Chunk, GapMark
from station.recorder import open_campaign
from tests.station.live.bench_in_memory import SITE

PPM = 150.0
BOOT_NS = 10**18  # of the station's clock at true time 0
READ_S = 0.1  # the IMU's bytes come in pieces as long
STEP_S = 0.004  # the autopilot's as they are written
JITTER_S = 3e-3  # of a read


class Bench:
    """Both devices on one true time; each source is polled by its feed."""

    def __init__(self) -> None:
        truth = replace(Truth.example(5), effects={"clock.rate": {"value": PPM}})
        self.device = ByteDevice(truth, 5, "counts")
        self.autopilot = Autopilot(truth, AutopilotTruth(default_hz=5.0))
        self._rng = np.random.default_rng(8)
        self._heard = 0.0

    @property
    def now(self) -> float:
        return self.device.imu.time / (1 + 1e-6 * PPM)

    def stamp(self, true_s: float) -> int:
        return BOOT_NS + round((true_s + JITTER_S * abs(self._rng.standard_normal())) * 1e9)


class Imu:
    def __init__(self, bench: Bench) -> None:
        self._bench = bench
        self.address = parse_device_url("serial:///dev/simulated?format=counts")

    def poll(self, timeout_s: float) -> list[Chunk | GapMark]:
        parts = self._bench.device.chunk(round(READ_S / 0.02))
        return [Chunk(self._bench.stamp(self._bench.now), part) for part in parts if isinstance(part, bytes)]


class Receiver:
    def __init__(self, bench: Bench) -> None:
        self._bench, self._heard = bench, 0.0
        self.address = parse_device_url("mavlink:udpin:127.0.0.1:14550")

    def poll(self, timeout_s: float) -> list[Chunk | GapMark]:
        chunks = list[Chunk | GapMark]()
        while self._heard < self._bench.now:
            self._heard += STEP_S
            if data := self._bench.autopilot.due(self._heard):
                chunks.append(Chunk(self._bench.stamp(self._heard), data))
        return chunks


def record(folder: Path, database: Path) -> None:
    """Record twelve dwells with UTC beside the rows."""
    bench = Bench()
    feed, gnss = open_feed(Imu(bench)), GnssFeed(Receiver(bench))
    unit = feed.identify()
    with open_db(database) as db:
        recorder = open_campaign(folder, unit, SITE, db)
        recorder.utc = gnss.utc

        def rest(until_s: float) -> None:
            while bench.device.imu.time < until_s:
                feed.advance()
                gnss.advance()

        for position in range(1, 13):
            bench.device.obey(f"place {position} 2")
            rest(bench.device.imu.time + 6.0)
            first = feed.tape.end
            rest(bench.device.imu.time + 10.0)
            recorder.accept(Dwell(position, 10.0), feed.tape, [(first, feed.tape.end - 10)])
            feed.tape.forget_before(feed.tape.end)
        recorder.finish()


def test_diagnose_finds_the_clock_of_a_campaign_recorded_beside_a_receiver(tmp_path: Path) -> None:
    (tmp_path / "c").mkdir()
    record(tmp_path / "c", tmp_path / "s.db")
    rows = [dwell.series.extra["utc_s"] for dwell in read_campaign(tmp_path / "c").campaign.dwells]
    assert all(np.isfinite(utc).sum() > 50 for utc in rows)
    assert cli.run(["diagnose", str(tmp_path / "c"), "--json", str(tmp_path / "d.json")]) == 0
    found = {one["effect"]: one for one in json.loads((tmp_path / "d.json").read_text())["findings"]}
    value = found["clock.rate"]["coefficients"]["value"]
    assert found["clock.rate"]["confidence"] == "established"
    assert abs(value["value"] - PPM) < 4 * value["std"]
    assert value["std"] < PPM / 10
