"""The step under the cursor in words: what became of it."""

from textual.content import Content

from station.guide.view import StepView
from station.tui.orientation import short_step_title
from station.tui.widgets.drawn import ValueWidget


class StepWords(ValueWidget[StepView | None]):
    """Name, state, seconds, how many recordings are superseded, and what was noted."""

    DEFAULT_CSS = """
    StepWords { height: 1fr; min-height: 3; padding: 0 1; text-wrap: wrap; }
    """

    def __init__(self) -> None:
        super().__init__(None, id="words")

    def render(self) -> Content:
        """Draw the words."""
        step = self.value
        if step is None:
            return Content("")
        said = [step.state, f"{step.seconds:.0f} s" if step.attempts else ""]
        said += [f"{step.superseded} superseded" if step.superseded else "", step.note]
        return Content.assemble((f"{short_step_title(step)}: ", "bold"), ", ".join(word for word in said if word))
