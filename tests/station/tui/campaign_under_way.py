"""What a campaign under way looks like in every view of it: unit, link, pose, steps, events."""

import numpy as np

from procedures.frames import rotation, vertical_rotation
from procedures.positions import TURN_START, nominal_C_lb
from station.guide.view import CalibrationView, LinkView, PoseView, StageName, StepState, StepView
from station.stream.stream_events import Event
from tests.station.tui.start_views import FOLDER

UNIT = "SIM-FOG3 SIM-7"
LINK = LinkView(name="ttyUSB0", rate_hz=100.0, bad_frames=0, lost=0, gaps=0, temperature_c=24.3)


def pose(position: int, turned: float = 0.0, tipped: float = 0.0, std: float | None = 1.8,
         **specified: object) -> PoseView:  # fmt: skip
    """Return a cube ``turned`` counter-clockwise of a position, then tipped over to the south [deg]."""
    C = rotation(np.radians([tipped, 0.0, 0.0])) @ vertical_rotation(np.radians(turned)) @ nominal_C_lb(position)
    rows = tuple(tuple(round(float(part), 2) + 0.0 for part in row) for row in C)
    return PoseView.model_validate({"C_lb": rows, "heading_std_deg": std, **specified})


def steps(done: int, *, live: str = "", redo: str = "") -> tuple[StepView, ...]:
    """Return the 18 steps, the first ``done`` accepted; position 2 was recorded twice."""
    dwells = [StepView(name=f"dwell_{p:02d}", state="todo", position=p) for p in range(1, 13)]
    turns = [
        StepView(
            name=f"turn_{axis}_{word}", state="todo", axis=axis, direction=sign, revolutions=3,
            start_position=TURN_START[axis],
        )
        for axis in "xyz"
        for word, sign in (("plus", "+"), ("minus", "-"))
    ]  # fmt: skip
    return tuple(_reported(step, number < done, live, redo) for number, step in enumerate([*dwells, *turns]))


def _reported(step: StepView, is_done: bool, live: str, redo: str) -> StepView:
    state: StepState = "done" if is_done else "todo"
    if step.name in (live, redo):
        state = "live" if step.name == live else "redo"
    attempts = (2 if step.position == 2 else 1) if is_done else 0
    note = "a knock at 34 s was left out" if step.position == 2 and is_done else ""
    seconds = 0.0 if not is_done else 100.0 if step.position else 31.0
    return step.model_copy(update={"state": state, "attempts": attempts, "seconds": seconds, "note": note})


EVENTS = (
    Event(number=7, sound="accepted", text="position 1 accepted, 100 s on the disk"),
    Event(number=8, sound="start", text="next: position 2"),
    Event(number=9, sound="rejected", text="position 4: knocked at 61 s, 1.2 s left out"),
    Event(number=10, sound="accepted", text="position 2 accepted, 100 s on the disk; the first one is superseded"),
    Event(number=11, sound="start", text="next: position 3"),
)

RUNNING = CalibrationView(
    unit=UNIT, folder=FOLDER, steps=steps(2), wanted="dwell_03", can_redo="dwell_02", link=LINK,
    remaining_s=2210.0, events=EVENTS,
)  # fmt: skip


def running(stage: StageName, **update: object) -> CalibrationView:
    """Return a view of a campaign under way."""
    return RUNNING.model_copy(update={"stage": stage, **update})
