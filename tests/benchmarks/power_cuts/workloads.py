"""What is cut: children that work in an empty folder and say whenever something may be relied upon.

They say a line of JSON: `{"settled": 1}`, all before is on the disk; `{"step": name, "file": ..., "sha256": ...}`,
accepted; `{"files": {path: sha256}}`, written whole; `{"rows": {table: count}}`, stored.
"""

import hashlib
import json
import os
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from drivers.simulated.truth import Truth
from fixtures_db.database import open_db
from fixtures_db.fixture_measurements import dump
from fixtures_db.stored_calibrations import accept_calibration
from procedures.campaign.plan_steps import Step
from station.errors import CannotWrite
from station.files.atomic_file import new_folder
from station.files.database_files import write_csv
from station.files.mcap_files.schemas import RAW_TOPIC
from station.guide.campaign.folder_lock import folder_lock
from station.guide.campaign.folder_recorder import FolderRecorder
from station.guide.campaign.interrupted_campaigns import reopen
from station.stream.live.live_feed import open_feed
from station.stream.reader import Chunk, StreamGap, raw_recording
from station.stream.reader.raw_recording import RawRecording
from station.stream.recorder import plain_recording
from station.stream.recorder.accepted_step_writer import CampaignRecorder, MovedFrom, open_campaign
from tests.benchmarks.edited_databases.honest_databases import of_version
from tests.benchmarks.kills import STEPS, TRUTH, record
from tests.empty_database import of_schema
from tests.fixtures_db.factory import facts, fill_fixtures, solution
from tests.station.applying import inputs
from tests.station.commands.program import quietly
from tests.station.guide.recorded import SITE, TAPE, UNIT, step
from tests.station.results.certificate.factory import accepted
from tests.station.stream.live.bench_in_memory import Source

DATABASE, CAMPAIGN = "data/station.db", "campaigns/day"
OLDEST, BEFORE_JOURNAL = "0001", "0010"
GUIDED, CARRIED = 4, 55
EVERY = 80  # samples from step to step


def say(**what: Any) -> None:
    """Say what may be relied upon from now on."""
    os.write(1, (json.dumps(what) + "\n").encode())  # past a captured stdout


def sha256(path: Path) -> str:
    """Return a file's hash."""
    return hashlib.sha256(path.read_bytes()).hexdigest()


def station(*arguments: object) -> None:
    """Run a command; leave with what it says if it fails."""
    code, output = quietly(*arguments)
    if code:
        raise SystemExit(f"station {arguments[0]}: exit code {code}, {output}")


def written(*paths: Path) -> None:
    """Say that files are written whole."""
    say(files={path.name: sha256(path) for path in paths})


def campaign(home: Path) -> None:
    """Record steps and moves between them, do one again, leave, resume, finish."""
    folder = home / CAMPAIGN
    with open_db(home / DATABASE) as database:
        with new_folder(folder, "campaign.toml"), folder_lock(folder):
            recorder = open_campaign(folder, UNIT, SITE, database)
            FolderRecorder(recorder).keep_steps([step(number) for number in (1, 2, 3, 4)])
            say(begun=1)
            _accept(recorder, 1)
            _accept(recorder, 2, moved=True)
            _accept(recorder, 1)
            _accept(recorder, 3, moved=True)
        with folder_lock(folder):
            recorder = reopen(folder, database)
            _accept(recorder, 2)
            _accept(recorder, 4, moved=True)
            recorder.finish()
            say(finished=1)


def _accept(recorder: CampaignRecorder, position: int, *, moved: bool = False) -> None:
    first = sum(recorder.accepted.values()) * EVERY  # of the tape: no sample is used twice
    last = recorder.tables.dwell[-1].file if moved else ""
    came = MovedFrom(last, (first - 25, first)) if moved else None
    runs = [(first, first + 20), (first + 25, first + EVERY - 25)]
    name = FolderRecorder(recorder).accept(step(position), TAPE, runs, kept_seat=None, turn_on=1, moved=came)
    say(step=step(position).name, file=name, sha256=sha256(recorder.folder / name))


class _Recorded(Source):
    """A device in memory whose bytes go into a raw recording too, as the reader process puts them there."""

    recording: RawRecording

    def poll(self, timeout_s: float) -> list[Chunk | StreamGap]:
        """Return what has come, recorded."""
        items = super().poll(timeout_s)
        for item in items:
            self.recording.put(item)
        return items


def recording(home: Path) -> None:
    """Record plainly from a device in memory, its raw bytes next to it, both synced often."""
    raw_recording.FLUSH_S, raw_recording.SYNC_S, plain_recording.FLUSH_S = 0.0, 0.0, 0.0
    source = _Recorded(Truth.example(5))
    with new_folder(home / "records" / "drive", plain_recording.RECORDING_FILE) as folder:
        source.recording = RawRecording(folder / "session_1.mcap", {}, _refuse, RAW_TOPIC)
        feed = open_feed(source)
        feed.identify()
        done = plain_recording.record(feed, folder, 12.0)
        source.recording.close()
        written(done.path, folder / "session_1.mcap")


def _refuse(error: CannotWrite) -> None:
    raise error


def files(home: Path) -> None:
    """Apply a calibration, export it, write fixtures out: each twice, so that the second replaces the first."""
    calibration, stored = inputs.calibration_file(home), home / "calibration_stored.json"
    log = inputs.write_csv(home / "drive.csv", {name: column[:400] for name, column in inputs.COLUMNS.items()})
    with open_db(home / DATABASE) as database, database.write() as session:
        stored.write_text(accepted(session).document)
        fill_fixtures(session)
        rows = dump(session)
    say(settled=1)
    rounds: tuple[tuple[tuple[str, ...], ...], ...] = (
        ((), (), ()),
        (("--units", "g,deg/s"), ("--float",), ("--nominal-accel", "1000")),
    )
    for units, numbers, nominal in rounds:
        for suffix in ("csv", "npz", "parquet", "mcap"):
            out = home / f"out.{suffix}"
            station("apply", log, "--calibration", calibration, "--out", out, *units)
            written(out, home / f"{out.name}.json")
        for to, ends, more in (("c", ("c", "h"), numbers), ("px4", ("params",), nominal)):
            station("export", stored, "--to", to, *more, "--out", home / f"unit.{ends[-1]}")
            written(*(home / f"unit.{end}" for end in ends))
    bag = home / "bag.x.ros2"
    station("apply", log, "--calibration", calibration, "--out", bag)
    written(*(each for each in bag.iterdir() if each.is_file()))
    write_csv(home / "made" / "export", rows)
    written(*(home / "made" / "export").iterdir())


def fixtures(home: Path) -> None:
    """Make the database, fill it, store calibrations, close and open it between."""
    with open_db(home / DATABASE) as database:
        with database.write() as session:
            fill_fixtures(session)
        say(rows={"slab_levels": 2, "cube_measurements": 2})
    for number in range(1, 7):
        with open_db(home / DATABASE) as database:
            for more in range(3):
                with database.write() as session:
                    accept_calibration(session, solution(number * 1e-3 + more * 1e-4), facts(f"S{number % 2}"))
                say(rows={"calibrations": 3 * (number - 1) + more + 1})


def migration(home: Path) -> None:
    """Open a database of the first schema, with slabs and IMUs."""
    (home / DATABASE).parent.mkdir()
    with of_schema(OLDEST, home / DATABASE) as connection:
        for number in range(40):
            connection.exec_driver_sql(f"INSERT INTO slabs (id) VALUES ('SLAB-{number:03d}{'x' * 60}')")
            connection.exec_driver_sql(f"INSERT INTO imus (model, serial) VALUES ('FOG', 'S{number}')")
    say(settled=1)
    open_db(home / DATABASE).close()
    say(rows={"slabs": 40, "alembic_version": 1}, upgraded=1)


class _Saying(FolderRecorder):
    """Says what it has accepted."""

    def accept(self, step: Step, *args: object, **notes: object) -> str:
        name = super().accept(step, *args, **notes)
        say(step=step.name, file=name, sha256=sha256(self._recorder.folder / name))
        return name


def guided(home: Path) -> None:
    """Let the guide itself see steps and accept them, from a device in memory."""
    folder = home / CAMPAIGN
    with open_db(home / DATABASE) as database, new_folder(folder, "campaign.toml"), folder_lock(folder):
        recorder = open_campaign(folder, open_feed(Source(TRUTH)).identify(), SITE, database)
        say(begun=1)
        for number, step in enumerate(STEPS[:GUIDED]):
            record(number, step, recorder, _Saying)
        recorder.finish()
        say(finished=1)


def journal_begun(home: Path) -> None:
    """Open a filled database from before the journal."""
    (home / DATABASE).parent.mkdir()
    with TemporaryDirectory() as made:
        (home / DATABASE).write_bytes(of_version(BEFORE_JOURNAL, Path(made)).read_bytes())
    say(settled=1)
    open_db(home / DATABASE).close()
    say(rows={"calibrations": 2, "journal": CARRIED}, upgraded=1)


WORKLOADS: dict[str, Callable[[Path], None]] = {
    one.__name__: one for one in (recording, journal_begun, migration, guided, files, fixtures, campaign)
}
