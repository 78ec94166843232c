"""A labelled line to type in, checked as it is typed."""

from textual.app import ComposeResult
from textual.containers import Horizontal
from textual.widgets import Input, Label

from station.tui.setup_entries import Entry


class SetupField(Horizontal):
    """An entry of the set-up; a cross and the colour of errors while its text is wrong."""

    DEFAULT_CSS = """
    SetupField { height: 1; }
    SetupField .label { width: 11; }
    SetupField .mark { width: 2; color: $error; }
    SetupField Input { width: 1fr; max-width: 24; }
    SetupField.long Input { max-width: 100%; margin-right: 2; }
    SetupField .unit { width: 6; padding-left: 1; color: $muted; }
    SetupField.wrong .label { color: $error; text-style: bold; }
    """

    def __init__(self, entry: Entry, *, is_long: bool = False) -> None:
        super().__init__(id=f"field-{entry.name}", classes="long" if is_long else "")
        self.entry = entry
        self.input = Input(placeholder=entry.empty, compact=True, id=entry.name, select_on_focus=False)
        self._mark = Label("", classes="mark")

    def compose(self) -> ComposeResult:
        """Lay out mark, label, input and unit."""
        yield self._mark
        yield Label(self.entry.label, classes="label")
        yield self.input
        if not self.has_class("long"):
            yield Label(self.entry.unit, classes="unit")

    def judge(self, problem: str) -> None:
        """Mark the field as wrong or right."""
        self.set_class(bool(problem), "wrong")
        self._mark.update("✗" if problem else "")
