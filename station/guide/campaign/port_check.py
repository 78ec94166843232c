"""A look at what a port sends before a campaign; its GNSS receiver: the site, then time and the sample rate."""

import json
import time
from collections.abc import Iterable, Iterator, Mapping
from contextlib import ExitStack
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from drivers.errors import DriverError
from drivers.wire import ALL_CHANNELS
from procedures.counts.sample_records import RateBlock, SampleBlock, block_rows
from procedures.gnss_records import AveragedSite
from station.files.atomic_file import replace_file
from station.files.campaign_setup import Setup
from station.guide.setup_view import PortCheck
from station.stream.gnss_feed import GnssFeed, open_gnss, site_in_words
from station.stream.live.live_feed import LiveFeed
from station.stream.live.stillness import RATE_UNIT, TICKS_PER_BLOCK, block_of
from station.stream.live.stream_trouble import without_numbers
from station.stream.sample_rate import SampleRate, host_sample_rate
from station.stream.stream_events import EventLog

if TYPE_CHECKING:
    from station.device_probe import ImuProbe


GNSS_FILE = "gnss.json"
SITE_FIXES = 20  # to average before a campaign begins
MAX_SITE_WAIT_S = 60.0
SHORT_WAIT_S = 15.0  # where the site is stated and only to be compared
POLL_S = 0.05
MAX_SITE_DIFFERENCE_DEG = 0.01  # a kilometre: the stated site is not this one


class NoFix(DriverError):
    """The receiver gave no position in time."""

    def __init__(self, port: str, fixes: int, trouble: str) -> None:
        self.port, self.fixes, self.trouble = port, fixes, trouble
        super().__init__(
            f"{port}: {fixes} positions within {MAX_SITE_WAIT_S:g} s, expected {SITE_FIXES}; "
            f"{trouble or 'wait for a fix'}, or state the site"
        )


class SampleRateWatch:
    """The device's sample rate against GNSS time, else this machine's clock; each problem is reported once.

    A computer's clock is right to about 1e-4, so that it can detect an error of 0.1 %. A rate that is more than 5
    % off is assumed to be that of a simulated or replayed device at another speed, and is not reported.
    """

    def __init__(self, feed: LiveFeed, event_log: EventLog, gnss: GnssFeed | None) -> None:
        self._gnss, self._event_log, self._reported = gnss, event_log, ""
        self._rate = host_sample_rate(feed) if gnss is None else SampleRate(feed, gnss.utc, gnss.utc_scatter)

    def round(self) -> None:
        """Take what has come; raise `DataRefused` if the device's rate is surely more than 1 % off."""
        if self._gnss is not None:
            self._gnss.advance()
        self._rate.look()
        now = (self._gnss.trouble if self._gnss else "") or self._rate.warning
        if without_numbers(now) != self._reported:  # not once more for each new figure
            self._reported = without_numbers(now)
            well = "GNSS works again" if self._gnss else "the sample rate is right again"
            self._event_log.say("rejected" if now else "", now or well)


def setup_with_site(setup: Setup, gnss: GnssFeed, folder: Path) -> Setup:
    """Return the set-up with what it does not state of its site taken from averaged fixes; note them in a file.

    Raises
    ------
    NoFix
        If the site is needed and the receiver has none within a minute.
    """
    deadline = time.monotonic() + (MAX_SITE_WAIT_S if setup.latitude_deg is None else SHORT_WAIT_S)
    while ((site := gnss.site()) is None or site.fixes < SITE_FIXES) and time.monotonic() < deadline:
        gnss.advance(POLL_S)
    if site is None or site.fixes < SITE_FIXES:
        if setup.latitude_deg is None:
            raise NoFix(gnss.address.name, site.fixes if site else 0, gnss.trouble)
        return setup
    seen = _degrees(site)
    stated = _stated(setup, seen)
    _write(folder, gnss, site, seen, stated)
    new = {name: value for name, value in seen.items() if name not in stated and value is not None}
    return setup.model_copy(update=new)


def site_text(given: Setup, gnss: GnssFeed) -> str:
    """Return where the receiver stands, with sigma, and how that compares with the site given, in words."""
    if (site := gnss.site()) is None:
        return "no position from GNSS; the site is as stated"
    seen = _degrees(site)
    warnings = _warnings(site, seen, _stated(given, seen))
    return "; ".join([f"site from GNSS: {site_in_words(site)}", *warnings])


def reopen_receiver(stack: ExitStack, setup: Setup, folder: Path) -> tuple[GnssFeed | None, str]:
    """Open the receiver of a resumed campaign; the site is known, so that it also goes on without one."""
    if not setup.gnss:
        return None, ""
    try:
        return stack.enter_context(open_gnss(setup.gnss, folder)), ""
    except DriverError as error:
        return None, f"continuing without GNSS: {error}"


def utc_now(gnss: GnssFeed) -> datetime | None:
    """Return GNSS time, None where it is not known."""
    if gnss.latest is None or (utc := gnss.utc(gnss.latest.host_ns)) is None:
        return None
    return datetime.fromtimestamp(utc, UTC)


def _degrees(site: AveragedSite) -> dict[str, float | None]:
    return {
        "latitude_deg": round(float(np.degrees(site.latitude)), 9),
        "longitude_deg": round(float(np.degrees(site.longitude)), 9),
        "height_m": None if site.height is None else round(site.height, 3),
    }


def _stated(setup: Setup, names: Iterable[str]) -> dict[str, float]:
    return {name: value for name in names if (value := getattr(setup, name)) not in {None, 0.0}}


def _warnings(site: AveragedSite, seen: Mapping[str, float | None], stated: Mapping[str, float]) -> list[str]:
    constant = (
        f"all {site.fixes} fixes are identical: the receiver holds its position, or the position is simulated"
    )
    return [constant] * site.is_constant + [
        f"{name} {value:g} is stated, GNSS gives {seen[name]:g}"
        for name, value in stated.items()
        if name != "height_m" and abs(value - (seen[name] or 0.0)) > MAX_SITE_DIFFERENCE_DEG
    ]


def _write(
    folder: Path, gnss: GnssFeed, site: AveragedSite, seen: dict[str, float | None], stated: dict[str, float]
) -> None:
    now = utc_now(gnss)
    values = {
        "source": gnss.address.text, "system": gnss.decoder.system, **seen,
        "height_above": "ellipsoid" if site.is_ellipsoidal else "mean sea level",
        "horizontal_std_m": site.horizontal_std, "vertical_std_m": site.vertical_std, "fixes": site.fixes,
        "utc": None if now is None else now.isoformat(), "stated_by_operator": stated,
        "warnings": _warnings(site, seen, stated),
    }  # fmt: skip
    known = {name: value for name, value in values.items() if value not in (None, [], {})}
    replace_file(folder / GNSS_FILE, (json.dumps(known, indent=1) + "\n").encode())


PORT_LOOK_S = 2.0
RECORD_INSTEAD = "record its steps with `station record` and solve them as a campaign folder"
TICK_S = 0.1
BAD_SHARE = 0.01  # of the frames; beyond it the line is not good enough to begin
LISTEN_S = 8.0  # a heartbeat, an answer and the fixes at the usual rate; a slow receiver takes all of it
RECEIVER_FIXES = 10


def check_port(url: str, seconds: float = PORT_LOOK_S) -> PortCheck:
    """Look at what a port sends; what is wrong with it stands in ``text``, with what to do. Never raises."""
    from station.device_probe import probe_imu

    try:
        seen = probe_imu(url, seconds)
    except (DriverError, OSError) as error:
        return PortCheck(url=url, is_good=False, text=str(error))
    counters = seen.counters
    bad = counters.bad_crc + counters.bad_length
    remedies = list(_remedies(seen, bad))
    return PortCheck(
        url=url, is_good=not remedies, format=seen.format, model=seen.model or "", serial=seen.serial or "",
        output="rate" if isinstance(seen.samples, RateBlock) else "increments", rate_hz=seen.rate_hz,
        frames=seen.frames, bad_frames=bad, noise=noise_in_words(seen.samples, seen.rate_hz),
        text="; ".join(remedies) or "the frames are correct",
    )  # fmt: skip


def check_receiver(url: str, seconds: float = LISTEN_S) -> PortCheck:
    """Listen to a receiver; what is wrong stands in ``text``, with what to do. Never raises."""
    from station.device_probe import probe_gnss

    try:
        feed = probe_gnss(url, seconds, RECEIVER_FIXES).feed
    except (DriverError, OSError) as error:
        return PortCheck(url=url, is_good=False, text=str(error))
    if (site := feed.site()) is not None:
        return PortCheck(url=url, is_good=True, text=site_in_words(site))
    nothing = f"{feed.address.name}: no position within {seconds:g} s, expected one; wait for a fix"
    return PortCheck(url=url, is_good=False, text=feed.trouble or nothing)


def noise_in_words(samples: SampleBlock, rate_hz: float | None) -> str:
    """Say how much the counts of tenths of a second scatter within a second, by triad the greatest channel."""
    size = round(rate_hz) if rate_hz else 0
    seconds = len(samples) // size if size >= TICKS_PER_BLOCK else 0
    if not seconds:
        return "less than 1 s of data: too short to measure the noise"
    blocks = [
        block_of(block_rows(samples, slice(i, i + size)), i, 1 / size, is_broken=False, is_restarted=False)
        for i in range(0, seconds * size, size)
    ]
    variance = np.mean([block.variance for block in blocks], axis=0)
    gyro, accel = np.sqrt(variance).reshape(2, 3).max(axis=1)
    if isinstance(samples, RateBlock):
        gyro, accel = (value / (RATE_UNIT * TICK_S) for value in (gyro, accel))
        return f"gyroscopes {gyro:.2g}, accelerometers {accel:.2g} rms of 0.1 s, in the device's units"
    return f"gyroscopes {gyro:.2g}, accelerometers {accel:.2g} counts rms in 0.1 s"


def _remedies(seen: "ImuProbe", bad: int) -> Iterator[str]:
    if bad > BAD_SHARE * (seen.frames + bad):
        yield (
            f"{bad} of {seen.frames + bad} frames are damaged, expected less than {BAD_SHARE:.0%}; check cable, "
            "ground and termination"
        )
    if jumps := seen.counters.counter_jumps:
        yield (
            f"frames are missing at {jumps} places, expected none; check that the baud rate is high enough and "
            "nothing else reads the port"
        )
    if faults := seen.counters.bad_status:
        yield (
            f"the device reports a fault in {faults} of {seen.frames} frames, expected none; let it warm up, "
            "or see its manual"
        )
    if seen.silent:
        yield seen.silent
    if missing := sorted(ALL_CHANNELS - seen.channels):
        yield f"{seen.format} sends no {', '.join(missing)}, expected six channels; {RECORD_INSTEAD}"
