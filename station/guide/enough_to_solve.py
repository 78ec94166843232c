"""Is there enough to solve? Asked before anything is solved: the solve itself has the last word."""

from collections.abc import Iterable, Sequence

from procedures.frames import AXES, POSITIONS, face_of, position_name
from station.guide.view import StepView


def lacking(steps: Sequence[StepView]) -> str:
    """Return why the steps done so far surely cannot be solved and which positions are to do, else empty.

    Scale factors, misalignments and bias of an accelerometer are four numbers: rests determine them where each
    axis of the cube was vertical and one of them both ways. Turns about all three axes, or a free attitude, may
    do without.
    """
    done = [step for step in steps if step.attempts]
    if any(step.is_free or step.is_soak for step in done) or {step.axis for step in done} >= set(AXES):
        return ""
    faces = {face_of(step.position or step.start_position) for step in done}
    if {face[0] for face in faces} == set(AXES) and len(faces) > len(AXES):
        return ""
    missing = {step.position for step in steps if step.position and not step.repeat and not step.attempts}
    to_do = ", ".join(filter(None, [in_ranges(p for p in missing if p <= len(POSITIONS)), *_others(missing)]))
    least = "each of X, Y and Z must have pointed up or down, and one of them both"
    return f"Not enough steps to solve: {least}. Positions to do: {to_do}."


def _others(positions: Iterable[int]) -> list[str]:
    return [position_name(p) for p in sorted(positions) if p > len(POSITIONS)]


def in_ranges(numbers: Iterable[int]) -> str:
    """Return numbers as people say them: ``1, 2, 5 to 12``."""
    runs = list[list[int]]()
    for number in sorted(numbers):
        if runs and number == runs[-1][-1] + 1:
            runs[-1].append(number)
        else:
            runs.append([number])
    parts = [f"{run[0]} to {run[-1]}" if len(run) > 2 else ", ".join(map(str, run)) for run in runs]
    return ", ".join(parts)
