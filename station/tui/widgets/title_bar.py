"""The top line: which unit, which campaign, how far, how long still."""

from textual.content import Content

from station.guide.view import CalibrationView
from station.tui.durations_in_words import duration_in_words
from station.tui.widgets.drawn import ValueWidget


class TitleBar(ValueWidget[tuple[str, str]]):
    """What is calibrated on the left, progress on the right."""

    DEFAULT_CSS = """
    TitleBar { height: 1; padding: 0 1; background: $panel; color: $foreground; }
    """

    def __init__(self) -> None:
        super().__init__(("", ""), id="title")

    def show_view(self, view: CalibrationView) -> None:
        """Take what belongs here."""
        campaign = view.folder.rstrip("/").rpartition("/")[2]
        self.show((f"{view.unit or 'FOG station'}  {campaign or 'guided calibration'}", progress(view)))

    def render(self) -> Content:
        """Draw the line; where it is short, the progress stays."""
        left, right = self.value
        room = self.size.width - len(right) - 2
        return Content.assemble((left[:room].ljust(room) + "  ", "bold"), right)


def progress(view: CalibrationView) -> str:
    """Return how far the campaign is: ``step 8 of 18, 21 min left``."""
    total = len(view.steps)
    if not total:
        return ""
    if view.stage in ("cancelled", "left", "failed"):
        return f"{view.done} of {total} steps done"
    step = f"step {view.done + 1} of {total}" if view.done < total else f"{total} of {total} steps done"
    return f"{step}, {duration_in_words(view.remaining_s)} left" if view.remaining_s > 0 else step
