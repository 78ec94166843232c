"""Where this repository is, the measured data beside it, and files that are in memory alone."""

import os
from pathlib import Path

ROOT = Path(__file__).parents[1]
DATA = Path(os.environ.get("STATION_DATA", ROOT / "../shared/data")).resolve()
MEMORY = Path("/dev/shm")  # where this system has it
