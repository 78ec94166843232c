"""What is there before a campaign begins, line by line, and how it can end."""

from textual.app import ComposeResult
from textual.binding import Binding
from textual.containers import Vertical, VerticalScroll
from textual.content import Content
from textual.widgets import Label, Static

from station.guide.setup_view import Readiness
from station.tui.screens.modal import Modal
from station.tui.widgets.ready_lines import consequences, ready_line

STILL_OPEN = "Limits can be stored later; the rest is used as it is now."


class ReadyScreen(Modal[bool]):
    """Returns True for begin. ``asks``: it stands between the form and the campaign; else it only informs."""

    BINDINGS = [
        Binding("y", "dismiss(True)", "Begin anyway"),
        Binding("n,escape,enter,ctrl+r,space", "dismiss(False)", "Back"),
    ]

    def __init__(self, ready: Readiness, *, asks: bool) -> None:
        super().__init__(("start",))
        self._ready, self._asks = ready, asks

    def compose(self) -> ComposeResult:
        """Lay out the lines, the consequences and the keys."""
        with Vertical(classes="box") as box:
            box.border_title = "Begin anyway?" if self._asks else "Ready?"
            with VerticalScroll():
                yield Static(Content("\n").join(ready_line(one) for one in self._ready.lines))
                yield Static(Content("\n").join((Content(""), *consequences(self._ready))))
            if self._asks:
                yield Static(Content.assemble("\n", (STILL_OPEN, "$muted")))
            keys = "y  Begin anyway    n  Back to the form" if self._asks else "Esc closes"
            yield Label(Content.assemble("\n", (keys, "bold $accent")))

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        """Begin only where that was asked."""
        return self._asks or parameters != (True,)
