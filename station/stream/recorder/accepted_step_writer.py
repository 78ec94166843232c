"""A campaign being recorded: a step is on the disk, hashed and in the database before it counts as accepted.

Order at accept: the file of the move to it, then the step's own, synced and under its name, with its hash in
``SHA256SUMS``; ``campaign.toml``, replaced whole, with both; the row in the database. A kill in between leaves a
folder that reads with every step accepted before.
"""

import os
import re
from collections import Counter
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from pathlib import Path
from types import MappingProxyType
from typing import Literal, NamedTuple

from sqlalchemy.orm import Session

from drivers.wire import PulseForm
from fixtures_db.campaigns import accept_step, set_state, start_campaign
from fixtures_db.database import Database
from fixtures_db.fixtures import fixture_rows, is_surveyed_at
from fixtures_db.folder_on_disk import sync_folder
from fixtures_db.schema import SiteRow
from procedures.campaign.plan_steps import Dwell, FreePosition, Monitor, Soak, Step, Turn
from procedures.positions import TURN_START
from station.errors import cannot_write
from station.files.atomic_file import free_path
from station.files.campaign_folder.campaign_schema import (
    CampaignImuTable,
    CampaignTable,
    DwellTable,
    EffectsTable,
    FixtureTable,
    MonitorTable,
    MoveTable,
    ProcedureTable,
    SiteTable,
    SoakTable,
    StepTable,
    TurnTable,
    attitude,
)
from station.files.campaign_folder.plan_file import write_tables
from station.files.mcap_files import BY_OUTPUT, StepWriter
from station.files.sha256sums import append_hash
from station.stream.connected_unit import Unit
from station.stream.recorder.sample_buffer import SampleBuffer, SampleRun
from station.stream.recorder.sample_times import RowTimes, StepRows, Utc

TOML = "campaign.toml"
_REPEAT = re.compile(r"dwell_\d+_repeat(\d*)(?:_\d+)?\.")
_NUMBERED = re.compile(r"(free|soak|monitor)_(\d+)")


class MovedFrom(NamedTuple):
    """How the cube came to a step: by the samples ``run``, from where the step in ``file`` left it."""

    file: str
    run: SampleRun


class CampaignRecorder:
    """Writes the accepted steps of one campaign; made by `open_campaign`, or reopened.

    ``accepted`` counts by step name how often it was accepted; all but the last are superseded. ``utc``, where a
    reference is read alongside the device, says what UTC [s] a moment of the station's clock [ns] was; ``pulse``
    reads that of a device that is given a pulse a second.
    """

    def __init__(
        self, folder: Path, tables: CampaignTable, database: Database, accepted: Mapping[str, int] | None = None
    ) -> None:
        self.folder, self.tables = folder, tables
        self.accepted = Counter(accepted or {})
        self.utc: Utc | None = None
        self.pulse: PulseForm | None = None
        self._database = database
        self._key = str(folder.resolve())

    @property
    def database_url(self) -> str:
        """Where what is accepted is remembered."""
        return self._database.url

    def accept(
        self,
        step: Step,
        buffer: SampleBuffer,
        runs: Sequence[SampleRun],
        stated: Mapping[str, object] = MappingProxyType({}),
        moved: MovedFrom | None = None,
        seats: Mapping[str, Sequence[float] | None] = MappingProxyType({}),
    ) -> Path:
        """Record ``step`` as the samples of ``runs``; it is accepted when this returns its file.

        ``stated`` is what else its table in ``campaign.toml`` holds, by key; ``moved`` is how the cube came there.
        ``seats`` says, by step, how far off (2,) [rad] the cube sat in dwells before, or that it sat well.

        A step of the same name recorded before is superseded: its file stays, the campaign no longer names it, nor
        the moves from it and to it.
        """
        carried = None
        if moved is not None:
            carried = self._written(f"move_{len(self.tables.move) + 1:02d}", buffer, [moved.run])[0]
        path, sha256 = self._written(step.name, buffer, runs)
        tables = _with_step(self.tables, step, path.name, stated)
        if moved is not None and carried is not None:
            table = MoveTable.model_validate({"from": moved.file, "to": path.name, "file": carried.name})
            tables = tables.model_copy(update={"move": [*tables.move, table]})
        tables = tables.model_copy(update={"dwell": [_with_seat(one, seats) for one in tables.dwell]})
        write_tables(self.folder, tables)
        with self._database.write() as session:
            accept_step(
                session, self._key, name=step.name, file=path.name, sha256=sha256, accepted_utc=datetime.now(UTC)
            )
        self.tables = tables
        self.accepted[step.name] += 1
        return path

    def _written(self, name: str, buffer: SampleBuffer, runs: Sequence[SampleRun]) -> tuple[Path, str]:
        """Put the samples of ``runs`` into a file of their own; return it, on the disk, with its hash."""
        path = free_path(self.folder, name)
        part = path.with_name(f".{path.name}.part")
        part.unlink(missing_ok=True)
        sha256 = write_runs(part, buffer, runs, BY_OUTPUT[self.tables.imu.output], self.utc, self.pulse)
        try:
            os.rename(part, path)
            sync_folder(self.folder)
        except OSError as error:
            raise cannot_write(path, error) from error
        append_hash(self.folder, path.name, sha256)
        return path, sha256

    def finish(self, state: str = "recorded") -> None:
        """Say in the database that the campaign is ``recorded``, ``accepted`` or ``cancelled``."""
        with self._database.write() as session:
            set_state(session, self._key, state)


def open_campaign(
    folder: Path,
    unit: Unit,
    site: SiteTable,
    database: Database,
    *,
    output: Literal["increments", "rate"] = "increments",
    fixture: FixtureTable | None = None,
    procedure: ProcedureTable | None = None,
    effects: EffectsTable | None = None,
    cube_id: str | None = None,
    slab_id: str | None = None,
    started_utc: datetime | None = None,
) -> CampaignRecorder:
    """Begin a campaign in ``folder``: its ``campaign.toml`` without steps, then its row in the database.

    ``started_utc`` is the wall clock's unless a better one is known.
    """
    tables = CampaignTable(
        format="campaign/1",
        imu=CampaignImuTable(model=unit.model, serial=unit.serial, sample_period_s=unit.period, output=output),
        site=site,
        procedure=procedure or ProcedureTable(),
        fixture=fixture or FixtureTable(),
        effects=effects,
    )
    with database.write() as session:
        start_campaign(
            session,
            str(folder.resolve()),
            model=unit.model,
            serial=unit.serial,
            started_utc=started_utc or datetime.now(UTC),
            cube_id=cube_id,
            slab_id=slab_id,
            site_id=_site_id(session, site),
            effects_sha256=() if effects is None else effects.sha256,
        )
        write_tables(folder, tables)  # before the commit: a row always has its folder
    return CampaignRecorder(folder, tables, database)


def step_of(table: StepTable) -> Step | None:
    """Return the step that a table of ``campaign.toml`` records, its duration 0; None if it is no guided one.

    What a free position or a soak is called stands in its file's name, and which repeat a dwell is.
    """
    if isinstance(table, TurnTable):
        start = table.start_position or TURN_START[table.axis]
        return Turn(table.axis, table.direction, max(round(table.turned), 1), start, 0.0)
    numbered = _NUMBERED.match(table.file)
    match table:
        case DwellTable(number=int(position)):
            repeat = _REPEAT.match(table.file)
            return Dwell(position, 0.0, int(repeat[1] or 1) if repeat else 0)
        case DwellTable(attitude="free") if numbered and numbered[1] == "free":
            return FreePosition(int(numbered[2]), 0.0)
        case SoakTable(number=position, up=up) if numbered and numbered[1] == "soak":
            return Soak(int(numbered[2]), 0.0, position or 0, up or "")
        case MonitorTable(position=int(position), laws=filters) if numbered and numbered[1] == "monitor":
            return Monitor(int(numbered[2]), 0.0, position, tuple(filters))
    return None


def _site_id(session: Session, site: SiteTable) -> str | None:
    if site.gravity_m_s2 is None:
        return None
    stated = site.latitude_deg, site.gravity_m_s2, site.gravity_std
    return next((row.id for row in fixture_rows(session, SiteRow) if is_surveyed_at(row, *stated)), None)


def write_runs(
    path: Path, buffer: SampleBuffer, runs: Sequence[SampleRun], output: str, utc: Utc | None,
    pulse: PulseForm | None,
) -> str:  # fmt: skip
    """Write the samples of runs to a new file of messages ``output``, with reference time; return its SHA-256."""
    writer, times = StepWriter(path, output), RowTimes(utc)
    rows = StepRows(writer, times, pulse)
    try:
        for run in runs:
            times.reset()  # between two the device's clock may have gone elsewhere
            for chunk, block in buffer.recording([run]):
                rows.write(chunk, block)
        return writer.close()
    except OSError as error:
        writer.abandon()
        raise cannot_write(path, error) from error


def _with_step(tables: CampaignTable, step: Step, file: str, stated: Mapping[str, object]) -> CampaignTable:
    """Return the tables with ``step`` in ``file``, its recording before omitted with its moves."""
    kind, table = _table(step, file)
    table = type(table).model_validate(table.model_dump() | dict(stated))
    there = getattr(tables, kind)
    kept = [one for one in there if (known := step_of(one)) is None or known.name != step.name]
    gone = {one.file for one in there} - {one.file for one in kept}
    moves = [one for one in tables.move if not gone & {one.before, one.after}]
    return tables.model_copy(update={kind: [*kept, table], "move": moves})


def _with_seat(table: DwellTable, seats: Mapping[str, Sequence[float] | None]) -> DwellTable:
    """Return a dwell's table with how the cube sat in it, where ``seats`` says so."""
    step = step_of(table)
    if step is None or step.name not in seats:
        return table
    off = seats[step.name]
    return table.model_copy(update={"kept_seat_rad": None if off is None else list(off)})


def _table(step: Step, file: str) -> tuple[str, StepTable]:
    match step:
        case Dwell(position=position):
            return "dwell", DwellTable.model_validate({**attitude(position), "file": file})
        case FreePosition():
            return "dwell", DwellTable(attitude="free", file=file)
        case Soak(position=position, up=up):
            where = attitude(position) if position else {"up": up} if up else {"attitude": "free"}
            return "soak", SoakTable.model_validate({**where, "file": file})
        case Monitor(position=position, filters=filters):
            return "monitor", MonitorTable(position=position, laws=list(filters), file=file)
        case Turn():
            own = {name: getattr(step, name) for name in ("axis", "direction", "revolutions", "start_position")}
            return "turn", TurnTable.model_validate({**own, "file": file})
