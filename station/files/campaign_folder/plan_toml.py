"""Plans as files (`plan/1`): what is to be done, as the step tables of `campaign/1` without ``file``.

Beside them stands ``seconds``: of a dwell what it records, of a turn the rest at each of its ends (5 if not
given). ``start_position`` of a turn is 1, 5, 9 for x, y, z if not given. ``speed_deg_s`` of a turn is about how
fast it should be, where that matters. A ``[[dwell]]`` has ``position``, ``axes`` (where the cube's x, y, z point:
``"SDE"``) or ``attitude = "free"``, a ``[[soak]]`` these or ``up``, a ``[[monitor]]`` ``position`` and ``laws``,
joint and mixer if not given. Dwells come before turns, then soaks, then monitors, then the dwells in a position
that had one before: those are repeats, which show what changed meanwhile. A plan for an IMU that is mounted
otherwise says so as a campaign does: ``[fixture] imu_axes``.
"""

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field

from procedures.attitude.laws import parse_laws, refuse_without_velocity
from procedures.campaign.plan_steps import Dwell, FreePosition, Monitor, Soak, Step, Turn, as_repeats
from procedures.frames import ATTITUDES, TURN_START, face_of
from station.errors import DataRefused
from station.files.atomic_file import replace_file
from station.files.campaign_folder.campaign_schema import (
    Axis,
    CubeAttitude,
    Face,
    ImuAxes,
    Laws,
    Position,
    attitude,
)
from station.files.toml_reading import TomlTable, line_of, read_tables, read_text_file
from station.files.toml_writing import toml_text

FORMAT = "plan/1"
REST_S = 5.0
_KINDS = ("dwell", "turn", "soak", "monitor")
_GUIDED = '[[dwell]] with position = 1..12, axes or attitude = "free", [[turn]], [[soak]] and [[monitor]]'
_REMEDY = "remove it: such a step cannot be guided yet"
Seconds = Annotated[float, Field(gt=0, le=1e6)]


class PlannedDwell(TomlTable):
    """``[[dwell]]`` of a plan; of the three attitudes ``up`` cannot be guided yet."""

    seconds: Seconds
    position: Position | None = None
    axes: CubeAttitude | None = None
    up: Face | None = None
    attitude: Literal["free"] | None = None

    @property
    def number(self) -> int:
        """Return which of the 24 positions it is, 0 of others."""
        return self.position or (ATTITUDES.index(self.axes) + 1 if self.axes else 0)


class PlannedSoak(PlannedDwell):
    """``[[soak]]`` of a plan, in any of the three attitudes."""


class PlannedTurn(TomlTable):
    """``[[turn]]`` of a plan."""

    axis: Axis
    direction: Literal["+", "-"]
    revolutions: Annotated[int, Field(ge=1, le=100)]
    start_position: Position | None = None
    seconds: Seconds = REST_S
    speed_deg_s: Annotated[float, Field(gt=0, le=1000)] | None = None


class PlannedMonitor(TomlTable):
    """``[[monitor]]`` of a plan."""

    position: Position
    seconds: Seconds
    laws: Laws = ["joint", "mixer"]


class PlannedFixture(TomlTable):
    """``[fixture]`` of a plan: how the IMU is to be mounted."""

    imu_axes: ImuAxes


class PlanTable(TomlTable):
    """The whole of a plan; sequences and rate tables cannot be guided yet."""

    format: Literal["plan/1"]
    fixture: PlannedFixture | None = None
    dwell: list[PlannedDwell] = []
    turn: list[PlannedTurn] = []
    sequence: list[dict[str, Any]] = []
    rate: list[dict[str, Any]] = []
    soak: list[PlannedSoak] = []
    monitor: list[PlannedMonitor] = []


def write_plan(path: Path, steps: Sequence[Step]) -> None:
    """Write a plan: there whole or, after a kill, as it was before; raise `CannotWrite` if it cannot be."""
    tables: dict[str, Any] = {"format": FORMAT, **{kind: [] for kind in _KINDS}}
    for step in steps:
        kind, table = _table(step)
        tables[kind].append(table)
    replace_file(path, toml_text({key: value for key, value in tables.items() if value}).encode())


def read_plan(path: Path) -> tuple[Step, ...]:
    """Read a plan.

    Raises
    ------
    DataRefused
        With file and line, if it is no plan, has no step, has a turn twice, or one that cannot be guided yet.
    """
    plan, lines = read_tables(read_text_file(path), path, PlanTable)
    for unguided in ("sequence", "rate"):
        if getattr(plan, unguided):
            raise DataRefused(path, line_of((unguided, 0), lines), f"a [[{unguided}]]", _GUIDED, _REMEDY)
    steps = list[Step]()
    for kind, index, table in ((name, *each) for name in _KINDS for each in enumerate(getattr(plan, name))):
        line = line_of((kind, index), lines)
        step = _step(table, path, line, steps)
        if isinstance(step, Turn) and any(step.name == other.name for other in steps):
            raise DataRefused(path, line, f"a second {step.name}", "each turn once")
        steps.append(step)
    if not steps:
        raise DataRefused(path, None, "no step", _GUIDED)
    return as_repeats(steps)


def read_mounting(path: Path) -> tuple[str, ...]:
    """Return the cube axes along which a plan wants the IMU's x, y, z, or none; raise as `read_plan` does."""
    plan, _ = read_tables(read_text_file(path), path, PlanTable)
    return () if plan.fixture is None else tuple(plan.fixture.imu_axes)


def _table(step: Step) -> tuple[str, dict[str, Any]]:
    """Return a step's kind and its table."""
    if isinstance(step, Turn):
        speed = {} if step.speed_deg_s is None else {"speed_deg_s": step.speed_deg_s}
        own = {name: getattr(step, name) for name in ("axis", "direction", "revolutions", "start_position")}
        return "turn", {**own, "seconds": step.rest_s, **speed}
    if isinstance(step, Monitor):
        return "monitor", {"position": step.position, "seconds": step.seconds, "laws": list(step.laws)}
    where: dict[str, Any] = {"attitude": "free"}
    if isinstance(step, Dwell | Soak) and step.position:
        where = attitude(step.position)
    elif isinstance(step, Soak) and step.up:
        where = {"up": step.up}
    return "soak" if isinstance(step, Soak) else "dwell", {**where, "seconds": step.seconds}


def _step(
    table: PlannedDwell | PlannedTurn | PlannedMonitor, path: Path, line: int, before: Iterable[Step]
) -> Step:
    """Return the step of a table; free positions and soaks are numbered as they come, after those ``before``."""
    if isinstance(table, PlannedTurn):
        start = table.start_position or TURN_START[table.axis]
        if face_of(start) != f"{table.axis}_up":
            raise DataRefused(path, line, f"start_position = {start}", f"one with {table.axis} up")
        return Turn(table.axis, table.direction, table.revolutions, start, table.seconds, table.speed_deg_s)
    if isinstance(table, PlannedMonitor):
        try:
            refuse_without_velocity(laws := parse_laws(",".join(table.laws)), "none")
        except ValueError as error:
            raise DataRefused(path, line, str(error), "filters that evaluate a rest", "remove them") from None
        number = 1 + sum(isinstance(step, Monitor) for step in before)
        return Monitor(number, table.seconds, table.position, laws)
    kind = "soak" if isinstance(table, PlannedSoak) else "dwell"
    given = [name for name in ("position", "axes", "up", "attitude") if getattr(table, name) is not None]
    if len(given) != 1:
        found = f"a [[{kind}]] with {' and '.join(given)}" if given else f"a [[{kind}]] without position"
        raise DataRefused(path, line, found, "exactly one of position, axes, up and attitude")
    if kind == "soak":
        number = 1 + sum(isinstance(step, Soak) for step in before)
        return Soak(number, table.seconds, table.number, table.up or "")
    if table.up is not None:
        raise DataRefused(path, line, f"a [[dwell]] with up = {table.up!r}", _GUIDED, _REMEDY)
    if table.number:
        return Dwell(table.number, table.seconds)
    return FreePosition(1 + sum(isinstance(step, FreePosition) for step in before), table.seconds)
