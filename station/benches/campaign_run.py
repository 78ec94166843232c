"""A whole campaign on a live device: twelve positions, then hand turns, recorded step by step."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from datetime import UTC, date, datetime
from pathlib import Path

from fixtures_db.cubes import cube, cube_row
from fixtures_db.database import Database
from procedures import hand_turns, twelve_position
from procedures.campaign import Fixture
from procedures.steps import run
from station.benches.hands import Hands
from station.benches.headless import HeadlessBench
from station.benches.live_feed import open_feed
from station.benches.progress import Progress
from station.campaign_folder.schema import FaceTable, FixtureTable, ProcedureTable, SiteTable
from station.errors import CannotWrite
from station.reader import Reader
from station.recorder import Unit, open_campaign
from station.recorder.campaign import TOML


@dataclass(frozen=True, slots=True)
class CampaignRequest:
    """What to record: from which device, where, on which cube, and for how long.

    ``dwell_s`` and ``rest_s`` are device time [s]; ``revolutions`` per turn; ``model`` and ``serial`` are for
    devices that do not say theirs.
    """

    url: str
    folder: Path
    site: SiteTable
    procedure: ProcedureTable = field(default_factory=ProcedureTable)
    cube_id: str | None = None
    dwell_s: float = 100.0
    revolutions: int = 3
    rest_s: float = 5.0
    model: str | None = None
    serial: str | None = None


def record_campaign(
    request: CampaignRequest,
    hands: Hands,
    database: Database,
    progress: Callable[[Progress], None],
    connected: Callable[[Unit], None] = lambda unit: None,
) -> Unit:
    """Record a campaign into a new folder; every accepted step stays, whatever happens after it.

    Raises
    ------
    DriverError
        What the port, the link or the unit refuse.
    CannotWrite
        If the folder is there already with something in it, or the disk refuses.
    NotInDatabase
        If there is no such cube.
    """
    fixture, table = cube_fixture(database, request.cube_id)
    with new_folder(request.folder, TOML) as folder, Reader(request.url, folder / journal_name()) as reader:
        feed = open_feed(reader)
        unit = feed.identify(request.model, request.serial)
        connected(unit)
        recorder = open_campaign(
            folder, unit, request.site, database,
            fixture=table, procedure=request.procedure, cube_id=request.cube_id,
        )  # fmt: skip
        bench = HeadlessBench(feed, hands, recorder, fixture.C_ib, progress)
        run(twelve_position.plan(request.dwell_s), bench)
        run(hand_turns.plan(request.revolutions, request.rest_s), bench)
        recorder.finish()
    return unit


def cube_fixture(database: Database, cube_id: str | None) -> tuple[Fixture, FixtureTable]:
    """Return a cube of the database as a solve takes it and as ``campaign.toml`` says it."""
    if cube_id is None:
        return Fixture(), FixtureTable()
    with database.read() as session:
        fixture, side = cube(session, cube_id), cube_row(session, cube_id).side_mm
    faces = [
        FaceTable.model_validate(
            {"resting": name, "up_tilt_rad": face.up_tilt.tolist(), "covariance_rad2": face.covariance.tolist()}
        )
        for name, face in fixture.faces.items()
    ]
    return fixture, FixtureTable(id=cube_id, side_mm=side, face=faces)


def is_expired(database: Database, cube_id: str | None) -> bool:
    """Say whether a cube's certificate is past its due date."""
    if cube_id is None:
        return False
    with database.read() as session:
        due = cube_row(session, cube_id).due_date
    return due is not None and due < date.today()


@contextmanager
def new_folder(folder: Path, sign: str) -> Iterator[Path]:
    """Make a folder; take it away again if no file named ``sign`` came into it.

    Raises
    ------
    CannotWrite
        If it cannot be made or is not empty.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        if any(folder.iterdir()):
            raise CannotWrite(folder, "it is not empty, expected a new folder")
    except OSError as error:
        if isinstance(error, CannotWrite):
            raise
        raise CannotWrite(folder, error.strerror or str(error)) from error
    try:
        yield folder
    finally:
        if not (folder / sign).exists():
            for journal in folder.glob("session_*.mcap"):
                journal.unlink()
            folder.rmdir()


def journal_name() -> str:
    """Return the name of a session's journal."""
    return f"session_{datetime.now(UTC):%Y%m%dT%H%M%SZ}.mcap"
