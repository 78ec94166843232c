"""A disk that fills up: what was accepted stays whole, what was not is said, and with room again it goes on."""

import contextlib
import re
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest
from sqlalchemy import text

from drivers.simulated.server import SimulatedDevice
from drivers.simulated.truth import Truth
from drivers.wire import FORMATS
from fixtures_db.campaigns import campaign
from fixtures_db.database import Database, open_db
from fixtures_db.errors import NotWritten
from procedures.campaign.plan_steps import Dwell
from procedures.errors import ErrorCode
from station import cli
from station.errors import CannotWrite, DiskFull
from station.files.atomic_file import replace_file
from station.files.campaign_folder.campaign_reading import read_campaign
from station.files.sha256sums import verify_folder
from station.stream.live.live_feed import LiveFeed, open_feed
from station.stream.live.stillness import runs_of_blocks
from station.stream.recorder.accepted_step_writer import CampaignRecorder, open_campaign
from station.stream.recorder.sample_stream import check_raw_bytes
from tests.patience import paced
from tests.refusals import refused
from tests.station.commands.program import Program
from tests.station.stream.live.bench_in_memory import SITE, Source

PAGE = 4096


class SmallDisk:
    """A disk of 1 MiB, unless a test asks for another size."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def fill(self, but: int) -> None:
        """Leave no more than ``but`` bytes."""
        with (self.path / "ballast").open("wb", buffering=0) as stream:
            for size in (256 * PAGE, PAGE):
                with contextlib.suppress(OSError):
                    while True:
                        stream.write(bytes(size))
            stream.truncate(stream.tell() - but)

    def empty(self) -> None:
        """Make room again."""
        (self.path / "ballast").unlink(missing_ok=True)


@pytest.fixture
def disk(tmp_path: Path, request: pytest.FixtureRequest) -> Iterator[SmallDisk]:
    path = tmp_path / "disk"
    path.mkdir()
    size = getattr(request, "param", "1m")
    mount = ["mount", "-t", "tmpfs", "-o", f"size={size}", "tmpfs", str(path)]
    done = subprocess.run(mount, capture_output=True, text=True, check=False)
    if done.returncode:
        pytest.skip(f"no small disk can be mounted here: {done.stderr.strip()}")
    yield SmallDisk(path)
    subprocess.run(["umount", "--lazy", str(path)], check=True)


def accept(recorder: CampaignRecorder, feed: LiveFeed, position: int) -> None:
    blocks = feed.blocks()
    runs = runs_of_blocks([next(blocks) for _ in range(5)], None)
    try:
        recorder.accept(Dwell(position, 5.0), feed.buffer, runs)
    finally:
        feed.buffer.forget_before(feed.buffer.end)


def rows_of(folder: Path, database: Database) -> list[str]:
    """Return the files of the steps in a database that is whole."""
    with database.read() as session:
        assert session.execute(text("PRAGMA integrity_check")).scalar() == "ok"
        return [step.file for step in campaign(session, str(folder.resolve())).steps]


def assert_whole(folder: Path) -> None:
    """Every step that the campaign names is there as it was recorded, counts and bytes."""
    names = [dwell.name for dwell in read_campaign(folder).campaign.dwells]
    assert set(names) <= set(verify_folder(folder))
    for name in names:
        assert check_raw_bytes(folder / name, FORMATS["counts"]) == 250


def test_wherever_the_disk_is_full_the_accepted_steps_stay_whole(disk: SmallDisk) -> None:
    folder = disk.path / "campaign"
    folder.mkdir()
    feed = open_feed(Source(Truth.example(1)))
    refused = list[str]()
    with open_db(disk.path / "station.db") as database:
        recorder = open_campaign(folder, feed.identify(), SITE, database)
        accept(recorder, feed, 1)
        for left in range(0, 40 * PAGE, PAGE):
            disk.fill(but=left)
            try:
                accept(recorder, feed, 2)
            except (CannotWrite, NotWritten) as error:
                refused.append(str(error))
            else:
                break
            assert_whole(folder)
            assert rows_of(folder, database) == ["dwell_01.mcap"]
        disk.empty()
        accept(recorder, feed, 3)
        assert len(rows_of(folder, database)) == 3
    assert_whole(folder)
    assert [dwell.position for dwell in read_campaign(folder).campaign.dwells] == [1, 2, 3]
    for where in (".dwell_02.mcap.part", "SHA256SUMS", "station.db"):
        assert any(where in line and "disk full" in line for line in refused), refused


@pytest.mark.parametrize("disk", ["64m"], indirect=True)
def test_a_disk_that_fills_up_during_a_dwell_ends_the_program_and_resume_goes_on(disk: SmallDisk) -> None:
    folder, database = disk.path / "c", ("--db", str(disk.path / "s.db"))
    short = ("--latitude", "31.17", "--dwell-s", "5", "--turns", "1", "--move-s", "5", "--out", str(folder))
    with SimulatedDevice(Truth.example(5), 5, speed=paced(100.0)) as device:
        hands = ("--headless", "--hands", device.control)
        with Program("calibrate", *hands, "--device", device.url, *short, *database) as program:
            program.until("accepted: position 2")
            disk.fill(but=0)
            code, _, error = program.end()
        assert code == 2
        assert error.count("\n") == 1
        assert "disk full" in error
        names = [dwell.name for dwell in read_campaign(folder).campaign.dwells]
        assert names[:2] == ["dwell_01.mcap", "dwell_02.mcap"]
        disk.empty()
        assert cli.run(["verify", str(folder), *database]) == 0
        with open_db(database[1]) as opened:
            assert rows_of(folder, opened) == names
        with Program("resume", str(folder), *hands, *database) as program:
            program.until(f"{len(names) + 1} of 19 done")


def test_a_campaign_without_room_is_refused_before_it_begins_with_what_it_needs(disk: SmallDisk) -> None:
    with SimulatedDevice(Truth.example(5), 5, speed=paced(100.0)) as device:
        where = ("--device", device.url, "--latitude", "31.17", "--out", str(disk.path / "c"))
        with Program("calibrate", "--headless", *where, "--db", str(disk.path / "s.db")) as program:
            code, _, error = program.end()
    assert code == 2
    assert re.search(r"\d+ (MB|kB) free, \d+ MB needed", error), error
    assert not (disk.path / "c").exists()


def test_every_file_that_is_written_whole_says_how_much_room_it_wanted(disk: SmallDisk) -> None:
    disk.fill(but=PAGE)
    with refused(DiskFull, ErrorCode.DISK_FULL, "report.html", "3 MB"):
        replace_file(disk.path / "report.html", bytes(3_000_000))
    assert [path.name for path in disk.path.iterdir()] == ["ballast"]
