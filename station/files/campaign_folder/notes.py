"""What a guided campaign keeps in its folder beside the steps: set-up, plan, the unit, what is wanted."""

from pathlib import Path
from typing import Annotated, TypeVar

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from procedures.campaign.plan_steps import Step
from station.errors import DataRefused
from station.files.atomic_file import replace_file
from station.files.campaign_folder.campaign_schema import CAMPAIGN_TOML, CampaignTable
from station.files.campaign_folder.plan_toml import read_plan, write_plan
from station.files.setup import Setup
from station.files.toml_writing import toml_text

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
    """By file: how long the spans are that the guide left out of a step, as the cube was disturbed [s]."""

    model_config = ConfigDict(extra="forbid", frozen=True)
    spans_s: dict[str, list[float]] = {}


class NoMoves(BaseModel):
    """By step: why no use is made of the move to it, in words."""

    model_config = ConfigDict(extra="forbid", frozen=True)
    why: dict[str, str] = {}


class WantedRecord(BaseModel):
    """What a campaign goes on for, and what it is reckoned by, as `procedures.planning` has it.

    ``sigmas`` by parameter, in the units of files, scale factors relative; ``accel_white`` [g sqrt(s)],
    ``gyro_white`` [deg/sqrt(s)], scales [count/(g s)] and [count/deg], None where nothing is counted; ``wander``
    [deg/s]; what a placing takes hands, and of that the move [s]. No white noise: the first dwell is to show it.
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
    """Keep a campaign's set-up, what is known of the unit, what was left out, or what is wanted."""
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
    """Keep what was left out of a step."""
    kept = read_left_out(folder)
    write_note(folder, LeftOutSpans(spans_s={**kept, file: [round(span, 3) for span in spans_s]}))


def read_left_out(folder: Path) -> dict[str, list[float]]:
    """Return what was left out of the steps, by file [s]; raise `DataRefused` if it cannot be read."""
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
