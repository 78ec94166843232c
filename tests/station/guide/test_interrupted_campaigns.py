"""What a kill leaves is put in order, once; what was given up leaves no trace; what was altered is refused."""

import os
from collections.abc import Callable
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest

from fixtures_db.campaigns import campaign, set_state, verify_steps
from fixtures_db.database import Database, open_db
from fixtures_db.errors import CampaignInUse
from fixtures_db.stored_calibrations import accept_calibration
from procedures.campaign.plan_steps import Turn
from procedures.errors import ErrorCode
from station.errors import CannotWrite, DataRefused
from station.files.atomic_file import new_folder
from station.files.campaign_folder.campaign_reading import read_campaign
from station.files.campaign_folder.plan_file import keep_plan
from station.files.sha256sums import verify_folder
from station.guide.campaign.folder_lock import FolderInUse, folder_lock
from station.guide.campaign.interrupted_campaigns import (
    cancel_campaign,
    clear_unfinished,
    has_row,
    is_unfinished,
    reopen,
)
from station.guide.start_screen import unfinished_campaigns
from station.stream.connected_unit import Unit
from station.stream.recorder import accepted_step_writer as recording
from station.stream.recorder.accepted_step_writer import write_tables
from tests.fixtures_db.factory import facts, solution
from tests.refusals import refused
from tests.station.guide.recorded import accept, begin, die, everything, killed, step

Kill = Callable[[pytest.MonkeyPatch], None]


def rows(database: Database, folder: Path) -> list[tuple[str, bool]]:
    with database.read() as session:
        return [(s.file, s.superseded) for s in campaign(session, str(folder.resolve())).steps]


def after(name: str) -> Kill:
    """Return a patch by which the process dies right after it has done ``name`` of the recorder."""

    def patch(monkeypatch: pytest.MonkeyPatch) -> None:
        real = getattr(recording, name)
        monkeypatch.setattr(recording, name, lambda *a, **k: (real(*a, **k), die()))

    return patch


def before(name: str, owner: object = recording) -> Kill:
    return lambda monkeypatch: monkeypatch.setattr(owner, name, die)


KILLS: dict[str, tuple[Kill, bool]] = {  # where the process dies, and whether the step then counts as accepted
    "before the file has its name": (before("rename", os), False),
    "before its hash": (before("append_hash"), False),
    "after its hash": (after("append_hash"), False),
    "after campaign.toml": (after("write_tables"), True),
    "before the row": (before("accept_step"), True),
    "before the commit": (after("accept_step"), True),
}


@pytest.mark.parametrize("point", KILLS)
@pytest.mark.parametrize("position", [3, 1], ids=["new", "redo"])
def test_a_kill_at_any_point_of_accepting_leaves_a_campaign_that_goes_on(
    db: Database, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, point: str, position: int
) -> None:
    folder = tmp_path / "c"
    accept(begin(folder, db), 1, 2)
    kill, counts = KILLS[point]

    def redo(own: Database) -> None:
        recorder = reopen(folder, own)
        kill(monkeypatch)
        accept(recorder, position)

    killed(tmp_path / "station.db", redo)
    once = reopen(folder, db)
    expected = {1: 1, 2: 1}
    expected[position] = expected.get(position, 0) + counts
    assert once.accepted == {step(p).name: n for p, n in expected.items() if n}
    before_again = everything(db), sorted(p.name for p in folder.iterdir())
    assert reopen(folder, db).accepted == once.accepted
    assert (everything(db), sorted(p.name for p in folder.iterdir())) == before_again
    assert not list(folder.glob("*.part")) + list(folder.glob(".*.part"))
    [again] = accept(once, position)
    assert rows(db, folder)[-1] == (again.name, False)
    assert {d.name for d in read_campaign(folder).campaign.dwells} == {f for f, old in rows(db, folder) if not old}
    verify_folder(folder)
    with db.read() as session:
        assert verify_steps(session) == []


def test_an_orphan_is_kept_and_never_used_again(
    db: Database, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    recorder = begin(tmp_path / "c", db)
    monkeypatch.setattr(recording, "append_hash", die)
    killed(tmp_path / "station.db", lambda own: accept(recorder, 1))
    monkeypatch.undo()
    orphan = (tmp_path / "c" / "dwell_01.mcap").read_bytes()
    [path] = accept(reopen(tmp_path / "c", db), 1)
    assert path.name == "dwell_01_2.mcap"
    assert (tmp_path / "c" / "dwell_01.mcap").read_bytes() == orphan


def test_a_row_that_cannot_be_written_is_no_accepted_step(
    db: Database, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    recorder = begin(tmp_path / "c", db)

    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(recording, "write_tables", full)
    with pytest.raises(OSError, check=lambda error: error.errno == 28):
        accept(recorder, 1)
    monkeypatch.undo()
    accept(recorder, 2)
    assert [d.position for d in read_campaign(tmp_path / "c").campaign.dwells] == [2]
    assert recorder.accepted == {"dwell_02": 1}


def damage(folder: Path, file: str, change: str) -> None:
    path = folder / file
    if change == "gone":
        path.unlink()
    elif change == "bit":
        content = bytearray(path.read_bytes())
        content[len(content) // 2] ^= 1
        path.write_bytes(content)
    elif change == "unnamed":
        toml = folder / "campaign.toml"
        toml.write_text(toml.read_text().partition("[[dwell]]")[0])
    else:
        sums = folder / "SHA256SUMS"
        sums.write_text("".join(line for line in sums.read_text().splitlines(True) if file not in line))


@pytest.mark.parametrize("change", ["gone", "bit", "unnamed", "no hash"])
def test_an_accepted_file_that_is_not_what_it_was_is_refused(db: Database, tmp_path: Path, change: str) -> None:
    folder = tmp_path / "c"
    accept(begin(folder, db), 1, 2, 1)
    reopen(folder, db)
    damage(folder, "dwell_01.mcap", change)  # superseded, and yet a record
    with refused(DataRefused, ErrorCode.ALTERED):
        reopen(folder, db)
    assert len(rows(db, folder)) == 3


def test_a_folder_set_back_to_before_a_redo_is_refused(db: Database, tmp_path: Path) -> None:
    recorder = begin(tmp_path / "c", db)
    accept(recorder, 1)
    old = (tmp_path / "c" / "campaign.toml").read_text()
    accept(recorder, 1)
    (tmp_path / "c" / "campaign.toml").write_text(old)
    with refused(DataRefused, None, "dwell_01_2.mcap"):
        reopen(tmp_path / "c", db)


def test_cancel_leaves_the_database_row_for_row_as_it_was(db: Database, tmp_path: Path) -> None:
    accept(begin(tmp_path / "other", db, Unit("SIM-FOG3", "SIM-1", 0.02)), 1)
    was = everything(db)
    accept(begin(tmp_path / "c", db), 1, 2, 1)
    assert everything(db) != was
    cancel_campaign(tmp_path / "c", db)
    assert everything(db) == was
    assert len(read_campaign(tmp_path / "c").campaign.dwells) == 2
    assert len(verify_folder(tmp_path / "c")) == 3


def test_a_campaign_with_a_stored_calibration_is_neither_cancelled_nor_gone_on_with(
    db: Database, tmp_path: Path
) -> None:
    folder = str((tmp_path / "c").resolve())
    begin(tmp_path / "c", db)
    with db.write() as session:
        accept_calibration(session, solution(), facts(), campaign_folder=folder)
        set_state(session, folder, "accepted")
    for act in (cancel_campaign, reopen):
        with pytest.raises(CampaignInUse):
            act(tmp_path / "c", db)
    assert unfinished_campaigns(db) == []


def test_unfinished_campaigns_are_listed_with_what_is_done_the_empty_ones_last(
    db: Database, tmp_path: Path
) -> None:
    accept(begin(tmp_path / "one", db), 1, 2, 1)
    keep_plan(tmp_path / "one", (step(1), step(2), Turn("x", "+", 3, 1, 5.0)))
    begin(tmp_path / "two", db)
    yesterday = datetime.now(UTC) - timedelta(days=1)
    with db.write() as session:
        campaign(session, str((tmp_path / "one").resolve())).started_utc = yesterday
    first, second = unfinished_campaigns(db)
    began = yesterday.astimezone()
    assert first.title == f"campaign of {began:%Y-%m-%d %H:%M}, 2 of 3 done, SIM-FOG3 SIM-7"
    assert (first.done, first.serial, first.state) == (2, "SIM-7", "free")
    assert second.title.endswith(", 0 of 18 done, SIM-FOG3 SIM-7")
    assert len(second.title.split(",")[0]) == len("campaign of 12:40")
    with folder_lock(tmp_path / "one"):
        assert [each.state for each in unfinished_campaigns(db)] == ["in use", "free"]
    (tmp_path / "two").rename(tmp_path / "moved")
    assert [each.state for each in unfinished_campaigns(db)] == ["free", "not here"]


def test_a_folder_has_one_station_and_a_killed_one_lets_it_go(db: Database, tmp_path: Path) -> None:
    folder = tmp_path / "c"
    begin(folder, db)

    def hold(own: Database) -> None:
        with folder_lock(folder):
            die()

    with folder_lock(folder), pytest.raises(FolderInUse), folder_lock(folder):
        pass
    assert not (folder / ".lock").exists()
    killed(tmp_path / "station.db", hold)
    assert (folder / ".lock").exists()
    assert [each.state for each in unfinished_campaigns(db)] == ["free"]
    with folder_lock(folder):
        assert [each.state for each in unfinished_campaigns(db)] == ["in use"]


def test_two_stations_on_one_database_do_not_disturb_each_other(db: Database, tmp_path: Path) -> None:
    with open_db(tmp_path / "station.db") as other:
        here = begin(tmp_path / "here", db)
        there = begin(tmp_path / "there", other, Unit("SIM-FOG3", "SIM-8", 0.02))
        for position in range(1, 5):
            accept(here, position)
            accept(there, position)
        cancel_campaign(tmp_path / "there", other)
    assert [file for file, _ in rows(db, tmp_path / "here")] == [f"dwell_{p:02d}.mcap" for p in range(1, 5)]
    assert reopen(tmp_path / "here", db).accepted == here.accepted


def test_a_row_always_has_its_folder(db: Database, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(recording, "write_tables", die)
    killed(tmp_path / "station.db", lambda own: begin(tmp_path / "c", own))
    assert unfinished_campaigns(db) == []


SESSION = "session_20260720T172634092836Z.mcap"
NOTES = ["setup.json", "unit.json", "plan.toml", ".campaign.toml.0123456789ab.tmp"]


def filled(folder: Path, *names: str) -> Path:
    folder.mkdir()
    for name in names:
        (folder / name).write_text("kept")
    return folder


@pytest.mark.parametrize(
    "names", [[], [".lock"], [SESSION], [".lock", SESSION, *NOTES], [SESSION, "campaign.toml"]]
)
def test_a_beginning_is_begun_in_and_what_was_read_stays(tmp_path: Path, names: list[str]) -> None:
    folder = filled(tmp_path / "c", *names)
    with new_folder(folder, "campaign.toml", is_unfinished):
        clear_unfinished(folder)
        (folder / "campaign.toml").write_text("")
    assert {file.name for file in folder.iterdir()} == {"campaign.toml", *{SESSION, ".lock"}.intersection(names)}


@pytest.mark.parametrize(
    "names", [["plan.toml"], [SESSION, "campaign.toml", "dwell_01.mcap"], ["campaign.toml"], ["a"]]
)
def test_what_somebody_else_put_there_is_not(tmp_path: Path, names: list[str]) -> None:
    folder = filled(tmp_path / "c", *names)
    with pytest.raises(CannotWrite), new_folder(folder, "campaign.toml", is_unfinished):
        pass
    assert sorted(file.name for file in folder.iterdir()) == sorted(names)


def test_one_killed_before_its_row_is_begun_in_and_one_that_has_a_row_is_not(db: Database, tmp_path: Path) -> None:
    folder, where = tmp_path / "c", tmp_path / "station.db"

    def begun(database: Database) -> None:
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(recording, "write_tables", lambda *tables: die(write_tables(*tables)))
            begin(folder, database)

    killed(where, begun)
    (folder / SESSION).write_text("kept")
    assert (folder / "campaign.toml").exists()
    assert is_unfinished([file.name for file in folder.iterdir()], has_row(db, folder))
    clear_unfinished(folder)
    assert [file.name for file in folder.iterdir()] == [SESSION]
    begin(tmp_path / "other", db)
    assert has_row(db, tmp_path / "other")
    assert not is_unfinished([SESSION, "campaign.toml"], has_row=True)
