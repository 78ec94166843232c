"""A folder that a killed program left before its campaign began may be begun in; any other may not."""

from pathlib import Path

import pytest

from fixtures_db.database import Database
from station.errors import CannotWrite
from station.files.new_folder import new_folder
from station.guide.unfinished_beginning import clear_unfinished, has_row, is_unfinished
from station.stream.recorder import accepted_step_writer as recording
from station.stream.recorder.accepted_step_writer import write_tables
from tests.station.guide.recorded import begin, die, killed

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
