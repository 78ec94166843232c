"""Files of what a database holds: its fixtures (``fixtures/1``), and the heads of its hash chains (``anchor/1``).

``fixtures/1`` is one TOML file, or a folder of CSV files. A table of the file is a table of the database, a key
one of its columns, with its type and unit (`fixtures_db.fixture_measurements.CARRIED_TABLES`). The last line of an
export is the SHA-256 of all above it.

``anchor/1`` has the heads of all hash chains and is kept where the database is not.

```toml
format = "anchor/1"
written_utc = 2026-03-04T12:00:00Z
calibration = "5f0c..."             # the newest one's SHA-256
certificate = "91ab..."
level = "0000..."                   # 64 zeros: there was none
measurement = "0000..."             # of a cube by IMUs; may be missing
issued = "7c31..."                  # the newest calibration certificate handed out
signed = "0000..."                  # the newest signed file of one
effect = "0000..."                  # of a user-defined effect, added or withdrawn
journal = "3a7d..."                 # the newest entry of the journal of all rows; not in older files
entries = 412                       # and its number
[[manifest]]
folder = "/data/campaigns/2026-03-04"
steps = 18
sha256 = "77de..."                  # head of the chain over them
# sha256 ...                        # of all above
```
"""

import csv
import hashlib
import io
import re
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from datetime import UTC, datetime
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BaseModel, ConfigDict, ValidationError, create_model

from fixtures_db.fixture_measurements import CARRIED_TABLES, CarriedTable, Rows, Value
from fixtures_db.folder_on_disk import make_folder
from fixtures_db.hash_chain import GENESIS, digest, utc_text
from fixtures_db.schema import UtcDateTime
from fixtures_db.verification import Anchor
from station.errors import Altered, CannotWrite, DataRefused, cannot_write
from station.files.atomic_file import replace_file
from station.files.sha256sums import SHA256SUMS, append_hash, verify_folder
from station.files.toml_file import Sha256, TomlTable, expected_of, read_tables, read_text_file, toml_text, unseen


def _aware(moment: datetime) -> datetime:
    if moment.tzinfo is None:
        raise ValueError("a moment with its time zone, such as 2026-03-04T12:00:00Z")
    return moment.astimezone(UTC)


def _without_controls(text: str) -> str:
    if found := unseen(text.translate({ord(each): None for each in "\r\n\t"})):  # a source may have several lines
        raise ValueError(f"printable characters, not {found[:60]}")
    return text


Moment = Annotated[datetime, AfterValidator(_aware)]
DEFAULTS = {"covariance_12_rad2": 0.0}  # of a column that always has a value


class FixturesTable(BaseModel):
    """A table of the file."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False, coerce_numbers_to_str=True)


class FixturesFile(FixturesTable):
    """The whole of a ``fixtures/1``."""

    format: str = "fixtures/1"

    @property
    def rows(self) -> Rows:
        """The rows by table, as `fixtures_db.fixture_measurements.restore` takes them."""
        return {name: [row.model_dump() for row in getattr(self, name)] for name in TABLES}


def _model(table: CarriedTable) -> type[BaseModel]:
    fields: dict[str, Any] = {}
    for name in table.columns:
        column = table.row.__table__.columns[name]
        kind = Moment if isinstance(column.type, UtcDateTime) else column.type.python_type
        if kind is str:
            kind = Annotated[str, AfterValidator(_without_controls)]
        fields[name] = (kind | None, None) if column.nullable else (kind, DEFAULTS.get(name, ...))
    return create_model(table.name, __base__=FixturesTable, **fields)


TABLES = {table.name: _model(table) for table in CARRIED_TABLES}
_LISTS: dict[str, Any] = {name: (list[model], []) for name, model in TABLES.items()}  # type: ignore[valid-type]
FIXTURES_FILE = create_model("FixturesFile", __base__=FixturesFile, **_LISTS)


FORMAT = "fixtures/1"
MAX_BYTES = 1 << 26
SEAL = b"# sha256 "
RESTORE = "restore it from a copy or write it again"
_SEALED = re.compile(rb"(?s)(.*\n)# sha256 ([0-9a-f]{64})\n")


def to_toml(rows: Rows) -> str:
    """Return rows as TOML text with its hash."""
    return sealed(toml_text({"format": FORMAT, **rows}))


def read_toml_file(path: Path) -> FixturesFile:
    """Return the tables of a file, an export or one written by hand.

    Raises
    ------
    Altered
        If it is an export and was changed since; without the last line it counts as written by hand.
    DataRefused
        With file and line, if it is no ``fixtures/1``.
    """
    content = read_text_file(path, MAX_BYTES)
    if SEAL in content:
        seal_of(path)
    tables, lines = read_tables(content, path, FIXTURES_FILE)
    if tables.format != FORMAT:
        raise DataRefused(path, lines.get(("format",)), f"format {tables.format!r}", FORMAT)
    return tables


def sealed(text: str) -> str:
    """Return a text with the line of its hash."""
    return f"{text}# sha256 {digest(text)}\n"


def seal_of(path: Path) -> tuple[bytes, str]:
    """Return a sealed file's content and the hash at its end.

    Raises
    ------
    Altered
        If it was changed since it was sealed.
    DataRefused
        If there is no such line.
    """
    content = read_text_file(path, MAX_BYTES)
    if SEAL not in content:
        raise DataRefused(path, None, "no line '# sha256 ...' at its end", "a file that the station wrote")
    if (found := _SEALED.fullmatch(content)) is None:
        raise Altered(path, "no whole last line", "'# sha256 ' and 64 hexadecimal digits", RESTORE)
    if (actual := hashlib.sha256(found[1]).hexdigest()) != found[2].decode():
        raise Altered(path, f"text with sha256 {actual}", found[2].decode(), RESTORE)
    return content, actual


def write_csv(folder: Path, rows: Rows) -> None:
    """Write a file for each table that has rows, and their hashes.

    Raise `CannotWrite` if the folder cannot be made, or is not empty: an older export's file would stay in the new
    one.
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


class ManifestTable(TomlTable):
    """``[[manifest]]``."""

    folder: str
    steps: int
    sha256: Sha256


class AnchorTable(TomlTable):
    """The whole of an ``anchor/1``."""

    format: Literal["anchor/1"]
    written_utc: datetime
    calibration: Sha256
    certificate: Sha256
    level: Sha256
    measurement: Sha256 = GENESIS  # these are not in older files
    issued: Sha256 = GENESIS
    signed: Sha256 = GENESIS
    effect: Sha256 = GENESIS
    journal: Sha256 = GENESIS
    entries: int = 0
    manifest: list[ManifestTable] = []


def write_anchor(path: Path, anchor: Anchor) -> None:
    """Write an anchor; raise `CannotWrite` if the place cannot be written."""
    heads = asdict(anchor)
    manifests = [
        {"folder": name, "steps": n, "sha256": head} for name, (n, head) in heads.pop("manifests").items()
    ]
    tables = {"format": "anchor/1", "written_utc": datetime.now(UTC), **heads, "manifest": manifests}
    replace_file(path, sealed(toml_text(tables)).encode())


def read_anchor(path: Path) -> tuple[Anchor, datetime]:
    """Return the heads in a file, and when it was written.

    Raises
    ------
    Altered
        If it was changed since it was written.
    DataRefused
        If it is no ``anchor/1``.
    """
    content, _ = seal_of(path)
    tables, _ = read_tables(content, path, AnchorTable)
    manifests = {one.folder: (one.steps, one.sha256) for one in tables.manifest}
    heads = tables.model_dump(exclude={"format", "written_utc", "manifest"})
    return Anchor(**heads, manifests=manifests), tables.written_utc
