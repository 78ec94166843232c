"""The steps of a campaign: which are to do, which are done, which comes next, and whether they can be solved."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

from procedures.campaign.plan_steps import Dwell, FreePosition, Monitor, Soak, Step, Turn
from procedures.frames import AXES
from procedures.positions import POSITIONS, face_of, position_name
from station.guide.view import StepState, StepView

MOVE_S = 45.0  # what a person takes to place the cube
TURN_SPEED_DEG_S = 35.0
GRIP_S = 20.0  # before and after a turn, in addition to its rests
STEP_FIELDS = (  # of a view
    "position", "repeat", "number", "up", "axis", "direction", "revolutions", "start_position",
)  # fmt: skip


class Checklist:
    """``steps`` in the order suggested; ``attempts`` says how often each was accepted before, by name.

    ``seconds`` is how long those recordings are, ``notes`` what was noted of them.
    """

    def __init__(
        self,
        steps: Iterable[Step],
        attempts: Mapping[str, int] | None = None,
        seconds: Mapping[str, float] | None = None,
        notes: Mapping[str, str] | None = None,
    ) -> None:
        self.steps: Sequence[Step] = tuple(steps)
        self.attempts = {step.name: (attempts or {}).get(step.name, 0) for step in self.steps}
        self._seconds = dict(seconds or {})
        self._notes = dict(notes or {})
        self._redo: list[str] = []
        self._chosen = ""
        self._shown = dict[str, StepView]()
        self.latest = next(reversed([n for n, count in (attempts or {}).items() if count]), "")  # accepted last

    @property
    def wanted(self) -> Step | None:
        """The step to do next; None once all are done."""
        for name in (self._chosen, *self._redo):
            if name and (found := self.step(name)) is not None and self.is_open(found):
                return found
        return next((step for step in self.steps if self.is_open(step)), None)

    @property
    def open_steps(self) -> list[Step]:
        """The steps that are to be done, in the order suggested."""
        return [step for step in self.steps if self.is_open(step)]

    def step(self, name: str) -> Step | None:
        """Return a step by its name."""
        return next((step for step in self.steps if step.name == name), None)

    def is_open(self, step: Step) -> bool:
        """Say whether a step is to be done, for the first time or again."""
        name = step.name
        return name in self._redo or not self.attempts[name]

    def dwell_at(self, position: int) -> Dwell | None:
        """Return the first dwell in a position, open or done."""
        return next((s for s in self.steps if isinstance(s, Dwell) and s.position == position), None)

    def open_dwells(self, face: str) -> list[Dwell]:
        """Return the open dwells with a face up, the wanted one first; a repeat only where it is that one."""
        wanted = self.wanted
        here = [s for s in self.steps if isinstance(s, Dwell) and self.is_open(s) and face_of(s.position) == face]
        return sorted((s for s in here if not s.repeat or s == wanted), key=lambda step: step != wanted)

    def has_work(self, face: str) -> bool:
        """Say whether something is to be done with a face up: the wanted step, an open dwell, soak or monitor."""
        wanted = self.wanted
        is_turn = isinstance(wanted, Turn) and face_of(wanted.start_position) == face
        return is_turn or bool(self.open_dwells(face) or self.open_soak(face))

    def open_soak(self, face: str) -> Soak | Monitor | None:
        """Return the open soak or monitor with a face up, the wanted one first."""
        here = [s for s in self.steps if isinstance(s, Soak | Monitor) and self.is_open(s) and s.face == face]
        return min(here, key=lambda step: step != self.wanted, default=None)

    def open_free(self) -> FreePosition | Soak | None:
        """Return what is to be done next in a free attitude, the wanted step first."""
        here = [s for s in self.steps if is_free(s) and self.is_open(s)]
        first = min(here, key=lambda step: step != self.wanted, default=None)
        return first if isinstance(first, FreePosition | Soak) else None

    def accept(self, step: Step, seconds: float, note: str) -> None:
        """Take a step as done."""
        self._notes[step.name] = note
        self.attempts[step.name] += 1
        self._seconds[step.name] = seconds
        self._redo = [name for name in self._redo if name != step.name]
        self._chosen = "" if self._chosen == step.name else self._chosen
        self.latest = step.name

    def redo(self, name: str) -> bool:
        """Have a step done again, next; False if it was not done yet."""
        if not self.attempts.get(name):
            return False
        self._redo = [*(other for other in self._redo if other != name), name]
        self._chosen = name
        return True

    def keep(self, name: str) -> None:
        """Let a step stand that was to be done again."""
        self._redo = [other for other in self._redo if other != name]
        self._chosen = "" if self._chosen == name else self._chosen

    def choose(self, name: str) -> bool:
        """Have an open step done next; False if it is none."""
        if (step := self.step(name)) is None or not self.is_open(step):
            return False
        self._chosen = name
        return True

    def set_dwell(self, seconds: float) -> None:
        """Have every open dwell last ``seconds``."""
        self.steps = tuple(
            replace(step, seconds=seconds) if isinstance(step, Dwell) and self.is_open(step) else step
            for step in self.steps
        )

    def replan(self, steps: Iterable[Step]) -> None:
        """Replace the steps that were never recorded with ``steps``."""
        done = [step for step in self.steps if self.attempts[step.name]]
        self.steps = (*done, *steps)
        self.attempts = {step.name: self.attempts.get(step.name, 0) for step in self.steps}

    def remaining_s(self) -> float:
        """Return how long the open steps will take with no break."""
        return sum(step_duration(step) for step in self.open_steps)

    def views(self, live: str) -> tuple[StepView, ...]:
        """Return the steps as a screen shows them; ``live`` is being recorded."""
        return tuple(self._view(step, live) for step in self.steps)

    def _view(self, step: Step, live: str) -> StepView:
        name, attempts = step.name, self.attempts[step.name]
        state: StepState = "live" if name == live else "todo" if not attempts else "done"
        if state == "done" and name in self._redo:
            state = "redo"
        seconds, note = self._seconds.get(name, 0.0), self._notes.get(name, "")
        now, shown = (state, attempts, seconds, note), self._shown.get(name)
        if shown is None or (shown.state, shown.attempts, shown.seconds, shown.note) != now:
            own = {field: getattr(step, field) for field in STEP_FIELDS if hasattr(step, field)}
            shown = self._shown[name] = StepView(
                name=name, state=state, attempts=attempts, seconds=seconds, note=note, is_free=is_free(step),
                is_soak=isinstance(step, Soak), is_monitor=isinstance(step, Monitor), **own,
            )  # fmt: skip
        return shown


def is_free(step: Step) -> bool:
    """Say whether a step is done in a free attitude."""
    return isinstance(step, FreePosition) or (isinstance(step, Soak) and not step.face)


def step_duration(step: Step) -> float:
    """Return how long a step takes a person [s]."""
    if isinstance(step, Turn):
        return GRIP_S + 2 * step.rest_s + 360 * step.revolutions / TURN_SPEED_DEG_S
    return MOVE_S + step.seconds


def why_not_solvable(steps: Sequence[StepView]) -> str:
    """Return why the steps done so far surely cannot be solved and which positions are to do, else empty.

    Rests determine an accelerometer's four numbers where each axis of the cube was vertical, one of them both
    ways. Turns about all three axes, or a free attitude, may do without.
    """
    done = [step for step in steps if step.attempts]
    if any(step.is_free or step.is_soak for step in done) or {step.axis for step in done} >= set(AXES):
        return ""
    faces = {face_of(step.position or step.start_position) for step in done}
    if {face[0] for face in faces} == set(AXES) and len(faces) > len(AXES):
        return ""
    missing = sorted({step.position for step in steps if step.position and not step.repeat and not step.attempts})
    others = [position_name(p) for p in missing if p > len(POSITIONS)]
    to_do = ", ".join(filter(None, [in_ranges(p for p in missing if p <= len(POSITIONS)), *others]))
    least = "each of X, Y and Z must have pointed up or down, and one of them both"
    return f"Not enough steps to solve: {least}. Positions to do: {to_do}."


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
