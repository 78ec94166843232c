"""The set-up of a new campaign: port, unit, cube, slab, site, operator, how long and how many."""

from textual.app import ComposeResult
from textual.containers import Horizontal, VerticalScroll
from textual.events import DescendantBlur
from textual.widgets import Static

from station.files.campaign_setup import Setup
from station.guide.setup_view import PortCheck, StartView
from station.tui.setup_entries import ENTRIES, problems, setup_of, texts_of
from station.tui.widgets.probe_lines import AddressLook, LookLine
from station.tui.widgets.setup_fields import PickList, SetupField

FIELD_PAIRS = (
    ("latitude_deg", "longitude_deg"),
    ("height_m", "operator"),
    ("gravity_m_s2", "gravity_std_m_s2"),
    ("dwell_s", "bias_ug"),
    ("revolutions", "repeats"),
)
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
        """Lay out a line for each thing, or two things that belong together."""
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
        return Horizontal(*(self.fields[name] if name else Static() for name in names), classes="pair")

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
        use = "compared with the stated latitude"
        if not texts["latitude_deg"]:
            use = "it fills in the empty fields below"
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
        field, said = self.fields[name].input, getattr(self._check, name, "")
        field.value = said or field.value
        field.disabled = bool(said)

    def texts(self) -> dict[str, str]:
        """Return what stands in the fields."""
        return {name: field.input.value.strip() for name, field in self.fields.items()}

    def problems(self) -> dict[str, str]:
        """Return what is wrong, by field."""
        texts = self.texts()
        found = problems(texts)
        if self._check and self._check.is_good:
            silent = [name for name in ("model", "serial") if not texts[name]]
            found |= dict.fromkeys(silent, "is required: this device does not send it")
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
            field.judge("" if problem.startswith("is needed") else problem)
