"""The guided campaign: a stage at a time, driven by the stream's seconds and the operator's commands.

Nothing here waits or reads a clock: equal seconds and commands give an equal campaign. The face is recognised
from raw counts and any order is accepted; errors are reported and have no further consequence.
"""

from dataclasses import replace
from typing import Any

import numpy as np

from drivers.errors import DeadChannel, DriverError, WrongFormat
from procedures.arrays import FloatArray
from procedures.campaign.plan_steps import Step
from procedures.free_positions.free_attitudes import MIN_APART_DEG, nearest_deg
from station.files.campaign_folder.plan_file import UnitRecord
from station.guide.checks.cube_pose import HeadingWatch, face_wanted, pose_view
from station.guide.checks.cube_tracking import CubeTracker, FastMoveWatch
from station.guide.checks.face_and_stillness import BlockLook
from station.guide.checks.seating import keep_question
from station.guide.stages.dwell_stage import DwellStage, FreeAttitudeStage
from station.guide.stages.placement_stage import PlacementStage
from station.guide.stages.stage import QuestionStage, Stage
from station.guide.stages.stage_context import StageContext
from station.guide.stages.turn_stage import TurnStage
from station.guide.stages.unit_recognition_stage import UnitRecognitionStage
from station.guide.stages.warm_up_stage import WarmUpStage
from station.guide.view import CalibrationView, GatesView, LimitView, LinkView, OperatorCommand, PoseView
from station.guide.wording import step_title
from station.stream.connected_unit import UnitChanged
from station.stream.live.stillness import STILL_NOISE_RATIO, Block

KEPT_BLOCKS = 8  # of the past, in addition to those of the step
TROUBLES = (  # with the stream: two words that stand in the place of what is live, and the one thing to do
    (UnitChanged, "WRONG UNIT", "connect the campaign's own unit"),
    (WrongFormat, "NOT READABLE", "check format and baud rate"),
    (DeadChannel, "DEAD CHANNEL", "check its wiring and supply"),
    (DriverError, "NO DATA", "check cable and power"),
)


class Guide:
    """Takes a campaign through its checklist.

    ``warms_up``: not before the unit has settled; ``unsure`` is the unit that it should be, where the wire does
    not say.
    """

    def __init__(self, context: StageContext, *, warms_up: bool, unsure: UnitRecord | None = None) -> None:
        self.context = context
        first = self._first = _warming if warms_up else _placement
        self._restarts = context.feed.restarts
        self._now: Stage = first(context) if unsure is None else UnitRecognitionStage(context, unsure, first)
        self._look: BlockLook | None = None
        self._accel: FloatArray = np.zeros(3)
        self._tracker = CubeTracker(context)
        self._heading = HeadingWatch(context, self._tracker)
        self._fast_moves = FastMoveWatch(context)
        self._is_paused = False
        self.trouble = ""  # with the stream, in words ...
        self._trouble_word = self._remedy = ""  # ... in two words, and what is to be done
        self._time_s: float | None = None  # the device's, up to which the stream was looked at

    @property
    def _stage(self) -> Stage:
        """What goes on now."""
        return self._now

    @_stage.setter
    def _stage(self, stage: Stage) -> None:
        if stage is not self._now and self._is_recording:
            self.context.event_log.ended()
        self._now = stage

    @property
    def is_complete(self) -> bool:
        """Whether nothing is left to do."""
        return self.context.checklist.wanted is None and not self._is_recording

    def take(self, block: Block) -> None:
        """Take a second of the stream."""
        context = self.context
        context.gate.stillness.learn(block)
        self._accel = block.rate[3:]
        self._time_s = block.ends if context.feed.gives_time else None
        look = self._look = context.look = context.gate.look(block)
        self._tracker.take(block, look)
        if block.is_restarted:
            self._stage = self._stage.interrupted()
            self._look_for_restart()
        elif self._is_paused:
            look = replace(look, is_still=False, is_calm=False, hindrance="paused")
        self._fast_moves.take(block, look)
        self._stage = self._stage.take(block, look)
        self._heading.take(look, self._step if self._may_stand_wrong else None)
        past = block.first - KEPT_BLOCKS * (block.last - block.first)
        needed = self._stage.oldest
        context.chain.look(context.feed.buffer, block.last if needed is None else needed, context.feed.period)
        oldest = [each for each in (needed, context.chain.oldest) if each is not None]
        context.feed.buffer.forget_before(min([past, *oldest]))

    def show_newest(self, block: Block | None) -> None:
        """Take the newest second for show only."""
        if block is not None:
            self._look, self._accel = self.context.gate.look(block), block.rate[3:]
        self._tracker.show_newest()

    def stream_failed(self, error: DriverError) -> None:
        """Take what is wrong with the stream; a dwell or turn under way is not accepted."""
        if not self.trouble:
            self.trouble = str(error)
            self._trouble_word, self._remedy = trouble_of(error)
            self.context.event_log.say("rejected", self.trouble)
            self._stage = self._stage.interrupted()

    def stream_is_back(self) -> None:
        """Take it that the stream goes on."""
        if self.trouble:
            self.trouble = ""
            if not self._look_for_restart():
                self.context.event_log.say("", "data arrive again")

    def _look_for_restart(self) -> bool:
        """Say so if the unit was switched off and on: it warms up again, and its biases are others."""
        if (restarts := self.context.feed.restarts) == self._restarts:
            return False
        self._restarts = restarts
        self.context.power_cycled("; it must warm up again" if self._first is _warming else "")
        if not isinstance(self._stage, UnitRecognitionStage):
            self._stage = self._first(self.context)
        return True

    def execute(self, command: OperatorCommand) -> None:
        """Execute a command; one that does not fit the moment is reported and changes nothing."""
        verb, stage = command.verb, self._stage
        if verb == "choose":
            self._choose(command.step)
        elif verb == "redo":
            self._redo(command.step or self.context.checklist.latest)
        elif verb in ("pause", "go_on"):
            self._set_paused(verb == "pause")
        elif verb == "answer":
            stage.answer(command.key)
        elif verb == "keep_seating" and self.context.off_seat:
            self._keep_seating(self.context.off_seat)
        elif verb == "more":
            self._do_more()
        elif verb == "skip_warm_up" and isinstance(stage, WarmUpStage):
            self._stage = stage.skipped()

    def view(self, base: CalibrationView) -> CalibrationView:
        """Return ``base`` with everything filled in that the guide knows."""
        context = self.context
        shown = {"hint": "", "live": ""} | self._stage.shown()
        gates = shown.pop("gates", {})
        if self._heading.text:
            shown["hint"] = self._heading.text
        if self._is_paused:
            shown |= {"stage": "paused", "line": "paused: nothing is recorded", "hint": "p goes on"}
        if self.trouble:
            shown |= {"line": self._remedy, "hint": self.trouble}
        checklist, wanted = context.checklist, context.checklist.wanted
        shown |= {
            "steps": checklist.views(shown["live"]), "wanted": wanted.name if wanted else "",
            "can_redo": checklist.latest, "can_do_more": context.planner is not None and wanted is None,
            "remaining_s": max(checklist.remaining_s() - shown.get("accepted_s", 0.0), 0.0),
            "gates": None if self.trouble else self._gates(gates),
            "pose": None if self.trouble else self._pose(), "link": self._link(), "limits": self._limits(shown),
            "events": context.event_log.events, "time_s": self._time_s,
        }  # fmt: skip
        return base.model_copy(update=shown)

    @property
    def _may_stand_wrong(self) -> bool:
        """Whether nothing has found yet that the cube stands in a position."""
        stage = self._stage
        return isinstance(stage, PlacementStage) or (isinstance(stage, DwellStage) and not stage.is_known)

    @property
    def _is_recording(self) -> bool:
        return isinstance(self._stage, DwellStage | TurnStage | FreeAttitudeStage)

    def _gates(self, known: dict[str, object]) -> GatesView | None:
        """Return both gates, with what the stage says of them."""
        if (look := self._look) is None or (isinstance(self._stage, TurnStage) and self._stage.is_moving):
            return None
        limit = STILL_NOISE_RATIO**0.5
        gates = GatesView(
            face=look.face, off_deg=look.off_deg, limit_deg=self.context.gate.limit_deg,
            is_right_face=look.is_upright and self.context.checklist.has_work(look.face),
            is_wanted_face=face_wanted(self._step) in {"", look.face},
            still=look.still * limit, still_limit=limit, still_channel=look.channel, is_still=look.is_still,
            position=self.context.position,
        )  # fmt: skip
        if known.get("is_free"):
            apart = nearest_deg(self.context.gate.way_up(self._accel), self.context.tilts_taken())
            is_apart = min(look.off_deg, apart) >= MIN_APART_DEG
            known = known | {"is_right_face": is_apart, "limit_deg": MIN_APART_DEG}
        return gates.model_copy(update=known)

    def _limits(self, shown: dict[str, Any]) -> tuple[LimitView, ...]:
        """Return how far each sigma is that is wanted or limited, with the dwell under way."""
        context = self.context
        if context.targets is None:
            return ()
        live = context.checklist.step(shown["live"])
        return context.targets.limits(live, shown.get("accepted_s", 0.0), is_carried=context.is_carried)

    @property
    def _step(self) -> Step | None:
        """The step that is being recorded, else the one wanted."""
        live = self._stage.shown().get("live", "")
        return self.context.checklist.step(live) or self.context.checklist.wanted

    def _pose(self) -> PoseView | None:
        pose = pose_view(self._tracker, self.context, self._step)
        is_turning = isinstance(self._stage, TurnStage) and self._stage.is_moving
        return pose.model_copy(update={"text": "", "turn_deg": None}) if pose and is_turning else pose

    def _link(self) -> LinkView:
        feed = self.context.feed
        counters, stream = feed.stream.decoder.counters, feed.stream.counters
        return LinkView(
            name=feed.address.name, rate_hz=1 / feed.period,
            bad_frames=counters.bad_crc + counters.bad_length, lost=stream.lost,
            gaps=stream.breaks + stream.restarts, temperature_c=feed.temperature_c,
            is_live=not self.trouble, word=self._trouble_word if self.trouble else "",
            text=self.trouble or feed.trouble or feed.silent,
        )  # fmt: skip

    def _choose(self, name: str) -> None:
        if self.context.checklist.choose(name):
            self._look_again()
        else:
            step = self.context.checklist.step(name)
            what = f"{step_title(step)} is done already: r repeats it" if step else "there is no such step"
            self.context.event_log.say("", what)

    def _do_more(self) -> None:
        """Ask for one placement more of a campaign whose plan is not fixed."""
        if self.context.planner is None or self.context.checklist.open_steps:
            return
        self.context.replan(goes_on=True)
        self._look_again()

    def _redo(self, name: str) -> None:
        step = self.context.checklist.step(name)
        if step is None or not self.context.checklist.redo(name):
            self.context.event_log.say("", "nothing to repeat yet")
            return
        until = "will be recorded again; the earlier recording is used until then"
        self.context.event_log.say("", f"{step_title(step)} {until}")
        self._look_again()

    def _look_again(self) -> None:
        """Let what is wanted now decide, unless something else is being recorded."""
        if isinstance(self._stage, PlacementStage):
            self._stage = _placement(self.context)

    def _set_paused(self, is_paused: bool) -> None:
        if is_paused == self._is_paused:
            return
        self._is_paused = is_paused
        if is_paused and isinstance(self._stage, TurnStage):
            self._stage = PlacementStage(self.context, must_move=False)
        self.context.event_log.say("", "paused" if is_paused else "going on")

    def _keep_seating(self, position: int) -> None:
        if (question := keep_question(self.context)) is None:
            self._stage = self._kept(position)
        else:
            then = {"y": lambda: self._kept(position), "n": self._set_down_again}
            self._stage = QuestionStage(self.context, question, then)

    def _kept(self, position: int) -> Stage:
        context = self.context
        context.kept_seats[position] = context.seats[position]
        context.off_seat = 0
        return PlacementStage(context, must_move=False)

    def _set_down_again(self) -> Stage:
        return PlacementStage(self.context, must_move=bool(self.context.off_seat), why="lift, wipe, set down")


def trouble_of(error: DriverError) -> tuple[str, str]:
    """Return what an error of the stream is to the operator: in two words, and what to do."""
    word, remedy = next((word, remedy) for kind, word, remedy in TROUBLES if isinstance(error, kind))
    return word, f"{remedy}; it then continues by itself"


def _warming(context: StageContext) -> Stage:
    return WarmUpStage(context, _placement)


def _placement(context: StageContext) -> Stage:
    return PlacementStage(context, must_move=bool(context.position))
