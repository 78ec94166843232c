"""A monitor on a simulated device polled in memory, in device time: no process, no port, no waiting."""

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

from drivers.simulated.faults import Fault
from drivers.simulated.truth import Truth
from station.calibrated import InUse
from station.calibrated.calibration_choice import AppliedCalibration
from station.monitor.monitor import Monitor, MonitorOptions
from station.monitor.recording import MonitorRecording
from station.monitor.view import MonitorVerb, MonitorView
from station.stream.live.live_feed import open_feed
from tests.station.monitor.unit import calibration_of
from tests.station.stream.live.bench_in_memory import Source


class MonitorRig:
    """``hands`` moves the cube; `run` lets device time pass. ``lines`` are the views that a sink was told."""

    def __init__(
        self, truth: Truth | None = None, options: MonitorOptions | None = None, folder: Path | None = None, *,
        position: int = 9, faults: Iterable[Fault] = (), calibration: dict[str, Any] | None = None,
    ) -> None:  # fmt: skip
        self.truth = Truth.example(5) if truth is None else truth
        self.source = Source(self.truth, faults)
        self.hands(f"place {position} 1")
        self.feed = open_feed(self.source)
        self.feed.identify()
        recording = None if folder is None else MonitorRecording(folder, self.feed.wire)
        self.lines: list[MonitorView] = []
        applied = AppliedCalibration(calibration or calibration_of(self.truth), None, InUse("by hand"))
        self.monitor = Monitor(
            self.feed, applied, options or MonitorOptions(), recording, None, (self.lines.append,)
        )

    def hands(self, command: str) -> None:
        answer = self.source.device.execute(command)
        assert answer.startswith("ok"), answer

    def execute(self, verb: MonitorVerb) -> None:
        self.monitor.execute(verb)

    @property
    def view(self) -> MonitorView:
        return self.monitor.view

    @property
    def texts(self) -> list[str]:
        return [event.text for event in self.view.events]

    def run(self, seconds: float, until: Callable[[MonitorView], bool] = lambda view: False) -> MonitorView:
        """Let device time pass, at most until a view shows what is waited for."""
        end = self.source.device.imu.time + seconds
        while self.source.device.imu.time < end and not until(self.view):
            self.monitor.round()
        return self.view
