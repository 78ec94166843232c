"""The guided campaign: a stage at a time, driven by the stream's seconds and the operator's commands.

Nothing here waits or reads a clock: equal seconds and commands give an equal campaign. The face is recognised
from raw counts and any order is taken; what is wrong is said and never counted against anybody.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from drivers.errors import DriverError
from procedures.arrays import FloatArray
from procedures.campaign.plan_steps import Step
from procedures.rests_and_moves.free_attitudes import APART_DEG, nearest_deg
from station.files.campaign_folder.notes import UnitRecord
from station.guide.command import Command
from station.guide.cube_pose import HeadingWatch, face_wanted, pose_view
from station.guide.cube_tracking import Tracker
from station.guide.dwell_stage import Resting
from station.guide.face_and_stillness import Look
from station.guide.free_attitude_dwell import Leaning
from station.guide.placing_stage import Placing
from station.guide.question import Asking
from station.guide.seating_check import keep_question
from station.guide.stage import Stage
from station.guide.stage_context import Desk
from station.guide.stream_trouble import Trouble, trouble_of
from station.guide.turn_stage import Turning
from station.guide.unit_recognition import Recognising
from station.guide.view import Gates, Link, PoseView, View
from station.guide.warm_up_stage import Warming
from station.guide.wording import title
from station.stream.live.stillness import TIMES_NOISE, Block

KEPT_BLOCKS = 8  # of the past, besides those of the step


class Guide:
    """Takes a desk through its checklist.

    ``warms_up``: not before the unit has settled; ``unsure`` is the unit that it should be, where the wire does
    not say.
    """

    def __init__(self, desk: Desk, *, warms_up: bool, unsure: UnitRecord | None = None) -> None:
        self.desk = desk
        first = self._first = _warming if warms_up else _placing
        self._restarts = desk.feed.restarts
        self._now: Stage = first(desk) if unsure is None else Recognising(desk, unsure, first)
        self._look: Look | None = None
        self._accel: FloatArray = np.zeros(3)
        self._tracker = Tracker(desk)
        self._heading = HeadingWatch(desk, self._tracker)
        self._is_paused = False
        self.trouble = ""  # with the stream, in words ...
        self._troubled = Trouble.none()  # ... and what is to be done
        self._time_s: float | None = None  # the device's, up to which the stream was looked at

    @property
    def _stage(self) -> Stage:
        """What goes on now."""
        return self._now

    @_stage.setter
    def _stage(self, stage: Stage) -> None:
        if stage is not self._now and self._is_recording:
            self.desk.story.ended()
        self._now = stage

    @property
    def is_complete(self) -> bool:
        """Whether nothing is left to do."""
        return self.desk.checklist.wanted is None and not self._is_recording

    def take(self, block: Block) -> None:
        """Take a second of the stream."""
        desk = self.desk
        desk.judge.learn(block)
        self._accel = block.rate[3:]
        self._time_s = block.ends if desk.feed.tells_time else None
        look = self._look = desk.judge.look(block)
        self._tracker.take(block, look)
        if block.is_anew:
            self._stage = self._stage.interrupted()
            self._look_for_restart()
        elif self._is_paused:
            look = replace(look, is_still=False, is_calm=False, hindrance="paused")
        self._stage = self._stage.take(block, look)
        self._heading.take(look, self._step if self._may_stand_wrong else None)
        past = block.first - KEPT_BLOCKS * (block.last - block.first)
        oldest = self._stage.oldest
        desk.feed.tape.forget_before(past if oldest is None else min(past, oldest))

    def glance(self, block: Block | None) -> None:
        """Take the newest second for show only."""
        if block is not None:
            self._look, self._accel = self.desk.judge.look(block), block.rate[3:]
        self._tracker.glance()

    def stream_failed(self, error: DriverError) -> None:
        """Take what is wrong with the stream; a dwell or turn under way is not accepted."""
        if not self.trouble:
            self.trouble, self._troubled = str(error), trouble_of(error)
            self.desk.story.say("rejected", self.trouble)
            self._stage = self._stage.interrupted()

    def stream_is_back(self) -> None:
        """Take it that the stream goes on."""
        if self.trouble:
            self.trouble = ""
            if not self._look_for_restart():
                self.desk.story.say("", "the stream is back")

    def _look_for_restart(self) -> bool:
        """Say so if the unit was switched off and on: it warms up again, and its biases are others."""
        if (restarts := self.desk.feed.restarts) == self._restarts:
            return False
        self._restarts = restarts
        self.desk.power_cycled("; it warms up again" if self._first is _warming else "")
        if not isinstance(self._stage, Recognising):
            self._stage = self._first(self.desk)
        return True

    def obey(self, command: Command) -> None:
        """Do as the operator says; what does not fit the moment is said and changes nothing."""
        if action := self._actions().get(command.verb):
            action(command)

    def _actions(self) -> dict[str, Callable[[Command], None]]:
        return {
            "choose": self._choose, "redo": self._redo, "pause": self._pause, "go_on": self._go_on,
            "answer": self._answer, "keep_seating": self._keep_seating, "skip_warm_up": self._skip_warm_up,
        }  # fmt: skip

    def view(self, base: View) -> View:
        """Return ``base`` with everything filled in that the guide knows."""
        desk = self.desk
        shown = {"hint": "", "live": ""} | self._stage.shown()
        extras = {
            key: shown.pop(key)
            for key in ("position", "heading", "seating", "is_seated", "is_free")
            if key in shown
        }
        if self._heading.text:
            shown["hint"] = self._heading.text
        if self._is_paused:
            shown |= {"stage": "paused", "line": "paused: nothing is recorded", "hint": "p goes on"}
        if self.trouble:
            shown |= {"line": self._troubled.instruction, "hint": self.trouble}
        return base.model_copy(
            update=shown
            | {
                "steps": desk.checklist.views(shown["live"]),
                "wanted": wanted.name if (wanted := desk.checklist.wanted) else "",
                "can_redo": desk.checklist.latest,
                "remaining_s": max(desk.checklist.remaining_s() - shown.get("accepted_s", 0.0), 0.0),
                "gates": None if self.trouble else self._gates(extras),
                "pose": None if self.trouble else self._pose(),
                "link": self._link(),
                "events": desk.story.events,
                "time_s": self._time_s,
            }
        )

    @property
    def _may_stand_wrong(self) -> bool:
        """Whether nothing has found yet that the cube stands in a position."""
        stage = self._stage
        return isinstance(stage, Placing) or (isinstance(stage, Resting) and not stage.is_known)

    @property
    def _is_recording(self) -> bool:
        return isinstance(self._stage, Resting | Turning | Leaning)

    def _gates(self, extras: dict[str, object]) -> Gates | None:
        if (look := self._look) is None or (isinstance(self._stage, Turning) and self._stage.is_moving):
            return None
        limit = TIMES_NOISE**0.5
        gates = Gates(
            face=look.face, off_deg=look.off_deg, limit_deg=self.desk.judge.limit_deg,
            is_right_face=look.is_upright and self._has_work(look.face),
            is_wanted_face=face_wanted(self._step) in {"", look.face},
            still=look.still * limit, still_limit=limit, still_channel=look.channel, is_still=look.is_still,
            position=self.desk.position,
        )  # fmt: skip
        if extras.get("is_free"):
            is_apart = nearest_deg(self.desk.judge.way_up(self._accel), self.desk.leans_taken()) >= APART_DEG
            extras = extras | {"is_right_face": look.off_deg >= APART_DEG and is_apart, "limit_deg": APART_DEG}
        return gates.model_copy(update=extras)

    @property
    def _step(self) -> Step | None:
        """The step that is being recorded, else the one wanted."""
        live = self._stage.shown().get("live", "")
        checklist = self.desk.checklist
        return next((step for step in checklist.steps if step.name == live), checklist.wanted)

    def _pose(self) -> PoseView | None:
        pose = pose_view(self._tracker, self.desk, self._step)
        is_turning = isinstance(self._stage, Turning) and self._stage.is_moving
        return pose.model_copy(update={"text": "", "turn_deg": None}) if pose and is_turning else pose

    def _has_work(self, face: str) -> bool:
        checklist = self.desk.checklist
        wanted = checklist.wanted
        turns_here = getattr(wanted, "axis", None) is not None and face == f"{getattr(wanted, 'axis', '')}_up"
        return bool(checklist.open_dwells(face) or checklist.open_soak(face)) or turns_here

    def _link(self) -> Link:
        feed = self.desk.feed
        counters, stream = feed.stream.decoder.counters, feed.stream.counters
        return Link(
            name=feed.address.name, rate_hz=1 / feed.period,
            bad_frames=counters.bad_crc + counters.bad_length, lost=stream.lost,
            gaps=stream.breaks + stream.restarts, temperature_c=feed.temperature_c,
            is_live=not self.trouble, word=self._troubled.word if self.trouble else "",
            text=self.trouble or feed.trouble or feed.silent,
        )  # fmt: skip

    def _choose(self, command: Command) -> None:
        if self.desk.checklist.choose(command.step):
            self._look_again()
        else:
            step = next((each for each in self.desk.checklist.steps if each.name == command.step), None)
            what = f"{title(step)} is done already: r does it again" if step else "there is no such step"
            self.desk.story.say("", what)

    def _redo(self, command: Command) -> None:
        checklist = self.desk.checklist
        name = command.step or checklist.latest
        if not checklist.redo(name):
            self.desk.story.say("", "nothing to do again yet")
            return
        step = next(each for each in checklist.steps if each.name == name)
        self.desk.story.say("", f"{title(step)} is to be done again; the one before counts until then")
        self._look_again()

    def _look_again(self) -> None:
        """Let what is wanted now decide, unless something else is being recorded."""
        if isinstance(self._stage, Placing):
            self._stage = _placing(self.desk)

    def _pause(self, _: Command) -> None:
        if not self._is_paused:
            self._is_paused = True
            if isinstance(self._stage, Turning):
                self._stage = Placing(self.desk, must_move=False)
            self.desk.story.say("", "paused")

    def _go_on(self, _: Command) -> None:
        if self._is_paused:
            self._is_paused = False
            self.desk.story.say("", "going on")

    def _answer(self, command: Command) -> None:
        if isinstance(self._stage, Resting | Turning | Recognising | Leaning | Asking):
            self._stage.answer(command.key)

    def _keep_seating(self, _: Command) -> None:
        if not self.desk.off_seat:
            return
        if (question := keep_question(self.desk)) is None:
            self._stage = self._kept(self.desk.off_seat)
        else:
            position = self.desk.off_seat
            then = {"y": lambda: self._kept(position), "n": lambda: _set_down_again(self.desk)}
            self._stage = Asking(self.desk, question, then)

    def _kept(self, position: int) -> Stage:
        desk = self.desk
        desk.kept_seats[position] = desk.seats[position]
        desk.off_seat = 0
        return Placing(desk, must_move=False)

    def _skip_warm_up(self, _: Command) -> None:
        if isinstance(self._stage, Warming):
            self._stage = self._stage.skipped()


def _warming(desk: Desk) -> Stage:
    return Warming(desk, _placing)


def _set_down_again(desk: Desk) -> Stage:
    return Placing(desk, must_move=bool(desk.off_seat), why="lift, wipe, set down")


def _placing(desk: Desk) -> Stage:
    return Placing(desk, must_move=bool(desk.position))
