"""Plans as files (`plan/1`), and what a guided campaign keeps: set-up, plan, the unit, what is wanted.

A plan says what is to be done, as the step tables of `campaign/1` without ``file``.
"""

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal, TypeVar

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from procedures.attitude.filter_choice import parse_filters, refuse_without_velocity
from procedures.campaign.plan_steps import Dwell, FreePosition, Monitor, Soak, Step, Turn, as_repeats
from procedures.positions import ATTITUDES, TURN_START, face_of
from station.errors import DataRefused
from station.files.atomic_file import replace_file
from station.files.campaign_folder.campaign_schema import (
    CAMPAIGN_TOML,
    Axis,
    CampaignTable,
    CubeAttitude,
    Face,
    FilterNames,
    ImuAxes,
    Position,
    attitude,
)
from station.files.campaign_setup import Setup
from station.files.toml_file import TomlTable, line_of, read_tables, read_text_file, toml_text

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
    laws: FilterNames = ["joint", "mixer"]


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
        return "monitor", {"position": step.position, "seconds": step.seconds, "laws": list(step.filters)}
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
            refuse_without_velocity(filters := parse_filters(",".join(table.laws)), "none")
        except ValueError as error:
            raise DataRefused(path, line, str(error), "filters that evaluate a rest", "remove them") from None
        number = 1 + sum(isinstance(step, Monitor) for step in before)
        return Monitor(number, table.seconds, table.position, filters)
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


PLAN = "plan.toml"
T = TypeVar("T", bound=BaseModel)
Three = Annotated[tuple[Annotated[float, Field(gt=0)], ...], Field(min_length=3, max_length=3)]
Six = Annotated[tuple[float, ...], Field(min_length=6, max_length=6)]


class UnitRecord(BaseModel):
    """A unit as the campaign knows it.

    ``noise`` is the variance of a tenth of a second's counts [count^2] at rest, ``rate`` [count/s] the mean of the
    first dwell: gyros, then accelerometers, raw, IMU axes. None where not known yet.
    """

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)
    model: str
    serial: str
    serial_from_wire: bool
    period: float
    noise: Six | None = None
    rate: Six | None = None


class LeftOutSpans(BaseModel):
    """By file: how long the spans are that the guide discarded from a step because the cube was disturbed [s]."""

    model_config = ConfigDict(extra="forbid", frozen=True)
    spans_s: dict[str, list[float]] = {}


class NoMoves(BaseModel):
    """By step: why no use is made of the move to it, as text."""

    model_config = ConfigDict(extra="forbid", frozen=True)
    why: dict[str, str] = {}


class WantedRecord(BaseModel):
    """What a campaign continues for, and what it is reckoned by, as `procedures.planning` has it.

    ``sigmas`` by parameter, in the units of files, scale factors relative; ``accel_white`` [g sqrt(s)],
    ``gyro_white`` [deg/sqrt(s)], scales [count/(g s)] and [count/deg], None where nothing is counted; ``wander``
    [deg/s]; what a placement takes hands, and of that the move [s]. No white noise: the first dwell is to show it.
    """

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)
    sigmas: dict[str, Annotated[float, Field(gt=0)]]
    accel_white: Three | None = None
    gyro_white: Three | None = None
    accel_scale: Three | None = None
    gyro_scale: Three | None = None
    wander: Annotated[float, Field(ge=0)] = 0.0
    placing_s: Annotated[float, Field(gt=0)]
    move_s: Annotated[float, Field(gt=0)]


NAMES: dict[type[BaseModel], str] = {
    Setup: "setup.json", UnitRecord: "unit.json", LeftOutSpans: "left_out.json", WantedRecord: "wanted.json",
    NoMoves: "no_moves.json",
}  # fmt: skip


def write_note(folder: Path, note: BaseModel) -> None:
    """Keep a campaign's set-up, what is known of the unit, what was omitted, or what is wanted."""
    replace_file(folder / NAMES[type(note)], (note.model_dump_json(indent=1) + "\n").encode())


def read_note(folder: Path, kind: type[T]) -> T | None:
    """Return a note of a campaign's folder, None if it has none; raise `DataRefused` if it cannot be read."""
    path = folder / NAMES[kind]
    try:
        return kind.model_validate_json(path.read_bytes())
    except FileNotFoundError:
        return None
    except (OSError, ValidationError) as error:
        raise DataRefused(path, None, f"what cannot be read ({type(error).__name__})", f"a {path.name}") from error


def keep_left_out(folder: Path, file: str, spans_s: list[float]) -> None:
    """Keep what was omitted of a step."""
    kept = read_left_out(folder)
    write_note(folder, LeftOutSpans(spans_s={**kept, file: [round(span, 3) for span in spans_s]}))


def read_left_out(folder: Path) -> dict[str, list[float]]:
    """Return what was omitted of the steps, by file [s]; raise `DataRefused` if it cannot be read."""
    return (read_note(folder, LeftOutSpans) or LeftOutSpans()).spans_s


def keep_no_move(folder: Path, step: str, why: str) -> None:
    """Keep why no use is made of the move to a step; an empty ``why``: one is made."""
    kept = read_no_moves(folder)
    if kept.get(step, "") != why:
        others = {name: text for name, text in kept.items() if name != step}
        write_note(folder, NoMoves(why=others | ({step: why} if why else {})))


def read_no_moves(folder: Path) -> dict[str, str]:
    """Return why no use is made of moves, by step; raise `DataRefused` if it cannot be read."""
    return (read_note(folder, NoMoves) or NoMoves()).why


def write_tables(folder: Path, tables: CampaignTable) -> None:
    """Write ``campaign.toml``: there whole or, after a kill, as it was before."""
    replace_file(folder / CAMPAIGN_TOML, toml_text(tables.model_dump(exclude_none=True)).encode())


def keep_plan(folder: Path, steps: tuple[Step, ...]) -> None:
    """Keep the steps that a campaign is to have."""
    write_plan(folder / PLAN, steps)


def kept_plan(folder: Path) -> tuple[Step, ...]:
    """Return the steps that a campaign is to have; none if it has no plan. `DataRefused` as in `read_plan`."""
    return read_plan(folder / PLAN) if (folder / PLAN).exists() else ()
