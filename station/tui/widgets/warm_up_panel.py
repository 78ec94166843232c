"""Warm-up: what must come to rest inside, against the limits learnt from the unit."""

from textual.content import Content

from station.guide.view import WarmUpView
from station.guide.wording import rounded
from station.tui.bars import bar
from station.tui.durations_in_words import duration_in_words
from station.tui.widgets.redrawn_on_change import ValueWidget


class WarmUpPanel(ValueWidget[WarmUpView]):
    """Time gone and left, then temperature rate and gyro drift with a bar each."""

    DEFAULT_CSS = "WarmUpPanel { text-wrap: wrap; height: auto; padding: 1 2; }"

    def render(self) -> Content:
        """Draw what is known."""
        warm = self.value
        if warm is None:
            return Content.styled("waiting for the first counts", "$muted")
        left = "not known yet" if warm.left_s is None else f"about {duration_in_words(warm.left_s)}"
        lines = [
            Content.assemble(("time so far     ", "$muted"), (duration_in_words(warm.seconds), "bold")),
            Content.assemble(("time left       ", "$muted"), (left, "bold")),
            Content(""),
            self._gate("temp. rate", warm.temperature_rate_c_min, warm.temperature_limit_c_min, "°C/min"),
            self._gate("gyro drift", warm.gyro_drift_deg_h, warm.gyro_limit_deg_h, "deg/h"),
        ]
        if warm.note:
            lines += [Content(""), Content(warm.note)]
        return Content("\n").join(lines)

    def _gate(self, name: str, value: float | None, limit: float | None, unit: str) -> Content:
        if value is None or limit is None:
            said = "not measured yet" if value is None else f"{value:.2g} {unit}, the limit is being determined"
            return Content.assemble((f"{name:16}", "bold"), (f"… {said}", "$muted"))
        is_inside = abs(value) <= limit
        colour, word = ("$success", "✓ settled ") if is_inside else ("$warning", "✗ changing")
        sign = "<" if is_inside else ">"
        numbers = f"{rounded(abs(value), limit)} {sign} {rounded(limit, limit)} {unit}"
        return Content.assemble(
            (f"{name:16}", "bold"), (f"{word} ", f"bold {colour}"),
            bar(abs(value) / limit, max(self.size.width - 16 - 11 - 24, 8), colour), f"{numbers:>24}",
        )  # fmt: skip
