"""The end of a campaign: the verdict in a sentence, then the numbers; storing them is the operator's act."""

import os
import webbrowser
from collections.abc import Callable
from pathlib import Path

from textual.app import ComposeResult
from textual.binding import Binding
from textual.containers import Horizontal, ScrollableContainer, Vertical
from textual.widgets import Static

from station.guide.view import CalibrationView, OperatorCommand
from station.tui.screens.diagnosis import DiagnosisScreen
from station.tui.screens.stage import StageScreen
from station.tui.widgets.number_table import NumberTable
from station.tui.widgets.verdict_sentence import VerdictSentence

FACTS = {  # as they stand below each other: name and look
    "report": "", "stored": "good", "status": "", "residual": "", "change": "", "diagnosis": "",
    "warnings": "warning",
}  # fmt: skip
REPORT = "report"  # where a page finds it: `station.tui.web.guard.Guard.report`


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


class VerdictScreen(StageScreen):
    """Shown while nothing is stored yet, and after."""

    HELPS = {
        "verdict": "The result is not stored yet. If you agree with it, press s to store it permanently. The "
        "report, the solution and all recordings stay in the folder in any case.",
        "stored": "The calibration is in the database, protected by its hash. `station verify` detects a change.",
    }
    BINDINGS = [
        Binding("s", "store", "Store", tooltip="store the calibration in the database"),
        Binding("r", "redo", "Redo", tooltip="repeat the position with a wrong heading or tilt"),
        Binding("g", "order('more')", "Go on", tooltip="one more placement, although all targets are met"),
        Binding("o", "open_report", "Open report", tooltip="show the report in a browser"),
        Binding("d", "diagnose", "Diagnose", tooltip="diagnosis: error terms that the model lacks"),
        Binding("down,pagedown", "roll(1)", "More", key_display="↑↓", tooltip="scroll the facts and the numbers"),
        Binding("up,pageup", "roll(-1)", "More", show=False),
    ]
    DEFAULT_CSS = """
    VerdictScreen #facts { height: auto; margin-bottom: 1; }
    VerdictScreen #scroll { height: 1fr; scrollbar-size: 1 1; }
    """

    def __init__(self, send: Callable[[OperatorCommand], None]) -> None:
        super().__init__(send)
        self.sentence, self.table = VerdictSentence(), NumberTable()
        self.facts = {name: FactLine(name, look) for name, look in FACTS.items()}

    def _body(self) -> ComposeResult:
        yield self.sentence
        with ScrollableContainer(id="scroll", can_focus=False):
            with Vertical(id="facts"):
                yield from self.facts.values()
            yield self.table

    def _draw(self, view: CalibrationView) -> None:
        if (verdict := view.verdict) is None:
            return
        self.sentence.show(verdict)
        seal = verdict.stored_sha256[:16]
        said = {
            "stored": seal and f"✓ in the database, sha256 {seal}",
            "status": ": ".join(part for part in (verdict.status, verdict.status_reason) if part),
            "residual": verdict.worst_residual, "change": verdict.change, "diagnosis": verdict.diagnosis,
            "warnings": "\n".join(f"! {warning}" for warning in verdict.warnings),
        }  # fmt: skip
        for name, text in said.items():
            self.facts[name].say(text)
        self.table.show(verdict.rows)

    def _keys_depend_on(self, view: CalibrationView) -> object:
        return view.stage, bool(view.verdict and view.verdict.redo), view.can_do_more

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        """Offer only what makes sense now."""
        if action in ("store", "cancel"):
            return self.view.stage == "verdict"
        if action == "order":
            return self.view.stage == "verdict" and self.view.can_do_more
        if action == "redo":
            return self.view.stage == "verdict" and bool(self.view.verdict and self.view.verdict.redo)
        return True

    def action_store(self) -> None:
        """Ask, then store."""
        text = "The calibration becomes part of the unit's history. It cannot be changed or removed."
        if self.view.verdict is not None and self.view.verdict.doubt:
            text = f"! {self.view.verdict.doubt}.\n\n{text}"
        self.confirm("Store the calibration?", text, "Yes, store it", "store", "verdict")

    def action_redo(self) -> None:
        """Record the step again that the verdict names; the verdict is then computed again."""
        if self.view.verdict is not None:
            self.action_order("redo", step=self.view.verdict.redo)

    def action_open_report(self) -> None:
        """Open the report: in the browser that shows this screen, else in one of this machine; say where it is.

        That is said among the facts: it covers nothing there.
        """
        report = self.view.verdict.report if self.view.verdict else ""
        said = report or "no report was written"
        if report and self.app.is_web:
            self.app.open_url(REPORT)
        elif report and not _is_opened(Path(report)):
            said = f"no browser can be opened from here; open this file: {report}"
        self.facts["report"].say(said)
        self.query_one("#scroll").scroll_home(animate=False)

    def action_diagnose(self) -> None:
        """Show all of the diagnosis."""
        self.app.push_screen(DiagnosisScreen(self.view.verdict.diagnosis_text if self.view.verdict else ""))

    def action_roll(self, down: int) -> None:
        """Scroll by half of what is in sight."""
        scroll = self.query_one("#scroll")
        scroll.scroll_relative(y=down * max(scroll.size.height // 2, 1), animate=False)

    def action_leave(self) -> None:
        """Leave; once all is stored there is nothing to resume."""
        if self.view.stage == "stored":
            self.app.exit()
        else:
            super().action_leave()


def _is_opened(report: Path) -> bool:
    """Open a file in a browser; none without a display, as a browser of text would take the terminal."""
    if not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        return False
    return webbrowser.open(report.absolute().as_uri())
