"""A GNSS receiver beside the IMU: its reader process, its fixes, the site and the time they give."""

from station.stream.gnss.gnss_feed import GnssFeed, open_gnss

__all__ = ["GnssFeed", "open_gnss"]
