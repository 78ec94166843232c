"""A GNSS receiver over MAVLink as the monitor's aid: its velocity, or an autopilot's airspeed.

A velocity counts at the tick in which its message was read: what it is late by (0.1 to 0.2 s of most receivers)
is not made up for. A receiver that does not tell its vertical velocity is taken not to climb.
"""

import math
import time
from collections.abc import Callable

from procedures.gnss import FixType, GnssFix
from station.gnss import GnssFeed
from station.monitor.attitude import NO_AID, Aiding
from station.monitor.view import Stream

AIDS = ("gnss", "airspeed-filter")


class GnssAid:
    """Gives the filter what ``aid``, one of `AIDS`, needs of one feed."""

    def __init__(self, feed: GnssFeed, aid: str, clock: Callable[[], float] = time.monotonic) -> None:
        self._feed, self._aid, self._clock = feed, aid, clock
        self._air_ns = 0
        self._came = clock()

    def advance(self) -> None:
        """Take what has come; a receiver that is gone stands in the stream's trouble."""
        self._feed.advance()

    def newest(self) -> Aiding:
        """Return what came since the last call, nan where nothing did."""
        fixes = [fix for fix in self._feed.take() if _velocity(fix) is not None]
        air = self._feed.air
        is_new_air = air is not None and air.host_ns > self._air_ns
        if fixes or is_new_air:
            self._came = self._clock()
        if self._aid == "airspeed-filter":
            if air is None or not is_new_air:
                return NO_AID
            self._air_ns = air.host_ns
            return Aiding(airspeed=air.airspeed)
        if not fixes:
            return NO_AID
        velocity, heading = _velocity(fixes[-1]), fixes[-1].heading
        assert velocity is not None
        return Aiding(velocity=velocity, heading=math.nan if heading is None else heading)

    def utc(self, host_ns: int) -> float | None:
        """Return UTC [s since 1970] at a moment of the station's clock [ns], None where it is not known."""
        return self._feed.utc(host_ns)

    def stream(self) -> Stream:
        """Return its health."""
        counters = self._feed.decoder.framer.counters
        return Stream(
            name=f"GNSS {self._feed.address.name}", rate_hz=max(self._feed.rates_hz().values(), default=0.0),
            age_s=self._clock() - self._came, samples=len(self._feed.fixes), gaps=0, lost=counters.lost,
            bad=counters.bad_crc, trouble=self._feed.trouble,
        )  # fmt: skip


def _velocity(fix: GnssFix) -> tuple[float, float, float] | None:
    """Return a fix's velocity north, east, down [m/s]; None where it has none."""
    horizontal = fix.velocity_n
    if horizontal is None or fix.fix < FixType.FIX_2D:
        return None
    east, north = horizontal
    return north, east, -(fix.v_up or 0.0)
