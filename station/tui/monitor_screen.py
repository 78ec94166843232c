"""The monitor: horizon and numbers above, a minute of charts below, the streams' health at the bottom."""

from collections.abc import Callable

from textual.app import ComposeResult
from textual.binding import Binding
from textual.containers import Grid, Horizontal, Vertical
from textual.screen import Screen

from station.monitor.view import MonitorSession, MonitorVerb, MonitorView
from station.tui.app import CommonApp
from station.tui.monitor_widgets import (
    CalibrationLine,
    FilterTable,
    Horizon,
    LocationReadings,
    Readings,
    RestComparison,
    StateLine,
    Streams,
    StripChart,
    TrackMap,
)
from station.tui.screens.modals import ConfirmScreen, HelpScreen, keys_of
from station.tui.widgets.common import EventLines, KeyLine, TitleBar

MONITOR_HELP = (
    "Roll and pitch of forward-right-down axes. The residual is the angle between the vertical of the "
    "accelerometers and that of the attitude. At rest on a surface plate the table shows errors of level, drift "
    "and g, with the calibration and without it. The zero affects only the display: recordings, JSON and MAVLink "
    "keep absolute angles."
)
HELP_LOCATED = (
    "The position is East, North and Up of the first fix, which is + on the map; ✗ is an outlier fix, which gets "
    "a low weight. Heading is that of forward, from true north. The residual is the angle between the vertical of "
    "the accelerometers and that of the attitude. The zero affects only the display."
)
MANY_STREAMS = 2  # streams that leave room for all charts on a short screen
END_TEXT = "The recording is complete and stays in its folder."


class MonitorScreen(Screen[None]):
    """Made with a way to send verbs, then shown views."""

    BINDINGS = [
        Binding("m", "send('mark')", "Mark", tooltip="mark this moment with a number in events.csv"),
        Binding("r", "send('record')", "Record", tooltip="start or stop a recording"),
        Binding("z", "send('zero')", "Zero", tooltip="show angles relative to now, or absolute"),
        Binding("n", "send('restart')", "Restart", tooltip="restart charts and the comparison at rest"),
        Binding("l", "map", "Map", tooltip="show the map or the horizon"),
        Binding("q", "leave", "Leave", tooltip="end the monitor"),
        Binding("question_mark", "help", "Help", key_display="?", tooltip="help for this screen, and all keys"),
    ]
    DEFAULT_CSS = """
    MonitorScreen #upper { height: 11; }
    MonitorScreen #charts { grid-size: 2 3; grid-rows: 2; height: 6; grid-gutter: 0 1; }
    MonitorScreen EventLines { min-height: 1; }
    MonitorScreen.-wide Horizon, MonitorScreen.-wide TrackMap { width: 58; }
    MonitorScreen TrackMap, MonitorScreen LocationReadings { display: none; }
    MonitorScreen.-map LocationReadings, MonitorScreen.-map.-placed TrackMap { display: block; }
    MonitorScreen FilterTable, MonitorScreen #apart { display: none; }
    MonitorScreen.-filters FilterTable, MonitorScreen.-filters.-two #apart { display: block; }
    MonitorScreen.-filters RestComparison, MonitorScreen.-filters.-two #sigma { display: none; }
    MonitorScreen.-map RestComparison, MonitorScreen.-map.-placed Horizon { display: none; }
    MonitorScreen.-map FilterTable { display: none; }
    MonitorScreen.-short.-crowded #charts { grid-size: 2 2; height: 4; }
    MonitorScreen.-short.-crowded #aid, MonitorScreen.-short.-crowded #sigma { display: none; }
    MonitorScreen.-short.-crowded.-two #apart { display: none; }
    MonitorScreen.-tall #upper { height: 16; }
    MonitorScreen.-tall Readings { margin: 1 0 2 0; }
    MonitorScreen.-tall #charts { grid-rows: 5; height: 15; margin-top: 1; }
    MonitorScreen.-tall StripChart { height: 4; }
    """
    HORIZONTAL_BREAKPOINTS = [(0, "-narrow"), (112, "-wide")]
    VERTICAL_BREAKPOINTS = [(0, "-short"), (34, "-tall")]

    def __init__(self, send: Callable[[MonitorVerb], None]) -> None:
        super().__init__()
        self._send = send
        self.view = MonitorView()
        self.title_line, self.state = TitleBar(), StateLine()
        self.horizon, self.readings, self.comparison = Horizon(), Readings(), RestComparison()
        self.filter_table = FilterTable()
        self.map, self.where = TrackMap(), LocationReadings()
        self.charts = (
            StripChart("ROLL", "deg", 0.02, roll="$axis-x"),
            StripChart("PITCH", "deg", 0.02, pitch="$axis-y"),
            StripChart("RATES", "deg/s", 0.02, p="$axis-x", q="$axis-y", r="$axis-z"),
            StripChart("RESIDUAL", "deg", 0.02, residual="$warning"),
            StripChart("AID", "m/s", 1.0, aid="$primary"),
            StripChart("U", "deg", 0.002, sigma="$accent"),
            StripChart("APART", "deg", 0.002, apart="$accent"),
        )
        self.events, self.streams, self.calibration = EventLines(), Streams(), CalibrationLine()

    def compose(self) -> ComposeResult:
        yield self.title_line
        yield self.state
        with Horizontal(id="upper"):
            yield self.horizon
            yield self.map
            with Vertical():
                yield self.readings
                yield self.comparison
                yield self.filter_table
                yield self.where
        with Grid(id="charts"):
            yield from self.charts
        yield self.events
        yield self.streams
        yield self.calibration
        yield KeyLine()

    def show(self, view: MonitorView) -> None:
        """Take a new view; with the first location its numbers come up, and the map once there is a place."""
        is_first, self.view = self.view.location is None and view.location is not None, view
        if is_first:
            self.add_class("-map")
            self.refresh_bindings()
        if view.location is not None:
            self.set_class(view.location.is_located, "-placed")
            self.map.show(view.location)
            self.where.show(view)
        names = f"filter {', '.join(reading.name for reading in view.filters)}  " if view.filters else ""
        self.title_line.show((f"{view.unit or 'FOG station'}  monitor", f"{names}aid {view.aid}{_at(view)}"))
        self.state.show(state_of(view))
        self.horizon.show(view.shown)
        self.readings.show(view)
        self.comparison.show(view.at_rest)
        self.filter_table.show(view.filters or None)
        self.set_class(bool(view.filters), "-filters")
        self.set_class(len(view.filters) > 1, "-two")
        for chart in self.charts:
            chart.show(view.history)
        self.events.show(view.events)
        self.streams.show(view.streams)
        self.set_class(len(view.streams) > MANY_STREAMS, "-crowded")
        self.calibration.show(view.in_use)
        self.calibration.set_class(bool(view.in_use.note), "noted")

    def action_map(self) -> None:
        self.toggle_class("-map")

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool:
        return action != "map" or self.view.location is not None

    def action_send(self, verb: MonitorVerb) -> None:
        self._send(verb)

    def action_leave(self) -> None:
        def answered(answer: bool | None) -> None:
            if answer:
                self._send("leave")

        if self.view.recording:
            self.app.push_screen(ConfirmScreen("End the monitor?", END_TEXT, "Yes, end it", ()), answered)
        else:
            answered(True)

    def action_help(self) -> None:
        text = MONITOR_HELP if self.view.location is None else HELP_LOCATED
        self.app.push_screen(HelpScreen("monitor", text, keys_of(self)))


def _at(view: MonitorView) -> str:
    reading = view.reading
    if reading is None:
        return ""
    return f"{'' if reading.speed is None else f' {reading.speed:.1f} m/s'}  {reading.t:.1f} s"


def state_of(view: MonitorView) -> tuple[str, str, str]:
    """Return the chip, its colour and the sentence that matter most."""
    if view.is_over:
        return "■ ENDED", "$foreground", view.line
    if view.trouble:
        ailing = next((stream for stream in view.streams if stream.trouble), view.streams[0])
        is_imu = ailing is view.streams[0]  # what stands next to it stops nothing
        return "✗ NO DATA" if is_imu else f"✗ {ailing.name.split()[0].upper()}", "$error", view.trouble
    if view.alarms:
        return "✗ ALARM", "$error", "; ".join(view.alarms)
    if view.line:
        return "… WAIT", "$warning", view.line
    if view.recording:
        return "● RECORDING", "$success", f"{view.folder}/{view.recording}"
    return "○ NOT RECORDED", "$muted", "r begins a recording" if view.folder else "use --folder FOLDER to record"


class MonitorApp(CommonApp):
    """The screen of one monitor."""

    def __init__(self, session: MonitorSession, *, refresh_hz: float = 10.0, is_quiet: bool = False) -> None:
        super().__init__(refresh_hz=refresh_hz, is_quiet=is_quiet)
        self._session = session
        self._view: MonitorView | None = None
        self.monitor = MonitorScreen(session.send)

    async def on_mount(self) -> None:
        """Begin to look at the session."""
        await self.push_screen(self.monitor)
        await super().on_mount()

    def pull(self) -> None:
        """Show the session's view if it is another; close when it is over."""
        view = self._session.view
        if view is self._view:
            return
        self.ring(view.events, is_first=self._view is None)
        self._view = view
        self.monitor.show(view)
        if view.is_over:
            self.exit()
