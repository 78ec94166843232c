"""Plans: what the operator is asked to do, as a generator of frozen steps that touches nothing."""

from collections.abc import Generator
from dataclasses import dataclass
from typing import Protocol, TypeVar

import numpy as np

from procedures.counts.sample_records import RateSeries, Series
from procedures.frames import face_of

R = TypeVar("R")


@dataclass(frozen=True, slots=True)
class Dwell:
    """Rest the cube in ``position`` (1..12) and record for ``seconds`` of device time."""

    position: int
    seconds: float

    @property
    def name(self) -> str:
        """The step's name, also the stem of its file."""
        return f"dwell_{self.position:02d}"


@dataclass(frozen=True, slots=True)
class Turn:
    """Turn the cube by hand about its vertical ``axis`` (x, y, z), ``direction`` + or -, whole ``revolutions``.

    It begins and ends in ``start_position`` with ``rest_s`` seconds of rest at each end. ``speed_deg_s`` is asked
    for where speed matters: two speeds in each direction tell asymmetry from nonlinearity.
    """

    axis: str
    direction: str
    revolutions: int
    start_position: int
    rest_s: float
    speed_deg_s: float | None = None

    @property
    def name(self) -> str:
        """The step's name, also the stem of its file."""
        return f"turn_{self.axis}_{'plus' if self.direction == '+' else 'minus'}"


@dataclass(frozen=True, slots=True)
class FreePosition:
    """Rest the cube for ``seconds`` in an attitude between its faces; nobody sets the ``number``-th exactly."""

    number: int
    seconds: float

    @property
    def name(self) -> str:
        """The step's name, also the stem of its file."""
        return f"free_{self.number:02d}"


@dataclass(frozen=True, slots=True)
class Soak:
    """Rest the cube for ``seconds`` while temperature or an auxiliary channel moves, the ``number``-th such rest.

    In ``position`` (1..12), or with the face ``up`` (``x_up`` ..) up, or, without either, in a free attitude.
    """

    number: int
    seconds: float
    position: int = 0
    up: str = ""

    @property
    def name(self) -> str:
        """The step's name, also the stem of its file."""
        return f"soak_{self.number:02d}"

    @property
    def face(self) -> str:
        """The face that is up; empty in a free attitude."""
        return face_of(self.position) if self.position else self.up


Step = Dwell | Turn | FreePosition | Soak
Plan = Generator[Step, Series, R]


class StepPerformer(Protocol):
    """Whoever answers a plan's steps: an operator at a screen, a headless station, a simulated bench."""

    def perform(self, step: Step) -> Series:
        """Have ``step`` done and return what the IMU put out during it."""
        ...


def run(plan: Plan[R], bench: StepPerformer) -> R:
    """Drive ``plan`` to its end; what ``bench`` raises is raised inside the plan, at its step."""
    try:
        step = next(plan)
        while True:
            try:
                answer = bench.perform(step)
            except Exception as error:
                step = plan.throw(error)
            else:
                step = plan.send(answer)
    except StopIteration as stop:
        result: R = stop.value
        return result


def steps_of(plan: Plan[R]) -> tuple[Step, ...]:
    """Return the steps that ``plan`` would ask for if every one of them recorded nothing."""
    steps, nothing = list[Step](), RateSeries(np.zeros(0), None, None, np.zeros(0), 1.0)
    try:
        steps.append(next(plan))
        while True:
            steps.append(plan.send(nothing))
    except StopIteration:
        return tuple(steps)
