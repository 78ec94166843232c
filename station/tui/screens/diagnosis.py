"""The whole diagnosis of a campaign, as `station diagnose` prints it."""

from textual.app import ComposeResult
from textual.binding import Binding
from textual.containers import VerticalScroll
from textual.widgets import Static

from station.guide.view import VERDICT_STAGES
from station.tui.screens.modal import Modal
from station.tui.widgets.key_line import KeyLine

NO_DIAGNOSIS = "There is no diagnosis of this campaign yet: finish it first."


class DiagnosisScreen(Modal[None]):
    """A screen of its own over the verdict; the text is 80 columns wide and as long as it is."""

    BINDINGS = [
        Binding("escape", "dismiss(None)", "Back", tooltip="back to the verdict"),
        Binding("d,q,enter", "dismiss(None)", show=False),
        Binding("down", "roll(1)", "More", key_display="↑↓", tooltip="scroll"),
        Binding("up", "roll(-1)", show=False),
        Binding("pagedown,space", "roll(10)", show=False),
        Binding("pageup", "roll(-10)", show=False),
        Binding("right", "shift(8)", show=False),
        Binding("left", "shift(-8)", show=False),
    ]
    DEFAULT_CSS = """
    DiagnosisScreen { align: left top; background: $background; }
    DiagnosisScreen #title { height: 1; width: 100%; padding: 0 1; background: $primary; color: $background; }
    DiagnosisScreen VerticalScroll { height: 1fr; width: 100%; scrollbar-size: 1 0; overflow-x: auto; }
    DiagnosisScreen #text { width: 80; height: auto; }
    """

    def __init__(self, text: str) -> None:
        super().__init__(VERDICT_STAGES)
        self.text = Static(text or NO_DIAGNOSIS, id="text", markup=False)
        self.scroll = VerticalScroll(self.text, can_focus=False)

    def compose(self) -> ComposeResult:
        """Lay out a title, the text and the keys."""
        yield Static("Diagnosis", id="title")
        yield self.scroll
        yield KeyLine()

    def action_roll(self, rows: int) -> None:
        """Scroll."""
        self.scroll.scroll_relative(y=rows, animate=False)

    def action_shift(self, columns: int) -> None:
        """Scroll sideways, where the terminal is narrower than the text."""
        self.scroll.scroll_relative(x=columns, animate=False)
