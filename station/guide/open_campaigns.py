"""The campaigns that can be gone on with, as the start screen lists them."""

import tomllib
from datetime import UTC, datetime
from pathlib import Path
from typing import Literal

from fixtures_db.campaigns import in_state
from fixtures_db.database import Database
from fixtures_db.schema import CampaignRow
from station.guide.folder_lock import is_locked
from station.guide.setup_view import UnfinishedCampaign

USUAL_STEPS = 18  # of a campaign without a plan: 12 positions, 6 turns
TOML, PLAN = "campaign.toml", "plan.toml"


def unfinished_campaigns(database: Database) -> list[UnfinishedCampaign]:
    """Return the campaigns in state ``recording``, newest first."""
    with database.read() as session:
        return [_described(row) for row in in_state(session, "recording")]


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
