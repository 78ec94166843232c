"""What a monitor shows: one frozen value with all that a screen, a line of text or a test needs; alarms.

Angles in deg, rates in deg/s, body axes forward-right-down; times in s of the device unless a name says otherwise.
An alarm ``roll=10`` rings where roll is beyond 10 deg either way.
"""

import math
from collections.abc import Callable
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

    def send(self, verb: MonitorVerb) -> None:
        """Ask something of the engine."""


ALARM_RELEASE_SHARE = 0.95  # of the limit: where an alarm ends
ALARMS: dict[str, tuple[str, Callable[[AttitudeReading], float]]] = {  # unit, and what is held against the limit
    "roll": ("deg", lambda reading: abs(reading.roll)),
    "pitch": ("deg", lambda reading: abs(reading.pitch)),
    "rate": ("deg/s", lambda reading: max(abs(rate) for rate in reading.rate)),
    "sigma": ("deg", lambda reading: reading.sigma),
    "residual": ("deg", lambda reading: reading.residual),
    "temperature": ("degC", lambda reading: float("-inf") if reading.temperature is None else reading.temperature),
}


@dataclass(frozen=True, slots=True)
class Alarm:
    """One limit."""

    name: str
    limit: float

    def text(self, reading: AttitudeReading) -> str:
        """Return the alarm as text."""
        unit, size = ALARMS[self.name]
        return f"{self.name} {size(reading):.3g}, limit {self.limit:g} {unit}"


def parse_alarm(text: str) -> Alarm:
    """Read ``NAME=LIMIT``; raise ValueError where it is none."""
    name, _, limit = text.partition("=")
    try:
        value = float(limit)
    except ValueError:
        value = float("nan")
    if name not in ALARMS or not 0 < value < float("inf"):
        names = ", ".join(f"{name} [{unit}]" for name, (unit, _) in ALARMS.items())
        raise ValueError(f"found {text!r}, expected NAME=LIMIT with a limit above 0, NAME one of {names}")
    return Alarm(name, value)


class AlarmWatch:
    """Holds readings against limits; ``on`` are the alarms that ring."""

    def __init__(self, alarms: tuple[Alarm, ...]) -> None:
        self._alarms = alarms
        self.on: dict[Alarm, str] = {}

    def look(self, reading: AttitudeReading) -> tuple[list[str], list[str]]:
        """Return what begins to ring and what ends, as text."""
        begun, ended = list[str](), list[str]()
        for alarm in self._alarms:
            size = ALARMS[alarm.name][1](reading)
            if size > alarm.limit or (alarm in self.on and size > ALARM_RELEASE_SHARE * alarm.limit):
                if alarm not in self.on:
                    begun.append(alarm.text(reading))
                self.on[alarm] = alarm.text(reading)
            elif alarm in self.on:
                del self.on[alarm]
                ended.append(f"{alarm.name} within {alarm.limit:g} {ALARMS[alarm.name][0]} again")
        return begun, ended
