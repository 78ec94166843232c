"""A simulated unit whose clock is off, next to a receiver: reported, refused, diagnosed; in virtual time."""

import itertools
import json
import re
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from drivers.address_parsing import parse_device_url
from drivers.simulated.companions.gnss_server import Autopilot, SimulatedGnss
from drivers.simulated.companions.truths import AutopilotTruth
from drivers.simulated.device import ByteDevice
from drivers.simulated.faults import Fault
from drivers.simulated.server import SimulatedDevice
from drivers.simulated.truth import Truth
from fixtures_db.database import open_db
from procedures.campaign.plan_steps import Dwell
from procedures.errors import ErrorCode
from station import cli
from station.errors import DataRefused
from station.files.campaign_folder.campaign_reading import read_campaign
from station.guide.campaign.port_check import SampleRateWatch
from station.stream.gnss_feed import GnssFeed
from station.stream.live.live_feed import open_feed
from station.stream.reader import Chunk, StreamGap
from station.stream.recorder.accepted_step_writer import open_campaign
from station.stream.stream_events import EventLog
from tests.patience import paced
from tests.refusals import refused
from tests.station.commands.program import Program
from tests.station.stream.live.bench_in_memory import SITE

SMALL, WARNED, REFUSED, SYNC_LINE = 150.0, 1500.0, 15_000.0, 39_000.0  # ppm; the last as of a real unit
BOOT_NS = 10**18  # of the station's clock at true time 0
READ_S = 0.1  # the IMU's bytes come in pieces as long
STEP_S = 0.004  # the autopilot's as they are written
JITTER_S = 3e-3  # of a read


class Bench:
    """Both devices on one true time; each source is polled by its feed."""

    def __init__(self, ppm: float, faults: Iterable[Fault] = ()) -> None:
        truth = replace(Truth.example(5), effects={"clock.rate": {"value": ppm}})
        self._ppm = ppm
        self.device = ByteDevice(truth, 5, "counts", faults)
        self.autopilot = Autopilot(truth, AutopilotTruth(default_hz=5.0))
        self._rng = np.random.default_rng(8)
        self._heard = 0.0

    @property
    def now(self) -> float:
        return self.device.imu.time / (1 + 1e-6 * self._ppm)

    def stamp(self, true_s: float) -> int:
        return BOOT_NS + round((true_s + JITTER_S * abs(self._rng.standard_normal())) * 1e9)


class Imu:
    def __init__(self, bench: Bench) -> None:
        self._bench = bench
        self.address = parse_device_url("serial:///dev/simulated?format=counts")

    def poll(self, timeout_s: float) -> list[Chunk | StreamGap]:
        parts = self._bench.device.chunk(round(READ_S / 0.02))
        return [Chunk(self._bench.stamp(self._bench.now), part) for part in parts if isinstance(part, bytes)]


class Receiver:
    def __init__(self, bench: Bench) -> None:
        self._bench, self._heard = bench, 0.0
        self.address = parse_device_url("mavlink:udpin:127.0.0.1:14550")

    def poll(self, timeout_s: float) -> list[Chunk | StreamGap]:
        chunks, autopilot = list[Chunk | StreamGap](), self._bench.autopilot
        while self._heard < self._bench.now:
            self._heard += STEP_S
            sends = self._heard >= min(autopilot._next.values())  # noqa: SLF001 - most steps have nothing due
            if sends and (data := autopilot.due(self._heard)):
                chunks.append(Chunk(self._bench.stamp(self._heard), data))
        return chunks


def record(folder: Path, database: Path, ppm: float, positions: Iterable[int]) -> None:
    """Record dwells with UTC next to the rows."""
    folder.mkdir()
    bench = Bench(ppm)
    feed, gnss = open_feed(Imu(bench)), GnssFeed(Receiver(bench))
    unit = feed.identify()
    with open_db(database) as db:
        recorder = open_campaign(folder, unit, SITE, db)
        recorder.utc = gnss.utc

        def rest(until_s: float) -> None:
            while bench.device.imu.time < until_s:
                feed.advance()
                gnss.advance()

        for position in positions:
            bench.device.execute(f"place {position} 2")
            rest(bench.device.imu.time + 6.0)
            first = feed.buffer.end
            rest(bench.device.imu.time + 10.0)
            recorder.accept(Dwell(position, 10.0), feed.buffer, [(first, feed.buffer.end - 10)])
            feed.buffer.forget_before(feed.buffer.end)
        recorder.finish()


@pytest.mark.proof
def test_diagnose_finds_the_clock_of_a_campaign_recorded_with_a_receiver(tmp_path: Path) -> None:
    record(tmp_path / "c", tmp_path / "s.db", SMALL, range(1, 13))
    rows = [dwell.series.extra["utc_s"] for dwell in read_campaign(tmp_path / "c").campaign.dwells]
    assert all(np.isfinite(utc).sum() > 50 for utc in rows)
    assert cli.run(["diagnose", str(tmp_path / "c"), "--json", str(tmp_path / "d.json")]) == 0
    found = {one["effect"]: one for one in json.loads((tmp_path / "d.json").read_text())["findings"]}
    value = found["clock.rate"]["coefficients"]["value"]
    assert found["clock.rate"]["confidence"] == "established"
    assert abs(value["value"] - SMALL) < 4 * value["std"]
    assert value["std"] < SMALL / 10


def with_receiver(
    ppm: float, seconds: float, faults: tuple[Fault, ...] = (), *, has_gnss: bool = True
) -> list[str]:
    """Return what a campaign's receiver, or its machine's clock, has it say within so many device seconds."""
    bench, event_log = Bench(ppm, faults), EventLog()
    feed, gnss = open_feed(Imu(bench)), GnssFeed(Receiver(bench))
    watch = SampleRateWatch(feed, event_log, gnss if has_gnss else None)
    looks = itertools.count(0.0, READ_S)
    watch._rate.clock = lambda: float(next(looks))  # noqa: SLF001
    feed.identify()
    while bench.device.imu.time < seconds:
        feed.advance()
        watch.round()
    return [event.text for event in event_log.events]


def test_a_running_campaign_names_the_clock_once_and_ends_where_it_is_worse() -> None:
    assert with_receiver(SMALL, 60.0) == []
    [reported] = with_receiver(WARNED, 90.0)
    assert re.search(r"clock.rate.* 0.0199\d+ s, -0.1[0-9]% off", reported)
    with refused(DataRefused, ErrorCode.SAMPLE_RATE):
        with_receiver(REFUSED, 90.0)


def test_without_a_receiver_the_machines_clock_determines_a_thousandth_and_leaves_another_pace_alone() -> None:
    [reported] = with_receiver(WARNED, 60.0, has_gnss=False)
    assert re.search(r"clock.rate.* 0.0199\d+ s, -0.1[0-9]% off", reported)
    with refused(DataRefused, ErrorCode.SAMPLE_RATE):
        with_receiver(REFUSED, 60.0, has_gnss=False)
    assert with_receiver(1e7, 40.0, has_gnss=False) == []  # eleven times as fast


@pytest.mark.proof
def test_the_program_ends_with_3_when_gnss_time_says_that_the_rate_is_wrong(tmp_path: Path) -> None:
    truth = replace(Truth.example(5), effects={"clock.rate": {"value": SYNC_LINE}})
    with SimulatedDevice(truth, 5, speed=paced(60.0)) as device, SimulatedGnss(truth, imu=device) as gnss:
        devices = ("--device", device.url, "--hands", device.control, "--gnss", gnss.url, "--move-s", "5")
        where = ("--out", str(tmp_path / "c"), "--db", str(tmp_path / "s.db"))
        with Program("calibrate", "--headless", *devices, *where) as program:
            code, _, error = program.end()
    assert (code, error.count("\n")) == (3, 1)
    assert "clock.rate: by reference time a sample lasts" in error
    assert (tmp_path / "c" / "campaign.toml").exists()  # what was accepted is evidence
