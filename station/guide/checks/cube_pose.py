"""How the cube stands compared with the requested step: what is left to do, and a heading that stays wrong."""

import numpy as np

from procedures.bench.cube_attitude import CubeAttitude, heading_to_position
from procedures.campaign.plan_steps import Dwell, Monitor, Soak, Step, Turn
from procedures.gyrocompass import turned_position
from procedures.positions import face_normal, face_of, position_name
from station.guide.checks.cube_tracking import CubeTracker
from station.guide.checks.face_and_stillness import BlockLook
from station.guide.stages.stage_context import StageContext
from station.guide.view import PoseView
from station.guide.wording import face_in_words

TIPPED_DEG = 20.0  # off the vertical, from which on another face is as near as makes no matter
# From which on a heading is wrong; nearer a dwell itself judges
OFF_DEG, OFF_SIGMA = 10.0, 3.0
WRONG_S = 20  # at rest
QUARTER_DEG = 90.0
HALF_DEG = 178.0  # beyond which no way round is the shorter one
AS_WANTED = "the position is correct"
SIDES = ("east", "north", "west", "south")


def pose_view(tracker: CubeTracker, context: StageContext, step: Step | None) -> PoseView | None:
    """Return how the cube stands, and what is left to do for ``step``; None before anything was seen."""
    now = tracker.now
    if now is None:
        return None
    is_known = tracker.is_heading_known
    off = _turn_deg(now, step) if is_known else None
    rows = tuple(tuple(round(float(part), 2) + 0.0 for part in row) for row in now.C_lb)
    return PoseView.model_validate(
        {
            "C_lb": rows,
            "heading_std_deg": round(float(np.degrees(tracker.heading_std)), 1) if is_known else None,
            "turn_deg": None if off is None else float(round(off)),
            "text": _left_to_do(now, context, step, off, is_known=is_known),
        }
    )


class HeadingWatch:
    """Counts how long the cube rests on the right face with a wrong heading."""

    def __init__(self, context: StageContext, tracker: CubeTracker) -> None:
        self._context, self._tracker = context, tracker
        self._seconds = 0
        self.text = ""  # once it has been wrong for long

    def take(self, look: BlockLook, step: Step | None) -> None:
        """Take a second in which ``step`` was wanted; what stays wrong is reported once."""
        may_be_wrong = look.is_still and look.is_upright and not self._context.position  # else yet to be moved
        pose = pose_view(self._tracker, self._context, step) if may_be_wrong else None
        is_wrong = (
            pose is not None and pose.turn_deg is not None
            and abs(pose.turn_deg) > max(OFF_DEG, OFF_SIGMA * (pose.heading_std_deg or 0.0))
            and _position_as_it_stands(self._context, step, pose.turn_deg) is None
        )  # fmt: skip
        self._seconds = self._seconds + 1 if is_wrong else 0
        self.text = self.text if is_wrong else ""
        if pose is not None and self._seconds >= WRONG_S:
            text = f"{face_in_words(look.face)} is correct, but the heading is wrong: {pose.text}"
            if not self.text:
                self._context.event_log.say("rejected", text)
            self.text = text


def _turn_deg(now: CubeAttitude, step: Step | None) -> float | None:
    """Return how far the cube must be turned to stand as a step wants it; None where its face is another."""
    position = step.start_position if isinstance(step, Turn) else getattr(step, "position", 0)
    if not position or _tipped_deg(now, face_of(position)) > TIPPED_DEG:
        return None
    return float(np.degrees(heading_to_position(now, position)))


def _tipped_deg(now: CubeAttitude, face: str) -> float:
    return float(np.degrees(np.arccos(np.clip(now.up @ face_normal(face), -1.0, 1.0))))


def _left_to_do(
    now: CubeAttitude, context: StageContext, step: Step | None, off: float | None, *, is_known: bool
) -> str:
    face = face_wanted(step)
    if step is None or not face:
        return ""
    if _tipped_deg(now, face) > TIPPED_DEG:
        return _tip(now, face, is_known=is_known)
    if not getattr(step, "position", 0) and not isinstance(step, Turn):
        return AS_WANTED
    if off is None:
        return "its heading is not known yet"
    if abs(off) <= OFF_DEG:
        return AS_WANTED
    sense = "counter-clockwise" if off > 0 else "clockwise"
    text = f"turn {abs(off):.0f} deg more, {sense} from above"
    if abs(off) > HALF_DEG:
        text = "turn 180 deg, either way round"
    other = _position_as_it_stands(context, step, off)
    return f"{text}; or leave it: position {position_name(other)} is also still to do" if other else text


def face_wanted(step: Step | None) -> str:
    """Return the face that a step wants up, empty where it wants none."""
    if isinstance(step, Turn):
        return face_of(step.start_position)
    if isinstance(step, Dwell | Soak | Monitor):
        return face_of(step.position) if step.position else getattr(step, "up", "")
    return ""


def _tip(now: CubeAttitude, face: str, *, is_known: bool) -> str:
    """Say how to get ``face`` up."""
    where = now.C_lb @ face_normal(face)
    text = f"{face_in_words(face).replace(' points ', ' ')}"
    if where[2] < -np.cos(np.radians(45.0)):
        return f"turn it over: {text}"
    if not is_known:
        return f"tip it over: {text}"
    looks = round(float(np.degrees(np.arctan2(where[1], where[0]))) / 90.0) % 4
    return f"tip it over to the {SIDES[(looks + 2) % 4]}: {text}"


def _position_as_it_stands(context: StageContext, step: Step | None, off_deg: float) -> int | None:
    """Return the other position of the step's face if the cube stands in it and it is to do as well."""
    if not isinstance(step, Dwell):
        return None
    quarter = round(-off_deg / QUARTER_DEG) % 4  # from where it is wanted, counter-clockwise
    if not quarter or abs((off_deg + QUARTER_DEG * quarter + 180.0) % 360.0 - 180.0) > OFF_DEG:
        return None
    face = face_of(step.position)
    own = next(q for q in range(4) if turned_position(face, q) == step.position)
    there = context.checklist.dwell_at(other := turned_position(face, (own + quarter) % 4))
    return other if there is not None and context.checklist.is_open(there) else None
