"""The simulated machine: clock, disk, port and the unit at it, put in the place of the real ones."""

import os
import sys
import time
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from contextlib import ExitStack, contextmanager
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, TextIO
from unittest.mock import patch

from drivers.errors import ControlRefused
from drivers.ports import wire_of
from drivers.simulated.bench_control import BenchControl
from station.stream.live.live_feed import LiveFeed
from tests.year.bench import STEP_S, Bench
from tests.year.clock import HostClock, host_clock
from tests.year.disk import Disk

LAZY = (  # what the station imports when it wants it: before the clocks are put in their places
    "station.guide.campaign.live_campaign", "station.guide.campaign.campaign_start",
    "station.guide.campaign.interrupted_campaigns",
    "station.guide.campaign.verdict", "station.guide.campaign.port_check", "station.guide.campaign.readiness",
    "station.stream.reader.reader", "station.stream.gnss_feed",
    "station.guide.campaign.port_check",
    "station.guide.stages.monitor_stage", "station.guide.campaign.folder_recorder", "station.device_probe",
    "station.results.campaign_results", "station.results.diagnosis.model_refinement",
    "station.results.solution_json", "station.results.user_defined_effects",
    "station.results.report.report", "station.results.diagnosis.diagnosis_html",
    "station.results.diagnosis.magnetic_field", "station.results.certificate.issuing", "station.demo.run",
    "station.results.fixtures.measured_cube", "fixtures_db.imu_models", "fixtures_db.issued_certificates",
    "fixtures_db.migrations.upgrade", "station.commands.verify", "station.demo.comparison", "station.tui.app",
)  # fmt: skip

if TYPE_CHECKING:
    from tests.year.receiver import Receiver

REAL_SLEEP = time.sleep
LEAP_UTC_S = 1483228800.0  # 2017-01-01


class Machine:
    """One machine with one port; ``pace_s`` is how much time goes by with each look at it."""

    def __init__(self, root: Path, utc_s: float) -> None:
        self.root, self.clock = root, HostClock(utc_s)
        self.disk = Disk(self.clock, root)
        self.pace_s = 0.5
        self.renders = True  # figures, by matplotlib; else what draws them runs, and nothing is laid out
        self.reader_dies = self._has_leapt = False
        self.bench: Bench
        self.receiver: Receiver | None = None
        self.log: list[str] = []
        self.others: dict[str, Machine] = {}  # next to this one, by the address of their port
        self._first: Machine | None = None

    def next_to(self, address: str) -> "Machine":
        """Return another machine in the same time, with a port of its own."""
        other = self.others[address] = Machine(self.root, 0.0)
        other.clock, other.disk, other.log, other._first = self.clock, self.disk, self.log, self
        other.pace_s = 0.25
        return other

    def of(self, address: object) -> "Machine":
        """Return the machine whose port has this address, text or `DeviceAddress`."""
        return self.others.get(str(getattr(address, "text", address)), self)

    def say(self, what: str) -> None:
        """Put a line into the log of events."""
        text = what.replace(str(self.root), "ROOT").replace("\n", " | ")
        self.log.append(f"{self.clock.now - 1000:9.2f} {text}")

    def sleep(self, seconds: float) -> None:
        """Let time go by."""
        if self._first is not None:
            self._first.sleep(seconds)
            return
        left = max(seconds, 1e-3)
        while left > 0:
            step = min(left, STEP_S)
            self.clock.now += step
            left -= step
            self._leap()
            for each in (self, *self.others.values()):
                each.bench.go_on()

    def waits(self, seconds: float) -> None:
        """Let the station wait, as by `time.sleep`; who waits for a real program does so in real time."""
        if sys._getframe(1).f_globals["__name__"] == "subprocess":  # noqa: SLF001
            REAL_SLEEP(seconds)
        else:
            self.sleep(seconds)

    def _leap(self) -> None:
        """Repeat the last second of 2016, as a machine without smearing does."""
        if not self._has_leapt and LEAP_UTC_S <= self.clock.wall < LEAP_UTC_S + 1:
            self._has_leapt = True
            self.clock.ahead -= 1.0
            self.say("a leap second")

    @contextmanager
    def running(self, zone: str) -> Iterator[None]:
        """Let the station see this machine, in a time zone, and nothing of the real one."""
        for name in LAZY:
            import_module(name)
        from tests.year.reader import InProcessReader, ProbePort
        from tests.year.receiver import InProcessReceiverReader

        places: dict[str, Any] = {
            "station.stream.live.live_feed.Reader": lambda url, path: InProcessReader(self.of(url), url, path),
            "station.stream.reader.reader.Reader": partial(InProcessReceiverReader, self),
            "station.device_probe.open_port": lambda address: ProbePort(self.of(address)),
            "station.guide.campaign.campaign_start.open_feed": self._feed,
            "station.guide.engine.ThreadPoolExecutor": InlineExecutor,
            "station.guide.start_screen.list_ports": list,
            "station.guide.engine.wait": lambda _: None,
        }
        if not self.renders:
            places["station.results.report.svg.FigureCanvasSVG"] = BlankCanvas
        config = {"STATION_CONFIG": str(self.root / "config"), "TZ": zone}
        with ExitStack() as stack:
            for name, value in places.items():
                stack.enter_context(patch(name, value))
            stack.enter_context(patch.dict(os.environ, config))
            time.tzset()
            stack.callback(time.tzset)
            stack.enter_context(host_clock(self.clock, self.waits))
            stack.enter_context(self.disk.mounted())
            yield
        time.tzset()

    def _feed(self, source: Any) -> LiveFeed:
        wire = wire_of(source.address)
        assert wire is not None
        return LiveFeed(source, wire, clock=lambda: self.clock.now)


class BlankCanvas:
    """Takes a figure that was drawn and writes an empty one: layout is a tenth of a campaign's time."""

    def __init__(self, _: object) -> None:
        pass

    def print_svg(self, stream: TextIO, **_: object) -> None:
        """Write it."""
        stream.write("<svg></svg>")


class InlineExecutor:
    """Does at once what would be done aside."""

    def __init__(self, *_: object) -> None:
        pass

    def submit(self, call: Callable[..., Any], *arguments: Any) -> "Future[Any]":
        """Do it; what it raises stands in the answer, but for a kill."""
        answer: Future[Any] = Future()
        try:
            answer.set_result(call(*arguments))
        except Exception as error:
            answer.set_exception(error)
        return answer

    def shutdown(self) -> None:
        """Nothing is under way."""


class InProcessHands(BenchControl):
    """The hands of the machine's bench."""

    def __init__(self, machine: Machine, address: str) -> None:
        super().__init__(address)
        self._machine = machine

    def seen(self, time_s: float) -> None:
        """Say nothing: this device goes as fast as it is read and waits for nobody."""

    def say(self, command: str) -> list[str]:
        """Do it; return the words after ``ok``."""
        if command.startswith("seen "):  # the bench goes by this clock: it never falls behind
            return []
        words = self._machine.bench.device.execute(command).split()
        if words[:1] != ["ok"]:
            raise ControlRefused(self.address, command, " ".join(words))
        self._machine.say(f"hands: {command}")
        return words[1:]
