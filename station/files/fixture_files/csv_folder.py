"""``fixtures/1`` as a folder: a CSV file for each table, a field left empty where there is no value, hashes."""

import csv
import io
from collections.abc import Mapping, Sequence
from datetime import datetime
from pathlib import Path

from pydantic import BaseModel, ValidationError

from fixtures_db.calibration import utc_text
from fixtures_db.fixture_transfer import Rows, Value
from fixtures_db.folder_on_disk import make_folder
from fixtures_db.hash_chain import digest
from station.errors import Altered, CannotWrite, DataRefused, cannot_write
from station.files.atomic_file import replace_file
from station.files.fixture_files.tables import FIXTURES_FILE, TABLES, FixturesFile
from station.files.fixture_files.toml_file import MAX_BYTES
from station.files.sha256sums import SHA256SUMS, append_hash, verify_folder
from station.files.toml_reading import expected_of, read_text_file


def write_csv(folder: Path, rows: Rows) -> None:
    """Write a file for each table that has rows, and their hashes.

    Raises
    ------
    CannotWrite
        If the folder cannot be made, or is not empty: an older export's file would stay in the new one.
    """
    try:
        make_folder(folder)
        if any(folder.iterdir()):
            raise CannotWrite(folder, "it contains files")
    except OSError as error:
        raise error if isinstance(error, CannotWrite) else cannot_write(folder, error) from error
    for name, table in rows.items():
        if table:
            text = _text(table)
            replace_file(folder / f"{name}.csv", text.encode())
            append_hash(folder, f"{name}.csv", digest(text))


def read_csv(path: Path) -> FixturesFile:
    """Return the tables of a folder, or of one CSV file named for its table (``slab.csv``).

    Raises
    ------
    Altered
        If a folder has hashes and a file does not agree with its own.
    DataRefused
        With file and line, if a row is none of its table.
    """
    if path.is_file():
        return FIXTURES_FILE.model_validate({path.stem: _rows(path)})
    if (path / SHA256SUMS).exists():
        verify_csv(path)
    files = {name: path / f"{name}.csv" for name in TABLES}
    found = {name: _rows(file) for name, file in files.items() if file.exists()}
    if not found:
        raise DataRefused(path, None, "none of its files", f"one of {', '.join(f'{name}.csv' for name in TABLES)}")
    return FIXTURES_FILE.model_validate(found)


def verify_csv(folder: Path) -> list[str]:
    """Hash every file of an export again and return their names; raise `Altered` if one differs or has no hash."""
    names = verify_folder(folder)
    for name in (f"{table}.csv" for table in TABLES):
        if name not in names and (folder / name).exists():
            raise Altered(folder / name, "a table without a hash", f"a line in {SHA256SUMS}", "export it again")
    return names


def _text(rows: Sequence[Mapping[str, Value]]) -> str:
    stream = io.StringIO()
    writer = csv.DictWriter(stream, list(rows[0]), lineterminator="\r\n")
    writer.writeheader()
    for row in rows:
        writer.writerow({key: utc_text(v) if isinstance(v, datetime) else v for key, v in row.items()})
    return stream.getvalue()


def _rows(path: Path) -> list[BaseModel]:
    if (table := TABLES.get(path.stem)) is None:
        raise DataRefused(
            path, None, f"a file {path.name}", f"one of {', '.join(f'{name}.csv' for name in TABLES)}"
        )
    # a spreadsheet may put a mark before it: utf-8-sig
    text = read_text_file(path, MAX_BYTES).decode("utf-8-sig", "backslashreplace")
    reader, rows = csv.DictReader(io.StringIO(text, newline=""), strict=True), list[BaseModel]()
    try:
        for row in reader:
            rows.append(table.model_validate({str(key): value for key, value in row.items() if value != ""}))
    except ValidationError as error:
        fault = error.errors(include_url=False)[0]
        found = f"{'.'.join(map(str, fault['loc']))} {ascii(fault['input'])[:60]}"
        raise DataRefused(path, reader.line_num, found, expected_of(fault)) from None
    except csv.Error as error:
        raise DataRefused(path, reader.line_num, f"no CSV ({error})", "values with commas between them") from None
    return rows
