"""What a guided campaign leaves in its folder that was killed before it began: another may begin there."""

from collections.abc import Collection
from fnmatch import fnmatch
from pathlib import Path

from fixtures_db.campaigns import known_campaign
from fixtures_db.database import Database
from station.errors import cannot_write
from station.guide.folder_lock import LOCK_FILE
from station.stream.recorder.accepted_step_writer import TOML

JOURNAL = "session_*.mcap"
KNOWN = (
    LOCK_FILE, JOURNAL, "gnss_session_*.mcap", "gnss_*.mcap", ".*.tmp", "setup.json", "unit.json", "wanted.json",
    "plan.toml", "gnss.json", "SHA256SUMS", "effect_*.toml",
)  # fmt: skip


def is_unfinished(names: Collection[str], has_row: bool = False) -> bool:
    """Say whether a folder holds such a beginning: the journal that is opened first, or the lock alone.

    A ``campaign.toml`` beside them has no step, as there is no step's file: the program was killed before the
    campaign had its row in the database. ``has_row`` says that it has one.
    """
    is_begun = any(fnmatch(name, JOURNAL) for name in names) or set(names) <= {LOCK_FILE}
    known = KNOWN if has_row else (*KNOWN, TOML)
    return is_begun and all(any(fnmatch(name, each) for each in known) for name in names)


def has_row(database: Database, folder: Path) -> bool:
    """Say whether the database has a campaign of this folder."""
    with database.read() as session:
        return known_campaign(session, str(folder.resolve())) is not None


def clear_unfinished(folder: Path) -> None:
    """Take away what such a beginning noted; what it read from ports stays. Hold the folder's lock meanwhile."""
    try:
        for file in folder.iterdir():
            if file.name != LOCK_FILE and file.suffix != ".mcap":
                file.unlink()
    except OSError as error:
        raise cannot_write(folder, error) from error
