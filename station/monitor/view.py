"""What a monitor shows: one frozen value with all that a screen, a line of text or a test needs; alarms.

Angles in deg, rates in deg/s, body axes forward-right-down; times in s of the device unless a name says otherwise.
An alarm ``roll=10`` rings where roll is beyond 10 deg either way.
"""

import math
from dataclasses import dataclass, field
from typing import Literal, NamedTuple, Protocol

from station.attitude.live_readings import AttitudeReading, FilterReading, RestErrorComparison
from station.calibrated import InUse
from station.locate.location import Location
from station.stream.stream_events import Event, StreamState

LATE_S = 2.0  # by which a location may be older than the attitude

MonitorVerb = Literal[
    "mark",  # this moment, with a number
    "record",  # begin a recording, or end it
    "zero",  # show angles from here; again: absolute ones
    "restart",  # of the comparison at rest, and of the charts
    "leave",
]


class ChartPoint(NamedTuple):
    """A tenth of a second for the strip charts; what is not known is nan. ``aid`` [m/s]."""

    t: float
    roll: float
    pitch: float
    p: float
    q: float
    r: float
    aid: float
    residual: float
    sigma: float
    apart: float = math.nan  # angle between the verticals of two filters [deg]


@dataclass(frozen=True, slots=True)
class MonitorView:
    """All of it. ``zero`` (roll, pitch) is subtracted from what is shown, and from nothing else."""

    unit: str = ""
    aid: str = "none"
    line: str = "waiting for the first samples"
    reading: AttitudeReading | None = None
    history: tuple[ChartPoint, ...] = ()
    at_rest: RestErrorComparison | None = None
    filters: tuple[FilterReading, ...] = ()  # empty where the joint filter runs alone
    streams: tuple[StreamState, ...] = ()
    in_use: InUse = field(default_factory=InUse)
    location: Location | None = None  # None: not asked for
    zero: tuple[float, float] | None = None
    alarms: tuple[str, ...] = ()
    recording: str = ""  # the file, empty while nothing is recorded
    folder: str = ""
    events: tuple[Event, ...] = ()
    is_over: bool = False

    @property
    def trouble(self) -> str:
        """What is wrong with the first stream that is not well."""
        return next((stream.trouble for stream in self.streams if stream.trouble), "")

    @property
    def behind(self) -> float:
        """By how much the location is older than the attitude [s]: where the machine is too slow for it."""
        location, reading = self.location, self.reading
        return reading.t - location.t if reading and location and location.is_located else 0.0

    @property
    def shown(self) -> tuple[float, float] | None:
        """Roll and pitch as they are shown: less the zero."""
        if self.reading is None:
            return None
        roll, pitch = self.zero or (0.0, 0.0)
        return (self.reading.roll - roll + 180.0) % 360.0 - 180.0, self.reading.pitch - pitch


class MonitorSession(Protocol):
    """An engine as its screens see it; both return at once."""

    @property
    def view(self) -> MonitorView:
        """The newest view."""
        ...

    def send(self, verb: MonitorVerb) -> None:
        """Ask something of the engine."""
        ...
