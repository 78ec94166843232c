"""Where this repository is, the measured data next to it, and files that are in memory alone."""

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

ROOT = Path(__file__).parents[1]
DATA = Path(os.environ.get("STATION_DATA", ROOT / "../shared/data")).resolve()
MEMORY = Path("/dev/shm")  # where this system has it


@contextmanager
def disk_in_memory() -> Iterator[Path]:
    """Yield a new folder on a disk in memory, where there is one."""
    with tempfile.TemporaryDirectory(dir=MEMORY if MEMORY.is_dir() else None) as folder:
        yield Path(folder).resolve()
