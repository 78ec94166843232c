"""The parts of the monitor's screen; each draws one value."""

import math
from collections.abc import Sequence
from textwrap import wrap

from textual.content import Content

from procedures.attitude.filter_choice import JOINT
from station.attitude.live_readings import FilterReading, MotionState, RestErrorComparison, difference
from station.calibrated import InUse
from station.locate.location import Location
from station.monitor.view import LATE_S, ChartPoint, MonitorView
from station.stream.stream_events import StreamState
from station.text import plural
from station.tui.monitor_pictures import horizon_picture, map_picture
from station.tui.widgets.common import Canvas, ValueWidget

CHART_POINTS = 600  # points in a chart: a minute
MOTION_LOOKS: dict[MotionState, tuple[str, str]] = {
    "waiting": ("…", "$muted"),
    "aligning": ("…", "$warning"),
    "at rest": ("◼", "$success"),
    "moving": ("↻", "$primary"),
}
STEEP_PITCH_DEG = 89.0  # deg of pitch, beyond which roll and heading are one
LABEL_COLUMNS = 13
FILTER_LINES, FILTER_COLUMNS = 2, 44  # that are left for notes on filters


class StateLine(ValueWidget[tuple[str, str, str]]):
    """A chip and a sentence: what is wrong, else whether it is recorded."""

    DEFAULT_CSS = "StateLine { height: 1; background: $surface; }"

    def _drawn(self, value: tuple[str, str, str]) -> Content:
        chip, colour, text = value
        return Content.assemble((f" {chip} ", f"bold $background on {colour}"), f"  {text}")


class Horizon(ValueWidget[tuple[float, float]]):
    """Roll and pitch as a picture."""

    DEFAULT_CSS = "Horizon { width: 34; height: 100%; }"

    def _drawn(self, value: tuple[float, float]) -> Content:
        return horizon_picture(self.size.width, self.size.height, *value)


class Readings(ValueWidget[MonitorView]):
    """The numbers: attitude, sigma, rates, bias, residual."""

    DEFAULT_CSS = "Readings { height: 6; padding-left: 1; }"

    def _drawn(self, view: MonitorView) -> Content:
        reading, shown = view.reading, view.shown
        if reading is None or shown is None:
            return Content.styled("no attitude yet", "$muted")
        symbol, colour = MOTION_LOOKS[reading.mode]
        zero = [f"  from zero {value:+.3f}" for value in view.zero] if view.zero else ["", ""]
        steep = "  undefined at ±90°" if abs(reading.pitch) > STEEP_PITCH_DEG else ""
        p, q, r = (_short(rate, 3) for rate in reading.rate)
        x, y, z = (_short(bias, 2) for bias in reading.bias)
        heading = ""
        if reading.heading is not None and view.location is None:  # else it stands with the position
            heading = f"  HDG {reading.heading % 360:.1f}"
        sigma = f"u {reading.sigma:14.3f} deg   "
        if math.isnan(reading.sigma):  # a complementary filter has none
            sigma = f"by {view.filters[0].name:21}"
        warm = "" if reading.temperature is None else f"   {reading.temperature:.1f} degC"
        return Content("\n").join((
            Content.assemble("ROLL   ", (f"{shown[0]:+9.3f} deg", "bold $accent"), (zero[0] + steep, "$warning")),
            Content.assemble("PITCH  ", (f"{shown[1]:+9.3f} deg", "bold $accent"), (zero[1], "$warning")),
            Content.assemble(sigma, (f"{symbol} {reading.mode:7}", f"bold {colour}"), heading),
            Content.assemble("RATE  ", f"p {p}  q {q}  r {r} deg/s"),
            Content.assemble("BIAS  ", f"x {x}  y {y}  z {z} deg/h"),
            Content.assemble(f"RESIDUAL {reading.residual:7.3f} deg{warm}"),
        ))  # fmt: skip


def _short(value: float, digits: int) -> str:
    """Return a number with its sign in 7 characters."""
    return f"{value:+.{max(digits - (abs(value) >= 10) - (abs(value) >= 100) - (abs(value) >= 1000), 0)}f}"


class RestComparison(ValueWidget[RestErrorComparison]):
    """The errors at rest with and without the calibration, side by side."""

    DEFAULT_CSS = "RestComparison { height: 5; padding-left: 1; }"

    def render(self) -> Content:
        errors = self.value
        if errors is None:
            return Content("\n").join((
                Content.styled("ON LEVEL PLATE   calibrated    nominal", "bold"),
                Content.styled("shown after 2 s at rest", "$muted"),
            ))  # fmt: skip
        rows = [
            _row(name, getattr(errors.calibrated, name), getattr(errors.nominal, name), unit)
            for name, unit in (("level", "deg"), ("drift", "deg/h"), ("g", "mg"))
        ]
        head = f"AT REST {errors.seconds:.0f} s".ljust(17) + "calibrated    nominal"
        return Content("\n").join((Content.styled(head, "bold"), *rows, Content.styled(errors.earth, "$muted")))


class FilterTable(ValueWidget[tuple[FilterReading, ...]]):
    """Two filters side by side and how they differ, and the bias that a complementary filter will have."""

    DEFAULT_CSS = "FilterTable { height: 5; padding-left: 1; }"

    def _drawn(self, filters: tuple[FilterReading, ...]) -> Content:
        apart = difference(filters)
        head = "FILTER" + "".join(f"{one.name:>13}" for one in filters) + ("" if apart is None else "  difference")
        lines = [Content.styled(head, "bold")]
        for name in ("roll", "pitch"):
            each = [(f"{getattr(reading, name):+13.3f}", "bold $accent") for reading in filters]
            last = " deg" if apart is None else f"{getattr(apart, name):+8.3f} deg"
            lines.append(Content.assemble(f"{name:6}", *each, last))
        mixing = [reading for reading in filters if reading.name != JOINT]
        lines += [line for reading in mixing for line in _settles(reading, FILTER_LINES // len(mixing))]
        return Content("\n").join(lines)


def _settles(reading: FilterReading, lines: int) -> list[Content]:
    """Return the bias of a filter at this bank, or what is against the filter, in one line or two."""
    if reading.note:
        return [Content.styled(line, "$warning") for line in wrap(reading.note, FILTER_COLUMNS)[:lines]]
    if reading.settles is None:
        return [Content.styled(f"bias of {reading.name}: needs a velocity", "$muted")]
    roll, pitch, roll_std, pitch_std = reading.settles
    if lines == 1:
        return [Content.assemble(f"bias of {reading.name:13}", (f"{roll:+.3f} {pitch:+.3f}", "$warning"), " deg")]
    stds = ["" if math.isnan(std) else f" \u00b1 {std:.3f}" for std in (roll_std, pitch_std)]
    values = Content.assemble(
        "roll ", (f"{roll:+.3f}", "$warning"), f"{stds[0]}  pitch ", (f"{pitch:+.3f}", "$warning"), stds[1]
    )
    return [Content.styled(f"bias of {reading.name} at this bank, deg", "$muted"), values]


def _row(name: str, calibrated: float, nominal: float, unit: str) -> Content:
    numbers = ["-" if value != value else f"{value:.3f}" for value in (calibrated, nominal)]
    return Content.assemble(
        f"{name + ' error' if name != 'drift' else name:15}", (f"{numbers[0]:>12}", "bold $success"),
        (f"{numbers[1]:>11}", "$warning"), f" {unit}",
    )  # fmt: skip


class StripChart(ValueWidget[tuple[ChartPoint, ...]]):
    """A minute of one or more quantities; ``least`` is the narrowest range that is drawn."""

    DEFAULT_CSS = "StripChart { height: 2; width: 1fr; }"

    def __init__(self, name: str, unit: str, least: float, **series: str) -> None:
        super().__init__(id=name.lower())
        self._label, self._unit, self._least, self._series = name, unit, least, series

    def _drawn(self, points: tuple[ChartPoint, ...]) -> Content:
        width, height = self.size.width - LABEL_COLUMNS, self.size.height
        columns = {name: [getattr(point, name) for point in points] for name in self._series}
        found = drawn_range([value for column in columns.values() for value in column], self._least)
        canvas = Canvas(self.size.width, height)
        canvas.put(0, 1, self._label, "bold")
        if found is None or width < 2:
            canvas.put(0, LABEL_COLUMNS, "none", "$muted")
            return canvas.content()
        low, high = found
        canvas.put(0, 1 + len(self._label) + 1, self._unit, "$muted")
        canvas.put(height - 1, 1, _range(low, high), "$muted")
        lines = canvas.window(0, LABEL_COLUMNS, width, height)
        for name, colour in self._series.items():
            for dot in line_dots(columns[name], 2 * width, 4 * height, low, high, CHART_POINTS):
                lines.dot(*dot, colour)
        return canvas.content()


def line_dots(
    values: Sequence[float], width: int, height: int, low: float, high: float, span: int
) -> list[tuple[int, int]]:
    """Return row and column of the dots of the last ``span`` values between ``low`` and ``high``; nan is left out.

    ``width`` and ``height`` are in dots. A column goes from the least to the greatest of its share of the values,
    so that no peak is lost.
    """
    shown = list(values)[-span:]
    shares: dict[int, list[float]] = {}
    for i, value in enumerate(shown, span - len(shown)):
        if math.isfinite(value):
            shares.setdefault(i * width // span, []).append(value)
    return [
        (row, column)
        for column, share in shares.items()
        for row in range(_dot_row(max(share), low, high, height), _dot_row(min(share), low, high, height) + 1)
    ]


def drawn_range(values: Sequence[float], least: float) -> tuple[float, float] | None:
    """Return the range to draw, at least ``least`` wide; None where nothing is known."""
    known = [value for value in values if math.isfinite(value)]
    if not known:
        return None
    low, high = min(known), max(known)
    more = max(least - (high - low), 0.0) / 2
    return low - more, high + more


def _dot_row(value: float, low: float, high: float, rows: int) -> int:
    share = (high - value) / (high - low) if high > low else 0.5
    return min(max(math.floor(share * rows), 0), rows - 1)


def _range(low: float, high: float) -> str:
    """Return a range in at most 12 characters."""
    size = max(abs(low), abs(high))
    digits = 0 if size >= 100 else 1 if size >= 10 else 2 if high - low >= 0.01 else 3
    return f"{low:.{digits}f}..{high:.{digits}f}"[: LABEL_COLUMNS - 1]


class Streams(ValueWidget[tuple[StreamState, ...]]):
    """A line for each stream: rate, age, gaps, errors."""

    DEFAULT_CSS = "Streams { height: auto; min-height: 1; padding: 0 1; background: $panel; }"

    def _drawn(self, streams: tuple[StreamState, ...]) -> Content:
        return Content("\n").join([_stream(stream) for stream in streams] or [Content("no stream yet")])


def _stream(stream: StreamState) -> Content:
    is_well = not stream.trouble
    word = ("✓", "bold $success") if is_well else ("✗", "bold $error")
    faults = {"gaps": stream.gaps, "lost": stream.lost, "bad check": stream.bad, "unhealthy": stream.unhealthy}
    text = ", ".join(f"{count} {name}" for name, count in faults.items() if count) or "no errors"
    return Content.assemble(word, f" {stream.name}  {stream.rate_hz:.1f} Hz  age {stream.age_s:.1f} s  {text}")


class CalibrationLine(ValueWidget[InUse]):
    """The calibration in use and its age."""

    DEFAULT_CSS = """
    CalibrationLine { height: 1; padding: 0 1; background: $panel; }
    CalibrationLine.noted { color: $warning; }
    """

    def _drawn(self, in_use: InUse) -> Content:
        note = f"; {in_use.note}" if in_use.note else ""
        return Content.assemble(("calibration ", "bold"), in_use.text + note)


READING_LINES = 5


class TrackMap(ValueWidget[Location]):
    """The way gone, north up."""

    DEFAULT_CSS = "TrackMap { width: 34; height: 100%; background: $surface; }"

    def _drawn(self, value: Location) -> Content:
        return map_picture(self.size.width, self.size.height, value)


class LocationReadings(ValueWidget[MonitorView]):
    """Position and heading with their sigmas and the fixes' health; before that, what is missing."""

    DEFAULT_CSS = "LocationReadings { height: 5; padding-left: 1; }"

    def _drawn(self, view: MonitorView) -> Content:
        location, behind = view.location or Location(), view.behind
        if not location.is_located:
            head = Content.assemble(("… NOT LOCATED", "bold $warning"), f"   {plural(location.fixes, 'fix')}")
            width = max(self.content_size.width - 1, 20)
            why = [line for part in (_camera_and_wheel(location), location.why) for line in wrap(part, width)]
            return Content("\n").join((head, *map(Content, why[: READING_LINES - 1])))
        east, north, up = (f"{value:+.2f}" for value in location.enu)
        outliers, newest = plural(location.outliers, "outlier"), f"newest {location.fix_age:.1f} s"
        return Content("\n").join((
            Content.assemble("E ", (east, "bold $accent"), "  N ", (north, "bold $accent"), f"  U {up} m"),
            Content(_camera_and_wheel(location) or f"{location.latitude:.7f}, {location.longitude:.7f} deg"),
            Content.assemble("HEADING ", *_heading(location)),
            Content(_sigmas(location)),
            Content.assemble(
                (f"◎ {plural(location.fixes, 'fix')}", "bold $success"), "  ",
                (outliers, "bold $error" if location.outliers else ""), "  ",
                (f"{behind:.0f} s behind", "bold $warning") if behind > LATE_S else newest,
            ),
        ))  # fmt: skip


def _camera_and_wheel(location: Location) -> str:
    """Return how camera and wheel do, in a line; empty where there is neither."""
    wheel = location.wheel and f"wheel: {location.wheel}"
    return "; ".join(part for part in (location.camera, wheel) if part)


def _heading(location: Location) -> tuple[Content | tuple[str, str], ...]:
    if location.heading is None:
        return (Content("none: forward is vertical"),)
    std = "" if location.heading_std is None else f"  u {location.heading_std:.2f} deg"
    return (f"{location.heading:.2f} deg", "bold $accent"), Content(std)


def _sigmas(location: Location) -> str:
    level, up = max(location.enu_std[:2]), location.enu_std[2]
    speed = sum(part**2 for part in location.velocity) ** 0.5
    return f"u {level:.2f} m, up {up:.2f} m   {speed:.1f} m/s"
