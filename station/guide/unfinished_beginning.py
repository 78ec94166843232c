"""What a guided campaign leaves in its folder that was killed before it began: another may begin there."""

from collections.abc import Collection
from fnmatch import fnmatch
from pathlib import Path

from station.errors import cannot_write
from station.guide.folder_lock import LOCK_FILE

JOURNAL = "session_*.mcap"
KNOWN = (
    LOCK_FILE, JOURNAL, "gnss_session_*.mcap", "gnss_*.mcap", ".*.tmp", "setup.json", "unit.json", "wanted.json",
    "plan.toml", "gnss.json", "SHA256SUMS", "effect_*.toml",
)  # fmt: skip


def is_unfinished(names: Collection[str]) -> bool:
    """Say whether a folder holds such a beginning: the journal that is opened first, or the lock alone."""
    is_begun = any(fnmatch(name, JOURNAL) for name in names) or set(names) <= {LOCK_FILE}
    return is_begun and all(any(fnmatch(name, known) for known in KNOWN) for name in names)


def clear_unfinished(folder: Path) -> None:
    """Take away what such a beginning noted; what it read from ports stays. Hold the folder's lock meanwhile."""
    try:
        for file in folder.iterdir():
            if file.name != LOCK_FILE and file.suffix != ".mcap":
                file.unlink()
    except OSError as error:
        raise cannot_write(folder, error) from error
