"""Where this repository is, and the measured data beside it."""

import os
from pathlib import Path

ROOT = Path(__file__).parents[1]
DATA = Path(os.environ.get("STATION_DATA", ROOT / "../shared/data")).resolve()
