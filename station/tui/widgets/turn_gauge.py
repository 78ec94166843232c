"""A hand turn: how many turns, how fast, how long it rests."""

from textual.content import Content

from station.guide.view import TurnView
from station.tui.bars import bar, pointer
from station.tui.widgets.redrawn_on_change import ValueWidget

NUMBER_COLUMNS = 19  # columns of the numbers on the right


class TurnGauge(ValueWidget[TurnView]):
    """Three lines: turns, speed between its limits, and the rest."""

    DEFAULT_CSS = "TurnGauge { height: 3; }"

    def _drawn(self, turn: TurnView) -> Content:
        room = max(self.size.width - 8 - NUMBER_COLUMNS, 8)
        speed, (word, colour) = abs(turn.speed_deg_s), _judged(turn)
        turns, turned = abs(turn.revolutions) / turn.wanted, f"{abs(turn.revolutions):.2f} of {turn.wanted}"
        limits = f"{speed:.0f} deg/s, {turn.slow_deg_s:g}-{turn.fast_deg_s:g}"
        scale = Content.styled(pointer(speed / (1.2 * turn.fast_deg_s), max(room - 11, 4)), colour)
        rested = f"{turn.rest_s:.0f} of {turn.rest_wanted_s:.0f} s"
        return Content("\n").join((
            _line("TURNS", bar(turns, room, "$accent"), turned, "bold"),
            _line("SPEED", Content.assemble((f"{word:11}", f"bold {colour}"), scale), limits),
            _line("REST", bar(turn.rest_s / turn.rest_wanted_s, room, "$success"), rested),
        ))  # fmt: skip


def _line(name: str, gauge: Content, numbers: str, look: str = "") -> Content:
    return Content.assemble((f" {name:6}", "bold"), gauge, (f"{numbers:>{NUMBER_COLUMNS}}", look))


def _judged(turn: TurnView) -> tuple[str, str]:
    speed = abs(turn.speed_deg_s)
    if speed < turn.slow_deg_s / 5:
        return "◼ at rest", "$foreground"
    if speed < turn.slow_deg_s:
        return "▲ faster", "$warning"
    if speed > turn.fast_deg_s:
        return "▼ slower", "$error"
    return "✓ good", "$success"
