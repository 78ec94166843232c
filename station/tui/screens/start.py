"""Set-up: resume an unfinished campaign, or begin a new one."""

from collections.abc import Callable, Mapping

from textual.app import ComposeResult
from textual.binding import Binding
from textual.containers import Horizontal
from textual.content import Content
from textual.events import DescendantBlur
from textual.widgets import Button, Input, OptionList, Select, Static
from textual.widgets.option_list import Option

from station.files.campaign_setup import Setup
from station.guide.setup_view import StartView, UnfinishedCampaign
from station.guide.view import CalibrationView, CommandVerb, OperatorCommand
from station.tui.screens.framed_screen import StageScreen
from station.tui.screens.modals import ReadyLines, ReadyScreen
from station.tui.widgets.common import duration_in_words
from station.tui.widgets.setup_entries import MISSING, seconds_needed
from station.tui.widgets.setup_form import SetupForm, SetupInput

START_HELP = (
    "Press Enter to resume an unfinished campaign, or fill in the form and begin. Tab and shift+Tab go from field "
    "to field, Enter opens a list. The station checks a port for two seconds when you choose it. Dwell 0: the "
    "dwell time follows from the unit's noise and the bias uncertainty that you want. A GNSS receiver gives the "
    "time, and the position if latitude is empty. The form is remembered."
)
CONSIDER_S = 0.2  # after the last letter
LOOK_VERBS: dict[str, CommandVerb] = {"url": "check", "gnss": "listen"}  # what looks at the address in a field
STATES = {"free": "▶ resume: Enter", "in use": "✗ in use elsewhere", "not here": "✗ its folder is not here"}


class UnfinishedList(OptionList):
    """A line each; those that cannot be resumed are shown and cannot be chosen."""

    DEFAULT_CSS = """
    UnfinishedList { height: auto; max-height: 3; margin: 0 2; border: none; }
    UnfinishedList:focus { border: none; }
    """

    def __init__(self) -> None:
        super().__init__(compact=True, id="unfinished", markup=False)
        self.campaigns: tuple[UnfinishedCampaign, ...] = ()

    def offer(self, campaigns: tuple[UnfinishedCampaign, ...]) -> None:
        """Offer other campaigns."""
        if campaigns == self.campaigns:
            return
        self.campaigns = campaigns
        self.display = bool(campaigns)
        lines = ((Content(f"{c.title:50} {STATES[c.state]}"), c.state != "free") for c in campaigns)
        self.set_options(Option(line, disabled=is_disabled) for line, is_disabled in lines)
        self.highlighted = next((i for i, c in enumerate(campaigns) if c.state == "free"), None)

    @property
    def is_of_use(self) -> bool:
        """Whether there is one to resume."""
        return any(campaign.state == "free" for campaign in self.campaigns)


class StartScreen(StageScreen):
    """The campaigns to resume above, the form below, how long it takes at the bottom."""

    HELPS = {"start": START_HELP}
    BINDINGS = [
        Binding("ctrl+s", "begin", "Begin", tooltip="begin a new campaign with this form"),
        Binding(
            "ctrl+r", "ready", "Ready?", tooltip="what is ready, what is missing, and which verdict is possible"
        ),
        Binding("ctrl+l", "look", "Check port", tooltip="check the port and the receiver"),
        Binding("q,ctrl+q", "leave", "Quit", tooltip="close; nothing was started"),
        Binding("c,escape", "cancel", "Cancel", tooltip="cancel; nothing was recorded"),
        Binding("tab", "app.focus_next", show=False, priority=True),  # at once: what is typed next goes there
        Binding("shift+tab", "app.focus_previous", show=False, priority=True),
        Binding("question_mark", "help", show=False, priority=True),  # before an empty field takes it as text
        Binding("f1", "help", "Help", tooltip="help for this screen, and all keys"),
    ]
    DEFAULT_CSS = """
    StartScreen .heading { height: 1; padding: 0 2; color: $accent; text-style: bold; }
    StartScreen.-tall .heading { height: 3; padding: 1 2; }
    StartScreen #message { height: auto; max-height: 4; padding: 0 2; color: $error; text-style: bold; }
    StartScreen #bottom { height: 1; padding: 0 2; }
    StartScreen #time { width: 1fr; text-wrap: nowrap; }
    StartScreen.-phone SetupForm .pair { height: 2; layout: vertical; }
    StartScreen.-phone SetupForm .pair > * { width: 100%; }
    StartScreen.-phone .note { width: 1fr; }
    StartScreen.-phone LookLine { width: 1fr; }
    StartScreen.-phone LookLine#receiver { max-height: 5; }
    StartScreen.-phone ReadyLines { height: auto; max-height: 4; text-wrap: wrap; }
    StartScreen.-phone #bottom { height: 3; layout: vertical; }
    StartScreen.-phone #time { width: 100%; height: 2; text-wrap: wrap; }
    """

    def __init__(self, send: Callable[[OperatorCommand], None]) -> None:
        super().__init__(send)
        self.unfinished, self.form = UnfinishedList(), SetupForm()
        self.heading = Static("RESUME a campaign", classes="heading")
        self.message, self.time = Static("", id="message", markup=False), Static("", id="time", markup=False)
        self.ready = ReadyLines()
        self._considered: Setup | None = None  # the set-up sent last to the engine
        self._waits = False  # to send it
        self._typed = ""  # what is wrong in the field typed in last
        self._refused = ""
        self._looked = dict[str, str]()  # the addresses looked at last, by field

    def _body(self) -> ComposeResult:
        yield self.heading
        yield self.unfinished
        yield Static("NEW campaign", classes="heading")
        yield self.form
        yield self.message
        yield self.ready
        with Horizontal(id="bottom"):
            yield self.time
            yield Button("Begin  ctrl+s", action="screen.begin", variant="success", compact=True)

    def on_mount(self) -> None:
        """Begin where most will go on: a list without a port has nothing to choose."""
        self.unfinished.display = False
        super().on_mount()
        form = self.form
        first = form.fields["url"].input if form.port.select.disabled else form.port.select
        (self.unfinished if self.unfinished.is_of_use else first).focus()

    def _draw(self, view: CalibrationView) -> None:
        start = view.start or StartView()
        self.unfinished.offer(start.unfinished)
        self.heading.display = bool(start.unfinished)
        self.form.offer(start)
        self._refused = start.refused
        self.ready.show(start.readiness)
        self._say()

    def _say(self) -> None:
        text = self._typed or self._refused
        self.message.update(f"✗ {text}" if text else "")
        self.message.display = bool(text)
        self.ready.display = self.ready.value is not None and not text  # a form that is refused is not ready
        self.time.update(self._how_long())

    def _how_long(self) -> str:
        if self.view.remaining_s:
            return f"It takes about {duration_in_words(self.view.remaining_s)}."
        if (self.view.start or StartView()).is_planned_on_the_way:
            return "The duration depends on the targets: the plan is made during the campaign."
        if self.form.problems().keys() & {"dwell_s", "repeats"}:
            return ""
        texts = self.form.texts()
        dwell_s, dwells = float(texts["dwell_s"]), 12 + int(texts["repeats"])
        if not dwell_s:
            return "The duration depends on the unit's noise, measured after warm-up."
        time = duration_in_words(seconds_needed(dwell_s, dwells))
        return f"It takes about {time}: {dwells} dwells of {dwell_s:g} s, 6 rotations."

    def on_input_changed(self, event: Input.Changed) -> None:
        """Say what is wrong with what was typed."""
        self._changed(event.input.id or "")

    def on_select_changed(self, event: Select.Changed) -> None:
        """Take a choice; a port is looked at."""
        form = self.form
        for pick in (form.cube, form.slab):
            pick.explain()
        if event.select is form.port.select and form.port.value not in {"", form.texts()["url"]}:
            form.fields["url"].input.value = form.port.value
            self._look("url")
        self._changed("")

    def _changed(self, name: str) -> None:
        problem = self.form.problems().get(name, "")
        self._typed = "" if problem.startswith(MISSING) else self._named(name, problem)
        self.form.show_looks()
        self._say()
        if not self._waits:
            self._waits = True
            self.set_timer(CONSIDER_S, self._consider)

    def _consider(self) -> None:
        """Send the form to the engine, which answers how ready it is."""
        self._waits = False
        if (setup := self.form.setup()) != self._considered:
            self._considered = setup
            self._send(OperatorCommand(verb="consider", setup=setup))

    def _all_named(self, found: Mapping[str, str]) -> str:
        """Say what is wrong; of several that are missing only the labels."""
        missing = [name for name, problem in found.items() if problem.startswith(MISSING)]
        labels = [self.form.fields[name].entry.label for name in missing]
        phrases = [f"{', '.join(labels[:-1])} and {labels[-1]} are required"] if len(missing) > 1 else []
        phrases += [
            self._named(name, problem) for name, problem in found.items() if not phrases or name not in missing
        ]
        return "; ".join(phrases)

    def _named(self, name: str, problem: str) -> str:
        return f"{self.form.fields[name].entry.label} {problem}" if problem else ""

    def on_setup_input_taken(self, event: SetupInput.Taken) -> None:
        """Look at port or receiver once its address is entered."""
        if event.name in LOOK_VERBS:
            self._look(event.name)

    def on_descendant_blur(self, event: DescendantBlur) -> None:
        """Look at an address when its field is left with another one in it than was looked at last."""
        name = event.widget.id or ""
        if name in LOOK_VERBS and self.form.texts()[name] != self._looked.get(name, ""):
            self._look(name)

    def on_option_list_option_selected(self, event: OptionList.OptionSelected) -> None:
        """Resume a campaign, at the port that was looked at if that may be its unit's."""
        campaign, check = self.unfinished.campaigns[event.option_index], (self.view.start or StartView()).check
        is_its = check is not None and check.is_good and check.serial in {"", campaign.serial}
        url = self.form.texts()["url"]
        url = url if is_its and check and check.url == url else ""
        self.action_order("resume", folder=campaign.folder, url=url)

    def action_look(self) -> None:
        for name in LOOK_VERBS:
            self._look(name)

    def _look(self, name: str) -> None:
        url = self._looked[name] = self.form.texts()[name]
        if url and not self.form.fields[name].entry.check(url):
            self.action_order(LOOK_VERBS[name], url=url)

    def action_begin(self) -> None:
        """Begin, or say all that is missing or wrong and go to the first of it."""
        found = self.form.problems()
        for name, problem in found.items():
            self.form.fields[name].judge(problem)
        self._typed = self._all_named(found)
        self._say()
        if found:
            self.form.fields[next(iter(found))].input.focus()
            return
        ready = (self.view.start or StartView()).readiness
        if ready is not None and (ready.can_pass is False or not ready.can_certify):
            self.app.push_screen(ReadyScreen(ready, asks=True), self._begin)
        else:
            self._begin(True)

    def _begin(self, is_wanted: bool | None) -> None:
        if is_wanted:
            self._send(OperatorCommand(verb="begin", setup=self.form.setup()))

    def action_ready(self) -> None:
        if (ready := (self.view.start or StartView()).readiness) is not None:
            self.app.push_screen(ReadyScreen(ready, asks=False))

    def action_cancel(self) -> None:
        text = "Nothing was started or recorded. The database is unchanged."
        self.confirm("Give up?", text, "Yes, cancel", "cancel", "start")

    def action_leave(self) -> None:
        self.app.exit()
