"""Warm-up, then the campaign: one screen whose parts change, so that nothing jumps."""

from collections.abc import Callable

from textual.app import ComposeResult
from textual.binding import Binding
from textual.containers import Horizontal, Vertical
from textual.widgets import ContentSwitcher

from station.guide.campaign.checklist import why_not_solvable
from station.guide.view import CalibrationView, OperatorCommand, StageName
from station.tui.screens.framed_screen import FramedScreen
from station.tui.widgets.common import BannerText
from station.tui.widgets.cube import CubePair, is_counter_clockwise
from station.tui.widgets.step_grid import GridCursor, StepGrid
from station.tui.widgets.step_panels import (
    AcceptedBar,
    GatesPanel,
    LimitsLines,
    MonitoredLines,
    SeatingLines,
    SoakLines,
    StepWords,
    TurnGauge,
    WarmUpPanel,
)

STAGES: tuple[StageName, ...] = ("place", "settle", "dwell", "turn", "paused")
CLOCKWISE, COUNTER_CLOCKWISE = "↻", "↺"
STAGE_LOOKS: dict[StageName, tuple[str, str, str]] = {
    "place": ("NOW", "▶", "$primary"),
    "settle": ("KEEP STILL", "◼", "$warning"),
    "dwell": ("RECORDING", "●", "$success"),
    "turn": ("TURN", CLOCKWISE, "$accent"),
    "paused": ("PAUSED", "‖", "$foreground"),
}
GRID_HELP = (
    "You can use any order: the station recognises the orientation of the cube. Arrow keys and Enter choose a "
    "step."
)


class CampaignScreen(FramedScreen):
    """Where the cube goes, what it does there, and what is done already."""

    HELPS = {
        "place": f"Put the cube on the surface plate as shown, with its North mark to North. In a free position "
        f"it is tilted between faces, far from earlier attitudes. No key is needed. {GRID_HELP}",
        "settle": "The cube is on the correct face. Take your hands off and wait until both checks pass.",
        "dwell": "The station counts the accepted seconds. Do not touch the bench. If it is bumped, only the "
        "affected seconds are discarded.",
        "turn": "Rotate the cube flat on the surface plate in the direction of the arrow. Make whole turns back "
        "to the mark, then take your hands off. The speed may vary between its limits.",
        "paused": f"Nothing is recorded. Press p to continue. {GRID_HELP}",
    }
    BINDINGS = [
        Binding("up", "move(-1, 0)", "Up", show=False),
        Binding("down", "move(1, 0)", "Down", show=False),
        Binding("left", "move(0, -1)", "Left", show=False),
        Binding("right", "move(0, 1)", "Right", show=False),
        Binding("enter", "choose", "Do", tooltip="do the step under the cursor next (arrow keys move it)"),
        Binding("r", "redo", "Redo", tooltip="repeat the step under the cursor, otherwise the last one"),
        Binding("p", "pause", "Pause", tooltip="pause or continue"),
        Binding("b", "back", "Back", tooltip="move the cursor to the step before"),
        Binding("escape", "set_cursor('')", "Home", show=False, tooltip="move the cursor to the requested step"),
        Binding("k", "order('keep_seating')", "Keep", tooltip="accept the current seating of the cube"),
        Binding("f", "finish", "Finish", tooltip="solve with the steps that are done"),
    ]
    DEFAULT_CSS = """
    CampaignScreen #middle { height: 1fr; }
    CampaignScreen #right { width: 1fr; }
    CampaignScreen ContentSwitcher { height: 1fr; min-height: 3; }
    CampaignScreen.-tall StepGrid { padding: 1 0; }
    CampaignScreen.-tall GatesPanel { height: 3; }
    CampaignScreen.-tall AcceptedBar { margin-bottom: 1; }
    CampaignScreen.-tall LimitsLines { height: 4; }
    CampaignScreen.-phone #middle { layout: vertical; }
    CampaignScreen.-phone CubePair { width: 1fr; height: 14; }
    CampaignScreen.-wide CubePair { width: 1fr; }
    CampaignScreen.-wide #right { width: 50; }
    """

    def __init__(self, send: Callable[[OperatorCommand], None]) -> None:
        super().__init__(send)
        self.cube, self.grid, self.gates = CubePair(), StepGrid(), GatesPanel()
        self.seating, self.turn, self.accepted = SeatingLines(id="seating"), TurnGauge(id="turn"), AcceptedBar()
        self.limits = LimitsLines()
        self.soak, self.words = SoakLines(id="soak"), StepWords(id="words")
        self.monitored = MonitoredLines(id="monitored")
        self.lower = ContentSwitcher(
            self.seating, self.turn, self.soak, self.monitored, self.words, initial="seating"
        )
        self._cursor = ""  # empty: on the step wanted

    def _inner(self) -> ComposeResult:
        with Horizontal(id="middle"):
            yield self.cube
            with Vertical(id="right"):
                yield self.grid
                yield self.gates
                yield self.lower
        yield self.accepted
        yield self.limits

    def _now(self, view: CalibrationView) -> BannerText:
        word, symbol, colour = STAGE_LOOKS.get(view.stage, STAGE_LOOKS["place"])
        if view.stage in ("place", "settle") and _is_badly_seated(view):
            word, symbol, colour = "SET DOWN AGAIN", "▲", "$error"
        elif view.turn is not None and view.turn.is_to_rest:
            word, symbol, colour = STAGE_LOOKS["settle"]
        elif (step := view.step(view.live)) is not None and step.axis and view.stage == "turn":
            symbol = COUNTER_CLOCKWISE if is_counter_clockwise(step) else CLOCKWISE
        return BannerText(word, symbol, colour, view.line, view.hint)

    def _draw(self, view: CalibrationView) -> None:
        super()._draw(view)
        self.cube.show((view.step(view.live or view.wanted), view.pose))
        self.grid.show(self._grid())
        self.gates.show(view.gates)
        self.seating.show(view.gates)
        self.turn.show(view.turn)
        self.soak.show(view.soak)
        self.monitored.show(view.monitored)
        self._show_lower(view)
        self.accepted.show((view.accepted_s, view.wanted_s))
        self.limits.display = bool(view.limits)
        self.limits.show((view.limits, view.remaining_s) if view.limits else None)

    def _keys_depend_on(self, view: CalibrationView) -> object:
        return view.stage == "paused", view.done > 0, bool(view.can_redo), _is_badly_seated(view)

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        if action == "order":
            return _is_badly_seated(self.view)
        if action in ("redo", "finish"):
            return self.view.done > 0
        return True

    def action_move(self, down: int, right: int) -> None:
        self.action_set_cursor(self._grid().neighbour(down, right))

    def action_back(self) -> None:
        self.action_set_cursor(self._grid().before())

    def action_choose(self) -> None:
        if step := self._grid().cursor:
            self.action_order("choose", step=step)
            self.action_set_cursor("")

    def action_redo(self) -> None:
        """Do the step under the cursor again if it is done, else the one that can be."""
        step = self.view.step(self._grid().cursor)
        self.action_order("redo", step=step.name if step and step.attempts else self.view.can_redo)
        self.action_set_cursor("")

    def action_pause(self) -> None:
        self.action_order("go_on" if self.view.stage == "paused" else "pause")

    def action_finish(self) -> None:
        """Ask, then solve with the steps that are done; not where that surely cannot be."""
        if lack := why_not_solvable(self.view.steps):
            self.notify(lack, title="Not yet", severity="warning", markup=False)
            return
        missing = len(self.view.steps) - self.view.done
        text = (
            f"{self.view.done} of {len(self.view.steps)} steps are done. What the {missing} missing ones would "
            "determine is left out of the result, and it says so."
        )
        self.confirm("Finish with the steps that are done?", text, "Yes, finish", "finish", *STAGES)

    def _show_lower(self, view: CalibrationView) -> None:
        """Show the words of the step under the cursor while it was moved there, else what is measured."""
        is_moved = self._cursor not in {"", view.live or view.wanted}
        self.words.show(view.step(self._cursor))
        measured = "turn" if view.turn else "soak" if view.soak else "monitored" if view.monitored else "seating"
        self.lower.current = "words" if is_moved else measured

    def _grid(self) -> GridCursor:
        return GridCursor(self.view.steps, self.view.wanted, self._cursor or self.view.live or self.view.wanted)

    def action_set_cursor(self, name: str) -> None:
        """Move the cursor to a step; empty: to the step wanted, and leave it there."""
        self._cursor = name
        self.grid.show(self._grid())
        self._show_lower(self.view)


def _is_badly_seated(view: CalibrationView) -> bool:
    return view.gates is not None and not view.gates.is_seated


class WarmUpScreen(FramedScreen):
    """Shows how far the unit has settled."""

    HELPS = {
        "warm_up": "The IMU warms up. Leave the cube at rest on the surface plate. The positions start "
        "automatically when temperature rate and gyro drift are below limits that the station "
        "determines for this unit. If you skip the warm-up, this is recorded and uncertainties increase."
    }
    BINDINGS = [
        Binding("s", "skip", "Skip warm-up", tooltip="begin now; this is recorded, and uncertainties increase")
    ]

    def _inner(self) -> ComposeResult:
        self.panel = WarmUpPanel()
        yield self.panel

    def _now(self, view: CalibrationView) -> BannerText:
        return BannerText("WARM-UP", "◷", "$primary", view.line, view.hint)

    def _draw(self, view: CalibrationView) -> None:
        super()._draw(view)
        self.panel.show(view.warm_up)

    def action_skip(self) -> None:
        text = "This is recorded, and the uncertainties increase."
        self.confirm("Skip the warm-up?", text, "Yes, skip it", "skip_warm_up", "warm_up")
