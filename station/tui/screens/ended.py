"""The end without a verdict: what became of the data."""

from textual.app import ComposeResult
from textual.binding import Binding
from textual.containers import Vertical
from textual.content import Content
from textual.widgets import Static

from station.guide.view import CalibrationView, StageName
from station.tui.screens.stage import StageScreen

ENDED_LOOKS: dict[StageName, tuple[str, str, str]] = {
    "cancelled": (
        "✗ CANCELLED", "$warning",
        "All recordings stay as files in the folder; the database is unchanged.",
    ),
    "left": ("‖ LEFT", "$primary", "All accepted steps are safe; `station resume` continues from here."),
    "failed": (
        "✗ STOPPED", "$error",
        "All accepted steps are safe; `station resume` continues after you correct this.",
    ),
}  # fmt: skip


class EndedScreen(StageScreen):
    """One sentence; any of the usual keys closes."""

    HELPS = {stage: sentence for stage, (_, _, sentence) in ENDED_LOOKS.items()}
    BINDINGS = [
        Binding("enter", "leave", "Close", tooltip="close the program"),
        Binding("escape,space,q,c", "leave", show=False),
    ]
    DEFAULT_CSS = """
    EndedScreen #ended { align: center middle; height: 1fr; }
    EndedScreen Static { width: 100%; max-width: 72; height: auto; }
    """

    def _body(self) -> ComposeResult:
        self.text = Static()
        with Vertical(id="ended"):
            yield self.text

    def _draw(self, view: CalibrationView) -> None:
        word, colour, sentence = ENDED_LOOKS.get(view.stage, ENDED_LOOKS["failed"])
        parts = [Content.styled(f" {word} ", f"bold $background on {colour}"), Content("")]
        if view.stage == "cancelled" and not view.folder:
            sentence = ""  # nothing was begun
        parts += [Content(text + "\n") for text in (view.error, view.line, sentence) if text]
        if view.folder:
            parts.append(Content.assemble(("folder  ", "$muted"), view.folder))
        self.text.update(Content("\n").join(parts))

    def action_leave(self) -> None:
        """Close; there is nothing left to leave."""
        self.app.exit()
