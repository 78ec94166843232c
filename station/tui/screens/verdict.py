"""The end of a campaign: the verdict and its numbers, which may be stored; or how it ended without one."""

import os
import webbrowser
from collections.abc import Callable, Iterable
from pathlib import Path

from textual.app import ComposeResult
from textual.binding import Binding
from textual.containers import Horizontal, ScrollableContainer, Vertical
from textual.content import Content
from textual.geometry import Size
from textual.widgets import Static

from station.guide.view import CalibrationView, OperatorCommand, StageName, Verdict, VerdictRow
from station.tui.screens.framed_screen import StageScreen
from station.tui.screens.modals import DiagnosisScreen
from station.tui.widgets.common import ValueWidget

AMBIGUOUS = ("!", "$warning")
VERDICT_LOOKS = {"PASS": ("✓", "$success"), "FAIL": ("✗", "$error"), "NOT_MEASURED": ("?", "$warning")}


class VerdictSentence(ValueWidget[Verdict]):
    """Stands alone at the top."""

    DEFAULT_CSS = """
    VerdictSentence { text-wrap: wrap; height: auto; min-height: 3; padding: 1 2; text-style: bold; }
    VerdictSentence.PASS { background: $success 22%; }
    VerdictSentence.FAIL { background: $error 22%; }
    VerdictSentence.NOT_MEASURED, VerdictSentence.ambiguous { background: $warning 22%; }
    """

    def show(self, value: Verdict | None) -> None:
        """Take another verdict."""
        for word in VERDICT_LOOKS:
            self.set_class(value is not None and value.word == word, word)
        self.set_class(value is not None and _is_ambiguous(value), "ambiguous")
        super().show(value)

    def _drawn(self, verdict: Verdict) -> Content:
        symbol, colour = AMBIGUOUS if _is_ambiguous(verdict) else VERDICT_LOOKS[verdict.word]
        plain = verdict.in_words or verdict.word.replace("_", " ")
        sentence = verdict.sentence.removeprefix(f"{plain}: ")
        return Content.assemble((f" {symbol} {plain} ", f"$background on {colour}"), f"  {sentence}")


def _is_ambiguous(verdict: Verdict) -> bool:
    return bool(verdict.doubt) and verdict.word == "PASS"


TABLE_HEADER = ("parameter", "value", "U (95 %)", "u", "unit", "verdict", "limit", "change")
RIGHT_COLUMNS = (1, 2, 3, 7)  # columns of numbers
STD, VERDICT = TABLE_HEADER.index("u"), TABLE_HEADER.index("verdict")
GAP, INDENT = "  ", "    "


class NumberTable(ValueWidget[tuple[VerdictRow, ...]]):
    """As high as it needs and as wide as there is room; put it where it can be scrolled down."""

    DEFAULT_CSS = "NumberTable { width: 100%; height: auto; padding: 0 2; }"

    def get_content_height(self, container: Size, viewport: Size, width: int) -> int:
        return len(_table(self.value or (), width))

    def _drawn(self, rows: tuple[VerdictRow, ...]) -> Content:
        return Content("\n").join(_table(rows, self.content_size.width))


def _table(rows: tuple[VerdictRow, ...], width: int) -> list[Content]:
    looks = [VERDICT_LOOKS.get(row.verdict, ("", "")) for row in rows]
    cells = [TABLE_HEADER, *(_cells(row, symbol) for row, (symbol, _) in zip(rows, looks, strict=True))]
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    draw = _line if sum(widths) + len(GAP) * (len(widths) - 1) <= width else _stacked
    colours = ["", *(colour for _, colour in looks)]
    return [line for row, colour in zip(cells, colours, strict=True) for line in draw(row, widths, colour, width)]


def _line(cells: tuple[str, ...], widths: list[int], colour: str, _: int) -> list[Content]:
    """Draw a row in one line."""
    if cells is TABLE_HEADER:
        return [_aligned(cells, widths, range(len(TABLE_HEADER))).stylize("bold $muted")]
    before, after = (_aligned(cells, widths, part) for part in (range(VERDICT), range(VERDICT + 1, len(cells))))
    verdict = Content.styled(cells[VERDICT].ljust(widths[VERDICT]), f"bold {colour}")
    return [Content(GAP).join([before, verdict, after])]


def _stacked(cells: tuple[str, ...], widths: list[int], colour: str, width: int) -> list[Content]:
    """Draw the numbers of a row in one line, verdict, limit and change below as far as it has any.

    u is omitted where it does not fit: U is shown.
    """
    numbers = _aligned(cells, widths, range(VERDICT))
    if numbers.cell_length > width:
        numbers = _aligned(cells, widths, [column for column in range(VERDICT) if column != STD])
    if cells is TABLE_HEADER:
        return [numbers.stylize("bold $muted")]
    verdict, limit, change = cells[VERDICT:]
    texts = [
        Content.assemble((verdict, f"bold {colour}"), f"{GAP}limit {limit}") if verdict else Content(""),
        Content(f"change {change}" if change else ""),
    ]
    parts = [part for part in texts if part]
    together = Content(GAP).join(parts)
    below = [together] if len(INDENT) + together.cell_length <= width else parts
    return [numbers, *(Content(INDENT) + line for line in below if line)]


def _aligned(cells: tuple[str, ...], widths: list[int], columns: Iterable[int]) -> Content:
    aligned = (cells[k].rjust(widths[k]) if k in RIGHT_COLUMNS else cells[k].ljust(widths[k]) for k in columns)
    return Content(GAP.join(aligned))


def _cells(row: VerdictRow, symbol: str) -> tuple[str, ...]:
    verdict = f"{symbol} {row.verdict.replace('_', ' ')}".strip()
    return row.name, row.value, row.expanded, row.sigma, row.unit, verdict, row.limit, row.change


FACTS = {  # as they stand below each other: name and look
    "report": "", "stored": "good", "status": "", "residual": "", "change": "", "diagnosis": "",
    "warnings": "warning",
}  # fmt: skip
REPORT = "report"  # where a page finds it: `station.tui.web_server.Guard.report`


class FactLine(Horizontal):
    """A name on the left, the text next to it however long."""

    DEFAULT_CSS = """
    FactLine { height: auto; padding: 0 2; display: none; }
    FactLine.shown { display: block; }
    FactLine .name { width: 11; color: $muted; }
    FactLine .text { width: 1fr; height: auto; }
    FactLine.warning .text { color: $warning; text-style: bold; }
    FactLine.good .text { color: $success; text-style: bold; }
    """

    def __init__(self, name: str, classes: str = "") -> None:
        super().__init__(classes=classes)
        self._label, self._text = name, Static("", classes="text", markup=False)

    def compose(self) -> ComposeResult:
        yield Static(self._label, classes="name", markup=False)
        yield self._text

    def say(self, text: str) -> None:
        """Say something, or nothing."""
        self._text.update(text)
        self.set_class(bool(text), "shown")


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
        values = {
            "stored": seal and f"✓ in the database, sha256 {seal}",
            "status": ": ".join(part for part in (verdict.status, verdict.status_reason) if part),
            "residual": verdict.worst_residual, "change": verdict.change, "diagnosis": verdict.diagnosis,
            "warnings": "\n".join(f"! {warning}" for warning in verdict.warnings),
        }  # fmt: skip
        for name, text in values.items():
            self.facts[name].say(text)
        self.table.show(verdict.rows)

    def _keys_depend_on(self, view: CalibrationView) -> object:
        return view.stage, bool(view.verdict and view.verdict.redo), view.can_do_more

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        if action in ("store", "cancel"):
            return self.view.stage == "verdict"
        if action == "order":
            return self.view.stage == "verdict" and self.view.can_do_more
        if action == "redo":
            return self.view.stage == "verdict" and bool(self.view.verdict and self.view.verdict.redo)
        return True

    def action_store(self) -> None:
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

        That is reported among the facts: it covers nothing there.
        """
        report = self.view.verdict.report if self.view.verdict else ""
        text = report or "no report was written"
        if report and self.app.is_web:
            self.app.open_url(REPORT)
        elif report and not _is_opened(Path(report)):
            text = f"no browser can be opened from here; open this file: {report}"
        self.facts["report"].say(text)
        self.query_one("#scroll").scroll_home(animate=False)

    def action_diagnose(self) -> None:
        self.app.push_screen(DiagnosisScreen(self.view.verdict.diagnosis_text if self.view.verdict else ""))

    def action_roll(self, down: int) -> None:
        scroll = self.query_one("#scroll")
        scroll.scroll_relative(y=down * max(scroll.size.height // 2, 1), animate=False)

    def action_leave(self) -> None:
        if self.view.stage == "stored":
            self.app.exit()
        else:
            super().action_leave()


def _is_opened(report: Path) -> bool:
    """Open a file in a browser; none without a display, as a browser of text would take the terminal."""
    if not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        return False
    return webbrowser.open(report.absolute().as_uri())


SAFE = "All accepted steps are safe; `station resume` continues"
ENDED_LOOKS: dict[StageName, tuple[str, str, str]] = {
    "cancelled": (
        "✗ CANCELLED",
        "$warning",
        "All recordings stay as files in the folder; the database is unchanged.",
    ),
    "left": ("‖ LEFT", "$primary", f"{SAFE} from here."),
    "failed": ("✗ STOPPED", "$error", f"{SAFE} after you correct this."),
}


class EndedScreen(StageScreen):
    """One sentence; any of the usual keys closes."""

    HELPS = {stage: sentence for stage, (_, _, sentence) in ENDED_LOOKS.items()}
    BINDINGS = [
        Binding("enter", "leave", "Close", tooltip="close the program"),
        Binding("escape,space,q,c", "leave", show=False),
    ]
    DEFAULT_CSS = """
    EndedScreen #ended { align: center middle; height: 1fr; }
    EndedScreen Static { width: 100%; max-width: 72; height: auto; }
    """

    def _body(self) -> ComposeResult:
        self.text = Static()
        with Vertical(id="ended"):
            yield self.text

    def _draw(self, view: CalibrationView) -> None:
        word, colour, sentence = ENDED_LOOKS.get(view.stage, ENDED_LOOKS["failed"])
        parts = [Content.styled(f" {word} ", f"bold $background on {colour}"), Content("")]
        if view.stage == "cancelled" and not view.folder:
            sentence = ""  # nothing was started
        parts += [Content(text + "\n") for text in (view.error, view.line, sentence) if text]
        if view.folder:
            parts.append(Content.assemble(("folder  ", "$muted"), view.folder))
        self.text.update(Content("\n").join(parts))

    def action_leave(self) -> None:
        self.app.exit()
