"""The steps of a plan: what the operator is asked to do."""

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, replace

from procedures.frames import AXES
from procedures.positions import TURN_START, face_of, position_name

# in which the twelve positions are proposed; their numbers name positions in stored data and never change
USUAL_ORDER = tuple(range(1, 13))


@dataclass(frozen=True, slots=True)
class Dwell:
    """Rest the cube in ``position`` (1..24) and record for ``seconds`` of device time.

    ``repeat`` counts the dwells in this position that the plan has before it: a repeat is a step of its own.
    """

    position: int
    seconds: float
    repeat: int = 0

    @property
    def name(self) -> str:
        """The step's name, also the stem of its file: ``dwell_01``, ``dwell_01_repeat``, ``dwell_01_repeat2``."""
        again = f"_repeat{self.repeat if self.repeat > 1 else ''}"
        return f"dwell_{self.position:02d}{again if self.repeat else ''}"

    @property
    def words(self) -> str:
        """The position as people say it: ``1``, ``SDE``, ``1 repeated``, ``1 repeated (2)``."""
        again = f" repeated{f' ({self.repeat})' if self.repeat > 1 else ''}"
        return f"{position_name(self.position)}{again if self.repeat else ''}"


@dataclass(frozen=True, slots=True)
class Turn:
    """Turn the cube by hand about its vertical ``axis`` (x, y, z), ``direction`` + or -, whole ``revolutions``.

    It begins and ends in ``start_position`` with ``rest_s`` seconds of rest at each end. ``speed_deg_s`` is asked
    for where speed matters: two speeds in each direction separate asymmetry from nonlinearity.
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

    In ``position`` (1..24), or with the face ``up`` (``x_up`` ..) up, or, without either, in a free attitude.
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


@dataclass(frozen=True, slots=True)
class Monitor:
    """Rest the cube in ``position`` (1..12) for ``seconds``, and read roll and pitch by ``filters`` in that time.

    It is the ``number``-th such step; the filters are those of `procedures.attitude.filter_choice`.
    """

    number: int
    seconds: float
    position: int
    filters: tuple[str, ...] = ("joint", "mixer")

    @property
    def name(self) -> str:
        """The step's name, also the stem of its file."""
        return f"monitor_{self.number:02d}"

    @property
    def face(self) -> str:
        """The face that is up."""
        return face_of(self.position)


Step = Dwell | Turn | FreePosition | Soak | Monitor


def as_repeats(steps: Iterable[Step]) -> tuple[Step, ...]:
    """Return the steps with each dwell in a position that had one before as a repeat, the repeats last."""
    first, last, count = list[Step](), list[Step](), Counter[int]()
    for step in steps:
        if isinstance(step, Dwell):
            step = replace(step, repeat=count[step.position])
            count[step.position] += 1
        (last if isinstance(step, Dwell) and step.repeat else first).append(step)
    return (*first, *last)


def dwell_steps(seconds: float) -> tuple[Dwell, ...]:
    """Return a rest of ``seconds`` in each of the twelve positions, in `USUAL_ORDER`."""
    return tuple(Dwell(position, seconds) for position in USUAL_ORDER)


def turn_steps(revolutions: int = 3, rest_s: float = 5.0) -> tuple[Turn, ...]:
    """Return the six turns, + and - about each vertical axis, with ``rest_s`` of rest at both ends."""
    return tuple(Turn(a, d, revolutions, TURN_START[a], rest_s) for a in AXES for d in "+-")
