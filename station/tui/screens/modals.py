"""Modal screens: confirm, question, help, readiness, diagnosis; closed when answered or out of date."""

from collections.abc import Collection
from textwrap import wrap
from typing import Generic, TypeVar

from textual.app import ComposeResult
from textual.await_complete import AwaitComplete
from textual.binding import Binding
from textual.containers import Horizontal, Vertical, VerticalScroll
from textual.content import Content
from textual.events import Key
from textual.screen import ModalScreen, Screen
from textual.widgets import Button, Label, OptionList, Static
from textual.widgets.option_list import Option

from station.guide.setup_view import Choice, Readiness, ReadyLine
from station.guide.view import VERDICT_STAGES, CalibrationView, OperatorQuestion, StageName
from station.tui.widgets.common import KeyLine, ValueWidget

T = TypeVar("T")
MIN_COLUMNS = 80  # of a terminal; narrower, as a telephone, parts stand below each other


class Modal(ModalScreen[T], Generic[T]):
    """A modal that makes sense in ``stages``; the application closes it in any other."""

    DEFAULT_CSS = """
    Modal { align: center middle; }
    Modal > .box {
        width: auto; max-width: 74; height: auto; max-height: 90%;
        padding: 1 2; background: $surface; border: round $primary;
    }
    Modal > .box VerticalScroll { height: auto; max-height: 16; }
    Modal > .box Label { width: auto; max-width: 66; height: auto; margin-bottom: 1; }
    Modal.-phone > .box Label { max-width: 36; }
    """
    HORIZONTAL_BREAKPOINTS = [(0, "-phone"), (MIN_COLUMNS, "-narrow")]

    def __init__(self, stages: Collection[str] = ()) -> None:
        super().__init__()
        self._stages = stages

    def fits(self, view: CalibrationView) -> bool:
        """Return whether the modal still makes sense."""
        return view.stage in self._stages

    def dismiss(self, result: T | None = None) -> AwaitComplete:
        """Close, once: the next key may wait already, and Textual would close what lies below."""
        return super().dismiss(result) if self.is_active else AwaitComplete()


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


SOUNDS_HELP = "one: begin, two: keep still, three quick: accepted, four slow: rejected"


class HelpScreen(Modal[None]):
    """The help of one stage, or of a screen that has none; ``keys`` by what they do."""

    BINDINGS = [("escape,question_mark,q,enter,space", "dismiss(None)", "Close")]

    def __init__(self, stage: str, text: str, keys: dict[str, str]) -> None:
        super().__init__((stage,))
        self._stage, self._text, self._keys = stage, text, keys

    def compose(self) -> ComposeResult:
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
    keys: dict[str, list[str]] = {}
    for active in screen.active_bindings.values():
        is_shown = active.binding.show or (active.node is screen and active.binding.tooltip)
        if is_shown and active.enabled:
            what = active.tooltip or active.binding.description
            keys.setdefault(what, []).append(screen.app.get_key_display(active.binding))
    return {what: ", ".join(dict.fromkeys(each)) for what, each in keys.items()}


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


WIDTH, INDENT = 68, 12  # of a line in the list
READY_LOOKS = {"ready": ("✓", "$success"), "note": ("·", "$foreground"), "lacks": ("✗", "$warning")}


class ReadyLines(ValueWidget[Readiness]):
    """Two lines: can it end in PASS, can it end in a certificate, and why not."""

    DEFAULT_CSS = "ReadyLines { height: 2; padding: 0 2; }"

    def _drawn(self, ready: Readiness) -> Content:
        return Content("\n").join(consequences(ready, self.content_size.width))


def consequences(ready: Readiness, width: int | None = None) -> list[Content]:
    """Return how the campaign can end, a line each; a reason longer than ``width`` is only pointed to."""
    states = {True: "ready", False: "lacks", None: "note"}
    answers = zip((ready.can_pass, ready.can_certify), ready.outcomes, strict=True)
    return [_styled(states[answer], _fitting(text, width)) for answer, text in answers]


def _fitting(text: str, width: int | None) -> str:
    if width is None or len(text) + 2 <= width:
        return text
    return f"{text.partition(', ')[0]}, ctrl+r for details"


def ready_line(one: ReadyLine) -> Content:
    """Return a thing that is needed, its state as symbol and colour, and what is known of it."""
    rows = wrap(one.text, WIDTH - INDENT, break_on_hyphens=False)
    return _styled(one.state, f"{one.name:{INDENT - 2}}" + f"\n{' ' * INDENT}".join(rows))


def _styled(state: str, text: str) -> Content:
    symbol, colour = READY_LOOKS[state]
    return Content.assemble((f"{symbol} ", f"bold {colour}"), text)


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
        return self._asks or parameters != (True,)


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
        yield Static("Diagnosis", id="title")
        yield self.scroll
        yield KeyLine()

    def action_roll(self, rows: int) -> None:
        self.scroll.scroll_relative(y=rows, animate=False)

    def action_shift(self, columns: int) -> None:
        """Scroll sideways, where the terminal is narrower than the text."""
        self.scroll.scroll_relative(x=columns, animate=False)
