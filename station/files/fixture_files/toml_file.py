"""``fixtures/1`` as one TOML file; the last line of an export is the SHA-256 of all above it.

```toml
format = "fixtures/1"
[[slab]]
id = "SLAB-1"
[[level]]
slab_id = "SLAB-1"
tilt_east_rad = 1.2e-5        # the up vector's east component seen from the slab
tilt_north_rad = -0.4e-5
std_east_rad = 0.5e-5         # 1 sigma
std_north_rad = 0.5e-5
source = "electronic level 17, A. Weber"
measured_utc = 2026-03-04T12:00:00Z
due_date = 2027-03-04
```
"""

import hashlib
import re
from pathlib import Path

from fixtures_db.fixture_transfer import Rows
from fixtures_db.hash_chain import digest
from station.errors import Altered, DataRefused
from station.files.fixture_files.tables import FIXTURES_FILE, FixturesFile
from station.files.toml_reading import read_tables, read_text_file
from station.files.toml_writing import toml_text

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
