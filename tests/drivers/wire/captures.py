"""Where the recordings of real devices are."""

import os
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]
CAPTURES = Path(os.environ.get("STATION_DATA", ROOT / "../shared/data")) / "captures"
needs_captures = pytest.mark.skipif(not CAPTURES.is_dir(), reason=f"no captures at {CAPTURES}; set STATION_DATA")
