"""Where the recordings of real devices are."""

import pytest

from tests.paths import DATA

CAPTURES = DATA / "captures"
needs_captures = pytest.mark.skipif(not CAPTURES.is_dir(), reason=f"no captures at {CAPTURES}; set STATION_DATA")
