"""``anchor/1``: the heads of a database's hash chains as a file, to be kept where the database is not.

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

from dataclasses import asdict
from datetime import UTC, datetime
from pathlib import Path
from typing import Literal

from fixtures_db.hash_chain import GENESIS
from fixtures_db.verification import Anchor
from station.files.atomic_file import replace_file
from station.files.fixture_files import seal_of, sealed
from station.files.toml_file import Sha256, TomlTable, read_tables, toml_text


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
