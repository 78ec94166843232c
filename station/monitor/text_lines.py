"""A monitor as lines: JSON for other programs, text for screen readers and logs; a line of input is a key."""

import json
import math
from collections.abc import Callable, Iterable, Sequence
from typing import Any

from station.attitude.live_readings import FilterReading, RestErrors, difference
from station.locate.location import Location
from station.monitor.view import LATE_S, MonitorSession, MonitorVerb, MonitorView
from station.stream.stream_events import NewEvents
from station.text import plural

MONITOR_FORMAT = "monitor/1"
READING_EVERY_S = 1.0  # of the device's time, between two lines of text
MONITOR_KEYS: dict[str, MonitorVerb] = {"m": "mark", "r": "record", "z": "zero", "n": "restart", "q": "leave"}
MONITOR_KEYS_HELP = (
    "keys, each followed by Enter: m mark, r start or stop recording, z zero on or off, n restart charts, q leave"
)


def json_line(view: MonitorView) -> str:
    """Return a reading as a line of `monitor/1`; what is not known is omitted, angles are absolute."""
    reading = view.reading
    assert reading is not None
    document: dict[str, Any] = {
        "format": MONITOR_FORMAT, "t_s": reading.t, "sample": reading.sample, "roll_deg": reading.roll,
        "pitch_deg": reading.pitch, "rate_deg_s": list(reading.rate),
        "gyro_bias_deg_h": list(reading.bias), "residual_deg": reading.residual, "mode": reading.mode,
        "aid": view.aid,
    }  # fmt: skip
    known = {
        "sigma_deg": None if math.isnan(reading.sigma) else reading.sigma, "heading_deg": reading.heading,
        "speed_m_s": reading.speed, "temperature_c": reading.temperature,
        "zero_deg": view.zero, "alarms": view.alarms or None,
    }  # fmt: skip
    document |= {name: value for name, value in known.items() if value is not None}
    if (rest := view.at_rest) is not None:
        sides = {"calibrated": _side(rest.calibrated), "nominal": _side(rest.nominal)}
        document["at_rest"] = {"seconds": rest.seconds, "earth": rest.earth, **sides}
    if view.filters:
        document |= _filters(view.filters)
    if view.location is not None:
        document["location"] = _location(view.location)
    return json.dumps(document)


def _filters(filters: Sequence[FilterReading]) -> dict[str, Any]:
    """Return what each filter reads, where it will settle, and how the second differs from the first, for JSON."""
    document: dict[str, Any] = {"laws": []}
    for reading in filters:
        one: dict[str, Any] = {
            "law": reading.name, "form": reading.form, "roll_deg": reading.roll, "pitch_deg": reading.pitch,
            "gyro_bias_deg_h": list(reading.bias),
        }  # fmt: skip
        if reading.settles is not None:
            settles = reading.settles._asdict().items()
            one["final_bias"] = {f"{name}_deg": value for name, value in settles if math.isfinite(value)}
        document["laws"].append(one | ({"note": reading.note} if reading.note else {}))
    if (apart := difference(filters)) is not None:
        document["difference"] = {f"{name}_deg": value for name, value in apart._asdict().items()}
    return document


def _location(location: Location) -> dict[str, Any]:
    """Return where it is, for JSON."""
    document: dict[str, Any] = {"state": "located" if location.is_located else "waiting", "fixes": location.fixes}
    if location.camera:
        document |= {"camera": location.camera, "images_dropped": location.images_dropped}
    if location.wheel:
        document["wheel"] = location.wheel
    if not location.is_located:
        return document | {"why": location.why}
    document |= {
        "t_s": location.t, "enu_m": list(location.enu), "enu_std_m": list(location.enu_std),
        "velocity_enu_m_s": list(location.velocity), "latitude_deg": location.latitude,
        "longitude_deg": location.longitude, "height_m": location.height, "outliers": location.outliers,
        "fix_age_s": location.fix_age,
    }  # fmt: skip
    known = {"heading_deg": location.heading, "heading_std_deg": location.heading_std}
    return document | {name: value for name, value in known.items() if value is not None}


def _side(side: RestErrors) -> dict[str, float]:
    values = {"level_deg": side.level, "drift_deg_h": side.drift, "g_error_mg": side.g}
    return {name: value for name, value in values.items() if math.isfinite(value)}


class PlainMonitor:
    """Writes what is new in each view through ``say``: a line a second, and every event once."""

    def __init__(self, say: Callable[[str], None], *, rings: bool = False) -> None:
        self._say, self._rings = say, rings
        self._next, self._last_head = -math.inf, ""
        self._new_events = NewEvents()

    def show(self, view: MonitorView) -> None:
        """Write what is new."""
        note = f"; warning: {view.in_use.note}" if view.in_use.note else ""
        head = f"{view.unit}, calibration {view.in_use.text}{note}"
        if view.unit and head != self._last_head:
            self._last_head = head
            self._say(head)
        for event in self._new_events.of(view.events):
            self._say(event.text + (chr(7) if self._rings and event.sound == "rejected" else ""))
        reading = view.reading
        if reading is None or view.shown is None:
            return
        if reading.t < self._next <= reading.t + 2 * READING_EVERY_S:
            return
        self._next = reading.t + READING_EVERY_S
        self._say(reading_line(view))


def reading_line(view: MonitorView) -> str:
    """Return a view's reading in a line of text."""
    reading, shown = view.reading, view.shown
    assert reading is not None
    assert shown is not None
    zeroed = " from zero" if view.zero else ""
    sigma = f"{reading.sigma:.3f}" if math.isfinite(reading.sigma) else "not known"
    line = (
        f"{reading.t:.1f} s: roll {shown[0]:.3f}, pitch {shown[1]:.3f} deg{zeroed}, u {sigma}, "
        f"{reading.mode}, residual {reading.residual:.3f} deg"
    )
    if view.filters:
        line += f"; {filters_line(view.filters)}"
    if view.at_rest is not None:
        calibrated, nominal = view.at_rest.calibrated, view.at_rest.nominal
        line += (
            f"; with and without calibration: level {calibrated.level:.3f}, {nominal.level:.3f} deg, "
            f"drift {calibrated.drift:.2f}, {nominal.drift:.2f} deg/h ({view.at_rest.earth})"
        )
    if view.location is not None:
        behind = f"; {view.behind:.0f} s behind" if view.behind > LATE_S else ""
        line += f"; {location_line(view.location)}{behind}"
    return line + "".join(f"; ALARM {alarm}" for alarm in view.alarms)


def filters_line(filters: Sequence[FilterReading]) -> str:
    """Return what each filter reads, how they differ, and where they will settle, as text."""
    line = ", ".join(f"{reading.name} roll {reading.roll:.3f}, pitch {reading.pitch:.3f}" for reading in filters)
    if (apart := difference(filters)) is not None:
        line += f", difference roll {apart.roll:+.3f}, pitch {apart.pitch:+.3f} deg"
    for reading in filters:
        line += f"; {settles_in_words(reading)}" if reading.settles is not None else ""
        line += f"; {reading.note}" if reading.note else ""
    return line


def settles_in_words(reading: FilterReading) -> str:
    """Return the bias of a filter at this bank, where it will settle: You and Lee (8)."""
    assert reading.settles is not None
    roll, pitch, roll_std, pitch_std = reading.settles
    within = [f" +- {std:.3f}" if math.isfinite(std) else "" for std in (roll_std, pitch_std)]
    return f"bias of {reading.name} at this bank: roll {roll:+.3f}{within[0]}, pitch {pitch:+.3f}{within[1]} deg"


def location_line(location: Location) -> str:
    """Return where it is, or what is missing, as text."""
    camera = f"; camera: {location.camera}" if location.camera else ""
    camera += f"; wheel: {location.wheel}" if location.wheel else ""
    if not location.is_located:
        return f"not located, {plural(location.fixes, 'fix')}: {location.why}{camera}"
    east, north, up = location.enu
    heading = "" if location.heading is None else f", heading {location.heading:.2f}"
    heading += "" if not heading or location.heading_std is None else f" +- {location.heading_std:.2f} deg"
    return (
        f"E {east:.2f}, N {north:.2f}, U {up:.2f} m +- {max(location.enu_std[:2]):.2f}{heading}, "
        f"{plural(location.fixes, 'fix')}, {plural(location.outliers, 'outlier')}{camera}"
    )


def listen(session: MonitorSession, lines: Iterable[str], say: Callable[[str], None]) -> None:
    """Turn lines of input into what they ask for until there are no more."""
    for line in lines:
        if (verb := MONITOR_KEYS.get(line.strip())) is not None:
            session.send(verb)
        else:
            say(MONITOR_KEYS_HELP)
