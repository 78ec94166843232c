"""The start of a guided calibration: what can be chosen."""

from collections.abc import Sequence
from datetime import date

from drivers.serial_port import list_ports
from fixtures_db.campaigns import is_expired
from fixtures_db.database import Database
from fixtures_db.fixtures import fixture_rows
from fixtures_db.schema import CubeRow, SlabRow
from station.files.setup import Setup
from station.guide.open_campaigns import unfinished_campaigns
from station.guide.setup_view import Choice, StartView


def start_view(database: Database, setup: Setup) -> StartView:
    """Return what can be chosen: ports, cubes and slabs with their certificates, unfinished campaigns."""
    with database.read() as session:
        known = [(cube.id, f"{cube.side_mm:g} mm", cube.due_date) for cube in fixture_rows(session, CubeRow)]
        stones = [(slab.id, "", slab.due_date) for slab in fixture_rows(session, SlabRow)]
    return StartView(
        setup=setup,
        ports=tuple(_ports()),
        cubes=tuple(_reference(*each) for each in known),
        slabs=tuple(_reference(*each) for each in stones),
        unfinished=tuple(unfinished_campaigns(database)),
    )


def _ports() -> Sequence[Choice]:
    return [
        Choice(
            key=f"serial://{port.device}",
            title=f"{port.device} {port.description}".strip(),
            note=f"serial number {port.serial_number}" if port.serial_number else "",
        )
        for port in list_ports()
    ]


def _reference(name: str, size: str, due: date | None) -> Choice:
    warns = due is None or is_expired(due, date.today())
    note = f"certificate {'expired on' if warns else 'due'} {due}" if due else "no certificate date"
    return Choice(key=name, title=f"{name} {size}".strip(), note=note, warns=warns)
