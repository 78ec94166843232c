"""How far each sigma is that a campaign goes on for: a bar that fills, reached and wanted, minutes left."""

from textual.content import Content

from procedures.units import S_PER_MIN
from station.guide.view import LimitView
from station.tui.bars import bar
from station.tui.widgets.redrawn_on_change import ValueWidget

NAME = " LIMITS   "
LEAST_BAR = 6  # columns; a shorter one says nothing
Limits = tuple[tuple[LimitView, ...], float]  # and the seconds that are left


class LimitsLines(ValueWidget[Limits]):
    """The sigma that is furthest from what is wanted; all of them, a line each, where there is room."""

    DEFAULT_CSS = "LimitsLines { height: 1; display: none; }"

    def _drawn(self, value: Limits) -> Content:
        limits, left_s = value
        shown = sorted(limits, key=lambda one: one.share)[: max(self.size.height, 1)]
        left = f", about {max(-(-left_s // S_PER_MIN), 1):.0f} min left" if left_s else ""
        left = ", all targets met" if all(one.share >= 1 for one in limits) else left
        said = [(left, NAME), *[("", " " * len(NAME))] * (len(shown) - 1)]
        return Content("\n").join(self._line(one, *each) for one, each in zip(shown, said, strict=True))

    def _line(self, one: LimitView, left: str, name: str) -> Content:
        width = self.size.width - len(name)
        # a number is not cut: first the minutes go, which the title has as well, then the bar
        said = next((f" {text} " for text in (one.text + left, one.text) if _has_bar(text, width)), f" {one.text}")
        room = max(width - len(said), 0)
        colour = "$success" if one.share >= 1 else "$accent"
        return Content.assemble((name, "bold"), bar(one.share, room, colour), (said, "bold"))


def _has_bar(text: str, width: int) -> bool:
    """Say whether there is room for a bar beside a text, in a line of so many columns."""
    return len(text) + 2 + LEAST_BAR <= width
