"""A hand turn: how many turns, how fast, how it came back."""

from textual.content import Content

from station.guide.view import TurnView
from station.tui.bars import bar, pointer
from station.tui.widgets.redrawn_on_change import ValueWidget

NUMBER_COLUMNS = 19  # columns of the numbers on the right


class TurnGauge(ValueWidget[TurnView | None]):
    """Three lines: turns, speed between its limits, and the return or the rest."""

    DEFAULT_CSS = """
    TurnGauge { height: 3; }
    """

    def __init__(self) -> None:
        super().__init__(None, id="turn")

    def render(self) -> Content:
        """Draw the gauges."""
        turn = self.value
        if turn is None:
            return Content("")
        room = max(self.size.width - 8 - NUMBER_COLUMNS, 8)
        return Content("\n").join((_turns(turn, room), _speed(turn, room - 11), _back(turn, room)))


def _turns(turn: TurnView, room: int) -> Content:
    filled, empty = bar(abs(turn.revolutions) / turn.wanted, room)
    numbers = f"{abs(turn.revolutions):.2f} of {turn.wanted}"
    return Content.assemble(
        (" TURNS ", "bold"),
        (filled, "$accent"),
        (empty, "on $foreground 12%"),
        (f"{numbers:>{NUMBER_COLUMNS}}", "bold"),
    )


def _speed(turn: TurnView, room: int) -> Content:
    speed = abs(turn.speed_deg_s)
    word, colour = _judged(turn)
    numbers = f"{speed:.0f} deg/s, {turn.slow_deg_s:g}-{turn.fast_deg_s:g}"
    scale = pointer(speed / (1.2 * turn.fast_deg_s), max(room, 4))
    return Content.assemble(
        (" SPEED ", "bold"),
        (f"{word:11}", f"bold {colour}"),
        (scale, colour),
        (f"{numbers:>{NUMBER_COLUMNS}}", ""),
    )


def _judged(turn: TurnView) -> tuple[str, str]:
    speed = abs(turn.speed_deg_s)
    if speed < turn.slow_deg_s / 5:
        return "◼ at rest", "$foreground"
    if speed < turn.slow_deg_s:
        return "▲ faster", "$warning"
    if speed > turn.fast_deg_s:
        return "▼ slower", "$error"
    return "✓ good", "$success"


def _back(turn: TurnView, room: int) -> Content:
    if turn.came_back_deg is None:
        filled, empty = bar(turn.rest_s / turn.rest_wanted_s, room)
        numbers = f"{turn.rest_s:.0f} of {turn.rest_wanted_s:.0f} s"
        return Content.assemble(
            (" REST  ", "bold"),
            (filled, "$success"),
            (empty, "on $foreground 12%"),
            f"{numbers:>{NUMBER_COLUMNS}}",
        )
    sigma = "" if turn.came_back_std_deg is None else f" ± {turn.came_back_std_deg:.3f}"
    return Content.assemble((" BACK  ", "bold"), f"came back within {abs(turn.came_back_deg):.3f}{sigma} deg")
