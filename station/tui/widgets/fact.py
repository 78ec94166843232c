"""A named fact in a line of its own; not there while there is nothing to say."""

from textual.app import ComposeResult
from textual.containers import Horizontal
from textual.widgets import Static


class FactLine(Horizontal):
    """A name on the left, the text beside it however long."""

    DEFAULT_CSS = """
    FactLine { height: auto; padding: 0 2; display: none; }
    FactLine.said { display: block; }
    FactLine .name { width: 11; color: $muted; }
    FactLine .text { width: 1fr; height: auto; }
    FactLine.warning .text { color: $warning; text-style: bold; }
    FactLine.good .text { color: $success; text-style: bold; }
    """

    def __init__(self, name: str, classes: str = "") -> None:
        super().__init__(classes=classes)
        self._label, self._text = name, Static("", classes="text", markup=False)

    def compose(self) -> ComposeResult:
        """Lay out name and text."""
        yield Static(self._label, classes="name", markup=False)
        yield self._text

    def say(self, text: str) -> None:
        """Say something, or nothing."""
        self._text.update(text)
        self.set_class(bool(text), "said")
