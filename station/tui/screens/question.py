"""Something only the operator knows."""

from textual.app import ComposeResult
from textual.containers import Vertical
from textual.content import Content
from textual.events import Key
from textual.widgets import Label, OptionList
from textual.widgets.option_list import Option

from station.guide.setup_view import Choice
from station.guide.view import CalibrationView, OperatorQuestion
from station.tui.screens.modal import Modal

ANSWER_LATER = ""


class QuestionScreen(Modal[str]):
    """Returns the key of the choice, or `ANSWER_LATER`.

    A choice is taken by its own key where all keys are single characters, else by its number. None is under the
    cursor at first, so that no stray Enter answers.
    """

    DEFAULT_CSS = """
    QuestionScreen OptionList { width: 66; height: auto; max-height: 10; border: none; padding: 0; }
    QuestionScreen.-phone OptionList, QuestionScreen.-phone #keys { width: 36; }
    QuestionScreen #keys { margin: 1 0 0 0; color: $muted; }
    """
    BINDINGS = [("escape", f"dismiss({ANSWER_LATER!r})", "Not now")]

    def __init__(self, question: OperatorQuestion) -> None:
        super().__init__()
        self.question = question
        keys = [choice.key for choice in question.choices]
        is_short = all(len(key) == 1 for key in keys)
        self._keys = {key if is_short else str(number): key for number, key in enumerate(keys, start=1)}
        self._list = OptionList(*map(self._option, self._keys, question.choices), compact=True, markup=False)
        self._list.highlighted = None

    def _option(self, key: str, choice: Choice) -> Option:
        note = f"  ({choice.note})" if choice.note else ""
        return Option(Content.assemble((f" {key}  ", "bold $accent"), choice.title, note))

    def compose(self) -> ComposeResult:
        """Lay out the text and the choices."""
        with Vertical(classes="box") as box:
            box.border_title = "Question"
            yield Label(self.question.text, markup=False)
            yield self._list
            yield Label("press its key, or use arrows and Enter; Esc: later, a asks again", id="keys")

    def fits(self, view: CalibrationView) -> bool:
        """Return whether the question is still asked."""
        return view.question == self.question

    def on_key(self, event: Key) -> None:
        """Take a choice by its key."""
        if (key := self._keys.get(event.character or "")) is not None:
            self.dismiss(key)

    def on_option_list_option_selected(self, event: OptionList.OptionSelected) -> None:
        """Take the choice under the cursor."""
        self.dismiss(self.question.choices[event.option_index].key)
