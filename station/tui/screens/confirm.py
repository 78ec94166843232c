"""Yes or no, before something that cannot be taken back."""

from collections.abc import Collection

from textual.app import ComposeResult
from textual.containers import Horizontal, Vertical
from textual.widgets import Button, Label

from station.guide.view import StageName
from station.tui.screens.modal import Modal


class ConfirmScreen(Modal[bool]):
    """Returns True for yes."""

    DEFAULT_CSS = """
    ConfirmScreen Horizontal { width: auto; height: auto; }
    ConfirmScreen Button { margin-right: 2; }
    """
    BINDINGS = [
        ("y", "dismiss(True)", "Yes"),
        ("n,escape", "dismiss(False)", "No"),
        ("left,right,up,down", "app.focus_next", "Other button"),
    ]

    def __init__(self, title: str, text: str, yes: str, stages: Collection[StageName]) -> None:
        super().__init__(stages)
        self._title, self._text, self._yes = title, text, yes

    def compose(self) -> ComposeResult:
        """Lay out title, text and two buttons; the harmless one has the focus."""
        with Vertical(classes="box") as box:
            box.border_title = self._title
            yield Label(self._text, markup=False)
            with Horizontal():
                yield Button("n  No, continue", action="screen.dismiss(False)", compact=True)
                yield Button(f"y  {self._yes}", action="screen.dismiss(True)", variant="error", compact=True)
