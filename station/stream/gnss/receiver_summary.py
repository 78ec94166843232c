"""A receiver in a line: fixes, where, how often, what was refused."""

import numpy as np

from procedures.earth.gnss_records import AveragedSite
from station.stream.gnss.gnss_feed import GnssFeed
from station.text.plural import plural


def receiver_summary(feed: GnssFeed) -> str:
    """Return what a feed has seen, in words."""
    site, counters = feed.site(), feed.decoder.framer.counters
    where = "no position" if site is None else site_in_words(site)
    rates = ", ".join(f"{name} {rate:.1f} Hz" for name, rate in sorted(feed.rates_hz().items()))
    return (
        f"{feed.address.name}: system {feed.decoder.system or 'none'}, {plural(len(feed.fixes), 'fix')}, {where}; "
        f"{rates or 'nothing of late'}; {counters.bad_crc} bad check, {counters.lost} lost, "
        f"{counters.refused} refused, {plural(counters.skipped_bytes, 'byte')} in no frame"
        + (f"; {feed.trouble}" if feed.trouble else "")
    )


def site_in_words(site: AveragedSite) -> str:
    """Return latitude, longitude and height with their 1 sigma."""
    where = f"{np.degrees(site.latitude):.6f}, {np.degrees(site.longitude):.6f} deg"
    if site.height is None or site.vertical_std is None:
        return f"{where}, 1 sigma {site.horizontal_std:.1f} m, no height"
    return f"{where}, {site.height:.1f} m, 1 sigma {site.horizontal_std:.1f} m, height {site.vertical_std:.1f} m"
