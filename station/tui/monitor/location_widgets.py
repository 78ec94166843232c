"""Where the unit is, on the monitor's screen: a map, and the numbers beside it."""

from textwrap import wrap

from textual.content import Content

from station.locate.location import Location
from station.monitor.view import LATE_S, MonitorView
from station.text import plural
from station.tui.monitor.map_picture import map_picture
from station.tui.widgets.redrawn_on_change import ValueWidget

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
            why = [line for part in (_beside(location), location.why) for line in wrap(part, width)][
                : READING_LINES - 1
            ]
            return Content("\n").join((head, *(Content(line) for line in why)))
        east, north, up = (f"{value:+.2f}" for value in location.enu)
        outliers, newest = plural(location.outliers, "outlier"), f"newest {location.fix_age:.1f} s"
        return Content("\n").join((
            Content.assemble("E ", (east, "bold $accent"), "  N ", (north, "bold $accent"), f"  U {up} m"),
            Content(_beside(location) or f"{location.latitude:.7f}, {location.longitude:.7f} deg"),
            Content.assemble("HEADING ", *_heading(location)),
            Content(_sigmas(location)),
            Content.assemble(
                (f"◎ {plural(location.fixes, 'fix')}", "bold $success"), "  ",
                (outliers, "bold $error" if location.outliers else ""), "  ",
                (f"{behind:.0f} s behind", "bold $warning") if behind > LATE_S else newest,
            ),
        ))  # fmt: skip


def _beside(location: Location) -> str:
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
