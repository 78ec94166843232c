"""Alarms of the monitor: what is held against a limit, and when an alarm begins and ends."""

from collections.abc import Callable
from dataclasses import dataclass

from station.attitude.live_readings import AttitudeReading

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
