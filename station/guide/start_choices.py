"""What the start screen offers: ports, cubes and slabs to choose, campaigns to resume."""

import tomllib
from datetime import UTC, date, datetime
from pathlib import Path
from typing import Literal

from drivers.serial_port import list_ports
from fixtures_db.campaigns import in_state, is_expired
from fixtures_db.database import Database
from fixtures_db.fixtures import fixture_rows
from fixtures_db.schema import CampaignRow, CubeRow, SlabRow
from station.files.campaign_setup import Setup
from station.guide.folder_lock import is_locked
from station.guide.setup_view import Choice, StartView, UnfinishedCampaign

USUAL_STEPS = 18  # of a campaign without a plan: 12 positions, 6 turns
TOML, PLAN = "campaign.toml", "plan.toml"


def start_view(database: Database, setup: Setup) -> StartView:
    """Return what can be chosen: ports, cubes and slabs with their certificates, unfinished campaigns."""
    with database.read() as session:
        cubes = [_reference(row, f" {row.side_mm:g} mm") for row in fixture_rows(session, CubeRow)]
        slabs = [_reference(row) for row in fixture_rows(session, SlabRow)]
    return StartView(
        setup=setup,
        ports=tuple(
            Choice(
                key=f"serial://{port.device}",
                title=f"{port.device} {port.description}".strip(),
                note=f"serial number {port.serial_number}" if port.serial_number else "",
            )
            for port in list_ports()
        ),
        cubes=tuple(cubes),
        slabs=tuple(slabs),
        unfinished=tuple(unfinished_campaigns(database)),
    )


def _reference(row: CubeRow | SlabRow, size: str = "") -> Choice:
    due = row.due_date
    warns = due is None or is_expired(due, date.today())
    note = f"certificate {'expired on' if warns else 'due'} {due}" if due else "no certificate date"
    return Choice(key=row.id, title=f"{row.id}{size}", note=note, warns=warns)


def unfinished_campaigns(database: Database) -> list[UnfinishedCampaign]:
    """Return the campaigns in state ``recording``, newest first, those of which nothing was recorded last."""
    with database.read() as session:
        found = [_described(row) for row in in_state(session, "recording")]
    return sorted(found, key=lambda one: not one.done)


def _described(row: CampaignRow) -> UnfinishedCampaign:
    folder = Path(row.folder)
    done = len({step.name for step in row.steps})
    total = max(_planned(folder), done)
    began = row.started_utc.astimezone()
    is_today = began.date() == datetime.now(UTC).astimezone().date()
    when = f"{began:%H:%M}" if is_today else f"{began:%Y-%m-%d %H:%M}"
    return UnfinishedCampaign(
        folder=row.folder,
        title=f"campaign of {when}, {done} of {total} done, {row.imu.model} {row.imu.serial}",
        serial=row.imu.serial,
        done=done,
        total=total,
        state=_state(folder),
    )


def _state(folder: Path) -> Literal["free", "in use", "not here"]:
    if not (folder / TOML).is_file():
        return "not here"
    return "in use" if is_locked(folder) else "free"


def _planned(folder: Path) -> int:
    """Count the steps of the folder's plan; reading them takes what a list should not wait for."""
    try:
        tables = tomllib.loads((folder / PLAN).read_text()).values()
    except (OSError, ValueError):
        return USUAL_STEPS
    return sum(len(table) for table in tables if isinstance(table, list)) or USUAL_STEPS
