"""The set-up of a new campaign: port, unit, cube, slab, site, operator, how long and how many."""

from dataclasses import dataclass

from textual.app import ComposeResult
from textual.binding import Binding
from textual.containers import Horizontal, Vertical, VerticalScroll
from textual.content import Content
from textual.events import DescendantBlur
from textual.message import Message
from textual.widgets import Input, Label, Select

from station.files.campaign_setup import Setup
from station.guide.setup_view import Choice, PortCheck, StartView
from station.tui.widgets.common import ValueWidget
from station.tui.widgets.setup_entries import ENTRIES, MISSING, Entry, problems, setup_of, texts_of


@dataclass(frozen=True, slots=True)
class AddressLook:
    """The address in the form, the newest look at one, whether another is under way; ``use``: what it is good for.

    Of a receiver alone there is a ``use``.
    """

    url: str
    check: PortCheck | None
    is_under_way: bool
    use: str = ""


class LookLine(ValueWidget[AddressLook]):
    """What was found at an address: a unit with rate, errors and noise, or a place; or why there is no telling."""

    DEFAULT_CSS = """
    LookLine { text-wrap: wrap; height: auto; min-height: 1; max-height: 4; margin-left: 13; }
    LookLine#receiver { max-height: 3; }
    """

    def _drawn(self, look: AddressLook) -> Content:
        check = look.check
        if look.is_under_way:
            port, receiver = "checking the port for two seconds", "checking the receiver for a few seconds"
            return Content.styled(f"… {receiver if look.use else port}", "$muted")
        if check is None or check.url != look.url:
            text = "not checked yet: press Enter in the address, or ctrl+l" if look.url else ""
            return Content.styled(text, "$muted")
        if not check.is_good:
            return Content.styled(f"✗ {check.text}", "bold $error")
        if look.use:
            return Content.assemble(("✓ ", "bold $success"), (check.text, "bold"), f"; {look.use}")
        unit = f"{check.model or 'model unknown'} {check.serial or 'serial number unknown'}"
        rate = "" if check.rate_hz is None else f", {check.rate_hz:.1f} Hz"
        errors = f", {check.bad_frames} of {check.frames + check.bad_frames} frames bad"
        return Content.assemble(
            ("✓ ", "bold $success"), (f"{check.format}, {unit}", "bold"), f"{rate}{errors}",
            f", noise {check.noise}" if check.noise else "",
        )  # fmt: skip


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
        yield self._mark
        yield Label(self.entry.label, classes="label")
        yield self.input
        if not self.has_class("long"):
            yield Label(self.entry.unit, classes="unit")

    def judge(self, problem: str) -> None:
        """Mark the field as wrong or right."""
        if bool(problem) != self.has_class("wrong"):  # a mark that is drawn again lays the whole screen out again
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
    PickList .note.shown { display: block; }
    PickList .note.warns { color: $warning; text-style: bold; }
    """

    def __init__(self, name: str, label: str, prompt: str, none_prompt: str) -> None:
        super().__init__(id=f"pick-{name}")
        self.select: Select[str] = Select((), prompt=none_prompt, compact=True, id=name, disabled=True)
        self._prompt, self._none_prompt = prompt, none_prompt
        self._label, self._choices = label, tuple[Choice, ...]()
        self._note = Label("", classes="note", markup=False)

    def compose(self) -> ComposeResult:
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
        self._note.set_class(bool(note), "shown")
        self._note.set_class(warns, "warns")


FIELD_PAIRS = (
    ("latitude_deg", "longitude_deg"), ("height_m", "operator"), ("gravity_m_s2", "gravity_std_m_s2"),
    ("dwell_s", "bias_ug"), ("revolutions", "repeats"),
)  # fmt: skip
ADDRESS_FIELDS = ("url", "gnss")


class SetupForm(VerticalScroll, can_focus=False):
    """Filled from a set-up whenever that is another, and left to the operator in between."""

    DEFAULT_CSS = """
    SetupForm { width: 100%; height: 1fr; scrollbar-size: 1 1; }
    SetupForm .pair { height: 1; }
    SetupForm .pair > * { width: 1fr; }
    """

    def __init__(self) -> None:
        super().__init__(id="form")
        self.port = PickList("port", "Port", "ports found: Enter opens the list", "none found: type the address")
        self.cube = PickList("cube", "Cube", "which cube: Enter opens the list", "none is stored")
        self.slab = PickList("slab", "Slab", "which slab: Enter opens the list", "none is stored")
        self.look, self.heard = LookLine(), LookLine(id="receiver")
        self.fields = {entry.name: SetupField(entry, is_long=entry.name in ADDRESS_FIELDS) for entry in ENTRIES}
        self._start = StartView()
        self._filled: Setup | None = None
        self._check: PortCheck | None = None

    def compose(self) -> ComposeResult:
        yield self.port
        yield self.fields["url"]
        yield self.look
        yield self._pair("model", "serial")
        yield self.cube
        yield self.slab
        yield self.fields["gnss"]
        yield self.heard
        for names in FIELD_PAIRS:
            yield self._pair(*names)

    def _pair(self, *names: str) -> Horizontal:
        return Horizontal(*(self.fields[name] for name in names), classes="pair")

    def offer(self, start: StartView) -> None:
        """Take what the engine offers."""
        self.port.offer(start.ports)
        self.cube.offer(start.cubes)
        self.slab.offer(start.slabs)
        if start.setup != self._filled:
            self._fill(start.setup)
        url = self.texts()["url"]
        self._start = start
        self.show_looks()
        self._take_unit(start.check if start.check and start.check.url == url else None)

    def show_looks(self) -> None:
        """Show what the looks found of the addresses that stand there now."""
        texts, start = self.texts(), self._start
        is_stated = bool(texts["latitude_deg"])
        use = "compared with the stated latitude" if is_stated else "it fills in the empty fields below"
        self.look.show(AddressLook(texts["url"], start.check, start.is_checking))
        self.heard.show(AddressLook(texts["gnss"], start.receiver, start.is_listening, use))
        self.heard.display = bool(texts["gnss"])

    def _fill(self, setup: Setup) -> None:
        self._filled = setup
        for name, text in texts_of(setup).items():
            self.fields[name].input.value = text
        for pick, key in ((self.port, setup.url), (self.cube, setup.cube), (self.slab, setup.slab)):
            pick.choose(key)

    def _take_unit(self, check: PortCheck | None) -> None:
        """Let a device that says its own model and serial number fill in these."""
        if check == self._check:
            return
        self._check = check
        for name in ("model", "serial"):
            field = self.fields[name].input
            if field is not self.app.focused:
                self._fill_unit(name)
            elif not field.value:  # nothing is typed yet: what the device sends is not missing
                field.value = getattr(check, name, "")

    def on_descendant_blur(self, event: DescendantBlur) -> None:
        """Fill in what the device says of a field once nobody types in it: disabled, it would drop the focus."""
        if (name := event.widget.id or "") in ("model", "serial"):
            self._fill_unit(name)

    def _fill_unit(self, name: str) -> None:
        field, sent = self.fields[name].input, getattr(self._check, name, "")
        field.value = sent or field.value
        field.disabled = bool(sent)

    def texts(self) -> dict[str, str]:
        """Return what stands in the fields."""
        return {name: field.input.value.strip() for name, field in self.fields.items()}

    def problems(self) -> dict[str, str]:
        """Return what is wrong, by field."""
        texts = self.texts()
        found = problems(texts)
        if self._check and self._check.is_good:
            silent = [name for name in ("model", "serial") if not texts[name]]
            found |= dict.fromkeys(silent, f"{MISSING} this device does not send it")
        return found

    def setup(self) -> Setup:
        """Return what the form says, without what is wrong in it."""
        texts, wrong = self.texts(), self.problems()
        right = {name: "" if name in wrong else text for name, text in texts.items()}
        chosen = setup_of(right, self._filled or Setup())
        return chosen.model_copy(update={"cube": self.cube.value, "slab": self.slab.value})

    def on_input_changed(self) -> None:
        """Check the fields as one is typed."""
        found = self.problems()
        for field in self.fields.values():
            problem = found.get(field.entry.name, "")
            field.judge("" if problem.startswith(MISSING) else problem)
