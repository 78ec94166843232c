"""What goes on in this state, and what each key does."""

from textual.app import ComposeResult
from textual.containers import Vertical, VerticalScroll
from textual.content import Content
from textual.screen import Screen
from textual.widgets import Static

from station.tui.screens.modal import Modal

SOUNDS_HELP = "one: begin, two: keep still, three quick: accepted, four slow: rejected"


class HelpScreen(Modal[None]):
    """The help of one stage, or of a screen that has none; ``keys`` by what they do."""

    BINDINGS = [("escape,question_mark,q,enter,space", "dismiss(None)", "Close")]

    def __init__(self, stage: str, text: str, keys: dict[str, str]) -> None:
        super().__init__((stage,))
        self._stage, self._text, self._keys = stage, text, keys

    def compose(self) -> ComposeResult:
        """Lay out the text, the keys and the sounds."""
        with Vertical(classes="box") as box:
            box.border_title = f"Help: {self._stage.replace('_', ' ')}"
            box.border_subtitle = "Esc closes"
            with VerticalScroll():
                yield Static(self._content())

    def _content(self) -> Content:
        width = max(map(len, self._keys.values()), default=0)
        keys = [
            Content.assemble((f"{key:>{width}}", "bold $accent"), f"  {what}") for what, key in self._keys.items()
        ]
        sounds = Content.assemble(("sounds  ", "bold"), SOUNDS_HELP)
        return Content("\n").join([Content(self._text), Content(""), *keys, Content(""), sounds])


def keys_of(screen: Screen[None]) -> dict[str, str]:
    """Return the keys that work on a screen, by what they do."""
    keys: dict[str, str] = {}
    for active in screen.active_bindings.values():
        is_told = active.binding.show or (active.node is screen and active.binding.tooltip)
        if is_told and active.enabled:
            what = active.tooltip or active.binding.description
            keys[what] = ", ".join(filter(None, (keys.get(what), screen.app.get_key_display(active.binding))))
    return keys
