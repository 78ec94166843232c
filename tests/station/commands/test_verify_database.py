"""Whatever byte of a stored row is changed behind the database's back: `station verify` finds it and names it."""

import hashlib
import shutil
import sqlite3
from datetime import date
from pathlib import Path

import numpy as np
import pytest

from fixtures_db.database import Database, open_db
from fixtures_db.fixture_measurements import certify_faces
from fixtures_db.fixtures import add_fixture
from fixtures_db.hash_chain import Link, faults
from fixtures_db.schema import CubeRow
from fixtures_db.stored_calibrations import accept_calibration, history
from procedures.campaign.campaign import FaceCertificate
from station import cli
from tests.fixtures_db.factory import NOON, facts, solution
from tests.station.guide.recorded import accept, begin


def fill(database: Database, folder: Path) -> None:
    """Put three calibrations, two certificates and a campaign of three steps into a database."""
    face = FaceCertificate(np.array([1e-5, -2e-5]), np.eye(2) * 25e-12)
    with database.write() as session:
        add_fixture(session, CubeRow(id="CUBE-7", side_mm=400.0))
        faces, due = {"x_up": face, "y_up": face}, date(2030, 1, 1)
        certify_faces(session, "CUBE-7", faces, source="CMM", measured_utc=NOON, due_date=due)
        for bias in (1e-3, 2e-3, 3e-3):
            accept_calibration(session, solution(bias), facts("SIM-7"))
    accept(begin(folder, database), 1, 2, 1)


@pytest.fixture(scope="module")
def filled(tmp_path_factory: pytest.TempPathFactory) -> Path:
    home = tmp_path_factory.mktemp("filled")
    with open_db(home / "station.db") as database:
        fill(database, home / "c")
    return home


def tampered(home: Path, to: Path, statement: str, *values: object) -> Path:
    """Copy a database and change it as SQLite's own library lets anyone do."""
    path = to / "altered.db"
    shutil.copy(home / "station.db", path)
    connection = sqlite3.connect(path)
    for (trigger,) in connection.execute("SELECT name FROM sqlite_master WHERE type = 'trigger'").fetchall():
        connection.execute(f"DROP TRIGGER {trigger}")
    assert connection.execute(statement, values).rowcount == 1
    connection.commit()
    connection.close()
    return path


def reported(path: Path, capsys: pytest.CaptureFixture[str], *folder: str) -> tuple[int, str]:
    code = cli.run(["verify", *folder, "--db", str(path)])
    captured = capsys.readouterr()
    assert captured.err.count("\n") <= 1
    return code, captured.out + captured.err


def test_an_untouched_database_verifies(filled: Path, capsys: pytest.CaptureFixture[str]) -> None:
    code, text = reported(filled / "station.db", capsys)
    assert code == 0
    assert "as stored" in text
    code, text = reported(filled / "station.db", capsys, str(filled / "c"))
    assert code == 0
    assert "3 accepted steps as stored" in text


def test_every_single_byte_of_every_document_counts(filled: Path) -> None:
    with open_db(filled / "station.db") as database, database.read() as session:
        rows = history(session, "SIM-7")
        links = [Link(f"calibration {row.id}", row.document, row.previous, row.sha256) for row in rows]
    assert faults(links) == []
    for number, link in enumerate(links):
        for at in range(len(link.text)):
            text = link.text[:at] + chr(ord(link.text[at]) ^ 1) + link.text[at + 1 :]
            changed = [*links[:number], Link(link.row, text, link.previous, link.sha256), *links[number + 1 :]]
            assert faults(changed)[0].row == link.row


@pytest.mark.parametrize("share", [0.1, 0.999])
@pytest.mark.parametrize("bit", [1, 0x80], ids=["another character", "no text any more"])
@pytest.mark.parametrize("row", [3])
def test_a_byte_of_a_stored_document_is_found(
    filled: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], share: float, bit: int, row: int
) -> None:
    connection = sqlite3.connect(filled / "station.db")
    [(document,)] = connection.execute("SELECT document FROM calibrations WHERE id = ?", (row,)).fetchall()
    connection.close()
    content = bytearray(document.encode())
    content[int(share * len(content))] ^= bit
    change = "UPDATE calibrations SET document = CAST(? AS TEXT) WHERE id = ?"
    code, text = reported(tampered(filled, tmp_path, change, bytes(content), row), capsys)
    assert code == 1
    assert f"calibration {row}: found" in text or f"calibrations {row}: found" in text


@pytest.mark.parametrize(
    ("table", "column", "row"),
    [
        *(
            ("calibrations", column, "calibration 2")
            for column in ("sha256", "previous", "inputs", "code_version")
        ),
        *(("calibrations", column, "calibration") for column in ("accepted_utc", "imu_id")),
        *(
            ("face_certificates", column, "face certificate 2")
            for column in ("sha256", "previous", "resting", "up_tilt_1_rad", "covariance_12_rad2", "source")
        ),
        *(("face_certificates", column, "face") for column in ("measured_utc", "due_date", "cube_id")),
        *(("steps", column, "/c: ") for column in ("sha256", "file", "name")),
    ],
)
def test_a_changed_column_is_found(
    filled: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], table: str, column: str, row: str
) -> None:
    connection = sqlite3.connect(filled / "station.db")
    [(value,)] = connection.execute(f"SELECT {column} FROM {table} WHERE id = 2").fetchall()
    connection.close()
    new = value + 1e-9 if isinstance(value, float) else value + 1 if isinstance(value, int) else flipped(value)
    code, text = reported(tampered(filled, tmp_path, f"UPDATE {table} SET {column} = ? WHERE id = 2", new), capsys)
    assert code == 1
    assert row in text


def flipped(text: str) -> str:
    """Return a text with its last letter or digit changed."""
    at = max(i for i, letter in enumerate(text) if letter.isalnum())
    return text[:at] + ("2" if text[at] != "2" else "3") + text[at + 1 :]


def test_a_step_s_hash_in_the_database_and_in_the_folder_must_agree(
    filled: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with open_db(tmp_path / "station.db") as database:
        accept(begin(tmp_path / "c", database), 1, 2)
    folder = tmp_path / "c"
    content = (folder / "dwell_02.mcap").read_bytes() + b"\0"
    (folder / "dwell_02.mcap").write_bytes(content)  # and the hash in the folder made to fit
    lines = (folder / "SHA256SUMS").read_text().splitlines()
    lines[1] = f"{hashlib.sha256(content).hexdigest()}  dwell_02.mcap"
    (folder / "SHA256SUMS").write_text("\n".join(lines) + "\n")
    code, text = reported(tmp_path / "station.db", capsys, str(folder))
    assert code == 1
    assert "dwell_02.mcap: found sha256" in text
    assert "in the database" in text
    code, text = reported(filled / "station.db", capsys, str(folder))
    assert (code, "does not know this campaign" in text) == (0, True)


def test_a_check_makes_no_database(filled: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    code, text = reported(tmp_path / "none.db", capsys, str(filled / "c"))
    assert (code, "none.db: found no such file" in text) == (3, True)
    assert list(tmp_path.iterdir()) == []
