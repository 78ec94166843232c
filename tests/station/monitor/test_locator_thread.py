"""`station monitor --locate` as a program: a recorded drive, live with a thread, and what it refuses."""

import json
from dataclasses import replace
from pathlib import Path
from threading import Event

import numpy as np
import pytest

from drivers.camera import CameraImage
from drivers.simulated.companions.gnss_server import SimulatedGnss
from drivers.simulated.companions.truths import AutopilotTruth
from drivers.simulated.server import SimulatedDevice
from drivers.simulated.truth import Truth
from procedures.fusion.fusion_records import ImuSeries
from station import cli
from station.locate.location import Location
from station.locate.monitor_interface import LocatorTick
from station.monitor.locator_thread import FAR_BEHIND, LocatorThread
from tests.drivers.simulated.drives import bends
from tests.patience import paced
from tests.station.commands.program import Program
from tests.station.monitor.driving import DriveRig, record_drive, stands_on
from tests.station.monitor.unit import write_calibration

TRUTH = replace(Truth.example(5), latitude_deg=48.1, longitude_deg=11.5, height_m=520.0)
TRACK = bends(40.0, still=14.0)
AUTOPILOT = AutopilotTruth(position_std_m=0.3, default_hz=5.0)


def asked(tmp_path: Path) -> list[str]:
    return ["--calibration", str(write_calibration(tmp_path, TRUTH)), "--locate", "--lever-arm", "0,0,0"]


@pytest.mark.proof
def test_a_recorded_drive_is_located_the_same_each_time(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = record_drive(tmp_path / "r", TRUTH, TRACK, AUTOPILOT, 28.0)
    replay = ["monitor", f"replay:{file}", "--speed", "0", "--json", *asked(tmp_path)]
    assert cli.run(replay) == 0
    reported = capsys.readouterr().out
    last = json.loads(reported.splitlines()[-1])["location"]
    assert last["state"] == "located"
    assert stands_on(TRACK, last)
    assert cli.run(replay) == 0
    assert capsys.readouterr().out == reported
    (alone := tmp_path / "alone").mkdir()
    file.rename(alone / "recording.mcap")
    assert cli.run(["monitor", f"replay:{alone / 'recording.mcap'}", "--json", *asked(tmp_path)]) == 3
    assert "no gnss_*.mcap next to it" in capsys.readouterr().err


def test_a_thread_finds_what_is_found_without_it_and_says_why_it_stops() -> None:
    direct, given = DriveRig(TRUTH, TRACK, AUTOPILOT), list[object]()
    locator = direct.monitor._options.locating  # noqa: SLF001
    take = locator.take
    locator.take = lambda taken: (given.append(taken), take(taken))
    direct.run(26.0)
    other = DriveRig(TRUTH, TRACK, AUTOPILOT).monitor._options.locating  # noqa: SLF001
    thread = LocatorThread(other)
    for taken in given:
        thread.take(taken)
    while thread.location.t < direct.view.location.t:
        Event().wait(0.01)
    assert thread.location == direct.view.location
    thread.take("nothing of the kind")
    while thread.location.is_located:
        Event().wait(0.01)
    assert "locating has stopped: AttributeError" in thread.location.why
    thread.close()


def test_live_it_says_what_is_missing(tmp_path: Path) -> None:
    with SimulatedDevice(TRUTH, 5, speed=paced(10.0)) as imu, SimulatedGnss(TRUTH, AUTOPILOT, imu=imu) as gnss:
        given = ["--plain", "--gnss", gnss.url, "--folder", str(tmp_path / "r"), *asked(tmp_path)]
        with Program("monitor", imu.url, *given) as program:
            program.until("at rest the Earth's rate gives yaw to")
            program.press("q")
            code, _, error = program.end()
    assert (code, error) == (0, "")


class Slow:
    """A locator that takes nothing in before it is let go."""

    location = Location()

    def __init__(self) -> None:
        self.go, self.images, self.dropped = Event(), list[int](), 0

    def take(self, taken: LocatorTick) -> None:
        self.go.wait()
        self.images.append(len(taken.images))
        self.dropped += taken.images_dropped

    def reset(self) -> None:
        self.images.append(-1)


def test_a_thread_that_is_far_behind_goes_on_without_images() -> None:
    slow, none = Slow(), np.zeros((1, 3))
    thread = LocatorThread(slow)
    tick = LocatorTick(ImuSeries(np.zeros(1), none, none), (), (), (CameraImage(0, None, b""),))
    for _ in range(2 * FAR_BEHIND):
        thread.take(tick)
    thread.reset()
    slow.go.set()
    while -1 not in slow.images:
        Event().wait(0.01)
    thread.close()
    kept = sum(slow.images[:-1])
    assert FAR_BEHIND <= kept <= FAR_BEHIND + 1  # the one it held was none of those that wait
    assert slow.images[:kept] == [1] * kept
    assert len(slow.images) == 2 * FAR_BEHIND + 1
    assert slow.dropped == 2 * FAR_BEHIND - kept
