"""A real vehicle's log (ArduSub, MAVLink 2) decodes to what pymavlink made of it."""

import csv
from collections import Counter

import numpy as np
import pytest

from drivers.mavlink.frames import GPS_RAW_INT, NAMES, MavlinkFramer, fields
from drivers.mavlink.gnss_fixes import MavlinkDecoder
from procedures.gnss_records import FixType, GnssFix, averaged_site
from tests.paths import DATA

FOLDER = DATA / "captures/mavlink"
LOG = FOLDER / "ardusub_small.tlog"
pytestmark = pytest.mark.skipif(not LOG.exists(), reason=f"no captures at {FOLDER}; set STATION_DATA")


def test_every_raw_fix_has_the_integers_of_the_csv() -> None:
    frames = MavlinkFramer().feed(LOG.read_bytes())
    got = [fields(frame) for frame in frames if frame.number == GPS_RAW_INT]
    with (FOLDER / "ardusub_small.tlog.gps_raw_int.csv").open() as stream:
        rows = list(csv.DictReader(stream))
    names = {
        "time_usec": "time_usec", "fix_type": "fix_type", "lat_degE7": "lat", "lon_degE7": "lon", "alt_mm": "alt",
        "eph": "eph", "epv": "epv", "vel_cms": "vel", "cog_cdeg": "cog", "sats": "satellites_visible",
    }  # fmt: skip
    assert [{key: int(row[key]) for key in names} for row in rows] == [
        {key: one[name] for key, name in names.items()} for one in got
    ]


def test_every_message_is_found_that_the_log_is_known_to_hold() -> None:
    framer = MavlinkFramer()
    counts = Counter(NAMES[frame.number] for frame in framer.feed(LOG.read_bytes()))
    known = {
        "GPS_RAW_INT": 528,
        "GPS_INPUT": 1011,
        "GLOBAL_POSITION_INT": 792,
        "SYSTEM_TIME": 794,
        "VFR_HUD": 3060,
    }
    assert {name: counts[name] for name in known} == known
    assert framer.counters.frames >= 35_912
    # the log's own 8-byte time stamps are all that stands between the frames, but for its four bad ones
    assert framer.counters.skipped_bytes - 8 * framer.counters.frames < 2000


def test_its_fixes_are_in_si_with_what_it_does_not_know_absent() -> None:
    decoder = MavlinkDecoder()
    records = decoder.feed(LOG.read_bytes(), 0)
    raw = [one for one in records if isinstance(one, GnssFix) and one.source == "GPS_RAW_INT"]
    assert decoder.system == 1
    first = raw[0]
    assert first.fix is FixType.FIX_3D
    assert first.latitude == pytest.approx(np.radians(48.3861418), abs=1e-12)
    assert (first.hdop, first.vdop, first.satellites) == (1.6, None, 21)
    assert first.horizontal_std is first.vertical_std is first.speed_std is first.height is None
    assert first.heading == pytest.approx(np.radians(225.0))
    assert any(one.is_filtered for one in records if isinstance(one, GnssFix))
    site = averaged_site([one for one in records if isinstance(one, GnssFix)])
    assert site is not None
    assert site.fixes == sum(
        isinstance(one, GnssFix) and one.has_position and not one.is_filtered for one in records
    )
