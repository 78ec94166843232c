"""What the start screen offers (ports, cubes, slabs, campaigns to resume), and how ready the set-up is.

Readiness is computed in the background: the form waits neither for the database nor for what that imports.
"""

import tomllib
from concurrent.futures import Executor, Future
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING

from drivers.serial_port import list_ports
from fixtures_db.campaigns import day_of, in_state, is_expired
from fixtures_db.database import Database
from fixtures_db.errors import DatabaseError
from fixtures_db.fixtures import fixture_rows
from fixtures_db.schema import CampaignRow, CubeRow, SlabRow
from station.files.campaign_setup import Setup
from station.guide.campaign.folder_lock import is_locked
from station.guide.options import CalibrationOptions
from station.guide.setup_view import Choice, PortCheck, Readiness, StartView, UnfinishedCampaign

if TYPE_CHECKING:
    from station.guide.campaign.live_campaign import GuidedCampaign

Asked = tuple[Setup, PortCheck | None, PortCheck | None]  # set-up, the looks at its port and at its receiver


class ReadinessInBackground:
    """Answers the newest request; those that came in between are dropped."""

    def __init__(self, database: Database, options: CalibrationOptions, aside: Executor) -> None:
        self._database, self._options, self._aside = database, options, aside
        self._answer: Future[Readiness] | None = None
        self._next: Asked | None = None

    def ask(self, setup: Setup, check: PortCheck | None, receiver: PortCheck | None) -> None:
        """Ask how ready a set-up is."""
        self._next = (setup, check, receiver)
        self._begin()

    def answered(self) -> Readiness | None:
        """Return an answer once, None while there is no new one."""
        if self._answer is None or not self._answer.done():
            return None
        answer, self._answer = self._answer, None
        self._begin()
        return None if isinstance(answer.exception(), DatabaseError) else answer.result()

    def _begin(self) -> None:
        if self._answer is None and self._next is not None:
            asked, self._next = self._next, None
            self._answer = self._aside.submit(current_readiness, self._database, self._options, *asked)


def current_readiness(
    database: Database, options: CalibrationOptions, setup: Setup, check: PortCheck | None,
    receiver: PortCheck | None,
) -> Readiness:  # fmt: skip
    """Return how ready a set-up is now; a look at another port than the set-up's says nothing."""
    from station.guide.campaign.campaign_start import usual_steps
    from station.guide.campaign.readiness import read_prior_knowledge, readiness

    rate = check.rate_hz if check is not None and check.url == setup.url else None
    steps = tuple(options.steps)
    facts = read_prior_knowledge(database, options.root, steps or usual_steps(setup), rate, usual=not steps)
    return readiness(setup, facts, check, receiver)


def announce_readiness(
    campaign: "GuidedCampaign", database: Database, options: CalibrationOptions
) -> Readiness | None:
    """Tell the operator how a campaign can end whose unit has answered, before anything is recorded."""
    from station.files.campaign_folder.plan_file import read_note

    if (unit := campaign.unit_check()) is None:
        return None
    setup = (read_note(campaign.folder, Setup) or Setup()).model_copy(update={"url": unit.url})
    receiver = PortCheck(url=setup.gnss, is_good=True, text="connected")
    ready = current_readiness(database, options, setup, unit, receiver)
    campaign.say("", "this run " + ", ".join(ready.outcomes))
    return ready


USUAL_STEPS = 18  # of a campaign without a plan: 12 positions, 6 turns
TOML, PLAN = "campaign.toml", "plan.toml"


def start_view(database: Database, setup: Setup) -> StartView:
    """Return what can be chosen: ports, cubes and slabs with their certificates, unfinished campaigns."""
    with database.read() as session:
        cubes = [_reference(row, f" {row.side_mm:g} mm") for row in fixture_rows(session, CubeRow)]
        slabs = [_reference(row) for row in fixture_rows(session, SlabRow)]
    ports = [_port(port.device, port.description, port.serial_number) for port in list_ports()]
    return StartView(
        setup=setup, ports=tuple(ports), cubes=tuple(cubes), slabs=tuple(slabs),
        unfinished=tuple(unfinished_campaigns(database)),
    )  # fmt: skip


def _port(device: str, description: str, serial: str | None) -> Choice:
    note = f"serial number {serial}" if serial else ""
    return Choice(key=f"serial://{device}", title=f"{device} {description}".strip(), note=note)


def _reference(row: CubeRow | SlabRow, size: str = "") -> Choice:
    due = row.due_date
    warns = due is None or is_expired(due, day_of(datetime.now(UTC)))
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
    title = f"campaign of {when}, {done} of {total} done, {row.imu.model} {row.imu.serial}"
    return UnfinishedCampaign(
        folder=row.folder, title=title, serial=row.imu.serial, done=done,
        state="not here" if not (folder / TOML).is_file() else "in use" if is_locked(folder) else "free",
    )  # fmt: skip


def _planned(folder: Path) -> int:
    """Count the steps of the folder's plan; reading them takes what a list should not wait for."""
    try:
        tables = tomllib.loads((folder / PLAN).read_text()).values()
    except (OSError, ValueError):
        return USUAL_STEPS
    return sum(len(table) for table in tables if isinstance(table, list)) or USUAL_STEPS
