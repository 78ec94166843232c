"""Campaigns recorded from a simulated device in memory, without a bench: a second of rest is a dwell."""

import os
import signal
from collections.abc import Callable
from pathlib import Path

from sqlalchemy import text

from drivers.simulated.device import ByteDevice
from drivers.simulated.truth import Truth
from drivers.wire import FORMATS
from fixtures_db.database import Database, open_db
from procedures.campaign.plan_steps import Dwell, Step
from station.files.campaign_folder.campaign_schema import SiteTable
from station.stream.connected_unit import Unit
from station.stream.reader import Chunk
from station.stream.recorder.accepted_step_writer import CampaignRecorder, open_campaign
from station.stream.recorder.sample_buffer import SampleBuffer
from station.stream.recorder.sample_stream import SampleStream

WIRE = FORMATS["counts"]
UNIT = Unit("SIM-FOG3", "SIM-7", 0.02)
SITE = SiteTable(latitude_deg=31.17, gravity_m_s2=Truth().local_gravity)
SAMPLES = 50


def taped(seconds: int = 12) -> SampleBuffer:
    """Return the first seconds of a simulated unit."""
    device, stream, buffer = ByteDevice(Truth.example(7), 1, "counts"), SampleStream(WIRE), SampleBuffer()
    while buffer.end < seconds * SAMPLES:
        for part in device.chunk():
            assert isinstance(part, bytes)
            buffer.append(stream.take(Chunk(round(device.imu.time * 1e9), part)))
    return buffer


TAPE = taped()


def begin(folder: Path, database: Database, unit: Unit = UNIT, **more: str) -> CampaignRecorder:
    folder.mkdir()
    return open_campaign(folder, unit, SITE, database, **more)


def accept(recorder: CampaignRecorder, *positions: int) -> list[Path]:
    """Accept a second of the buffer, ever another one, as each position."""
    accepted = list[Path]()
    for position in positions:
        first = sum(recorder.accepted.values()) % 12 * SAMPLES
        accepted.append(recorder.accept(step(position), TAPE, [(first, first + SAMPLES)]))
    return accepted


def step(position: int) -> Step:
    return Dwell(position, 1.0)


def everything(database: Database) -> dict[str, list[tuple[object, ...]]]:
    """Return all rows of all tables but the journal, which says of each what became of it."""
    with database.read() as session:
        names = session.execute(text("SELECT name FROM sqlite_master WHERE type = 'table' AND name <> 'journal'"))
        return {
            name: [tuple(row) for row in session.execute(text(f"SELECT * FROM {name}"))] for (name,) in names.all()
        }


def killed(where: Path, do: Callable[[Database], None]) -> None:
    """Run ``do`` in a process of its own, on its own connection to the database; it must die of SIGKILL."""
    child = os.fork()
    if not child:
        with open_db(where) as database:
            do(database)
        os._exit(0)
    _, status = os.waitpid(child, 0)
    assert os.WIFSIGNALED(status)
    assert os.WTERMSIG(status) == signal.SIGKILL


def die(*_: object, **__: object) -> None:
    os.kill(os.getpid(), signal.SIGKILL)
