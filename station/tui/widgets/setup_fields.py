"""The parts of the set-up's form: a labelled line to type in, and a labelled list to choose from."""

from textual.app import ComposeResult
from textual.binding import Binding
from textual.containers import Horizontal, Vertical
from textual.message import Message
from textual.widgets import Input, Label, Select

from station.guide.setup_view import Choice
from station.tui.setup_entries import Entry


class SetupInput(Input):
    """A line to type in; Enter takes effect before the next key is looked at, however quickly that is typed."""

    BINDINGS = [Binding("enter", "take", show=False, priority=True)]

    class Taken(Message):
        """Enter was pressed in the line ``name``."""

        def __init__(self, name: str) -> None:
            super().__init__()
            self.name = name

    def __init__(self, entry: Entry, *, stays: bool) -> None:
        super().__init__(
            placeholder=entry.empty, compact=True, id=entry.name, select_on_focus=False,
            validate_on=(),  # the form judges; textual would give each its styles once more for it
        )  # fmt: skip
        self._stays = stays

    def check_consume_key(self, key: str, character: str | None) -> bool:
        """Leave a question mark to the screen, which opens help, while nothing is typed."""
        return super().check_consume_key(key, character) and bool(self.value or key != "question_mark")

    def action_take(self) -> None:
        """Say that it was entered, and go to the next line unless what was entered is looked at first."""
        self.post_message(self.Taken(self.id or ""))
        if not self._stays:
            self.screen.focus_next()


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
        self.input = SetupInput(entry, stays=is_long)
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
        if bool(problem) != self.has_class("wrong"):  # a mark drawn anew lays the whole screen out again
            self.set_class(bool(problem), "wrong")
            self._mark.update("✗" if problem else "")


class PickList(Vertical):
    """Choices of a set-up; ``value`` is the key chosen, empty for none. Tab passes over a list without choices."""

    DEFAULT_CSS = """
    PickList { height: auto; }
    PickList Horizontal { height: 1; }
    PickList .label { width: 11; margin-left: 2; }
    PickList Select { width: 1fr; margin-right: 2; }
    PickList .note { height: auto; margin-left: 13; color: $success; display: none; }
    PickList .note.said { display: block; }
    PickList .note.warns { color: $warning; text-style: bold; }
    """

    def __init__(self, name: str, label: str, prompt: str, none_prompt: str) -> None:
        super().__init__(id=f"pick-{name}")
        self.select: Select[str] = Select((), prompt=none_prompt, compact=True, id=name, disabled=True)
        self._prompt, self._none_prompt = prompt, none_prompt
        self._label, self._choices = label, tuple[Choice, ...]()
        self._note = Label("", classes="note", markup=False)

    def compose(self) -> ComposeResult:
        """Lay out label, list and note."""
        with Horizontal():
            yield Label(self._label, classes="label")
            yield self.select
        yield self._note

    @property
    def value(self) -> str:
        """The key chosen."""
        return self.select.selection or ""

    def offer(self, choices: tuple[Choice, ...]) -> None:
        """Offer other choices; what was chosen stays if it still can be."""
        if choices != self._choices:
            chosen = self.value
            self._choices = choices
            self.select.disabled = not choices
            self.select.prompt = self._prompt if choices else self._none_prompt
            self.select.set_options((choice.title, choice.key) for choice in choices)
            self.choose(chosen)

    def choose(self, key: str) -> None:
        """Choose by key; nothing is chosen by a key that is not there."""
        self.select.value = key if key in {choice.key for choice in self._choices} else Select.NULL

    def explain(self) -> None:
        """Say what must be known about the choice: a warning, or that all is well."""
        note, warns = next(((c.note, c.warns) for c in self._choices if c.key == self.value), ("", False))
        self._note.update(f"{'!' if warns else '✓'} {note}" if note else "")
        self._note.set_class(bool(note), "said")
        self._note.set_class(warns, "warns")
