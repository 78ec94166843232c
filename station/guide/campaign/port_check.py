"""A look at what a port sends, or where a GNSS receiver says it stands, before a campaign begins."""

from typing import TYPE_CHECKING

import numpy as np

from drivers.errors import DriverError
from drivers.wire import ALL_CHANNELS
from procedures.counts.sample_records import RateBlock, SampleBlock, block_rows
from station.guide.setup_view import PortCheck
from station.stream.live.stillness import RATE_UNIT, TICKS_PER_BLOCK, block_of

if TYPE_CHECKING:
    from station.device_probe import ImuProbe

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
    remedies = _remedies(seen, bad)
    return PortCheck(
        url=url,
        is_good=not remedies,
        format=seen.format,
        model=seen.model or "",
        serial=seen.serial or "",
        output="rate" if isinstance(seen.samples, RateBlock) else "increments",
        rate_hz=seen.rate_hz,
        frames=seen.frames,
        bad_frames=bad,
        noise=noise_in_words(seen.samples, seen.rate_hz),
        text="; ".join(remedies) or "the frames are correct",
    )


def check_receiver(url: str, seconds: float = LISTEN_S) -> PortCheck:
    """Listen to a receiver; what is wrong stands in ``text``, with what to do. Never raises."""
    from station.device_probe import probe_gnss
    from station.stream.gnss_feed import site_in_words

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


def _remedies(seen: "ImuProbe", bad: int) -> list[str]:
    counters, remedies = seen.counters, list[str]()
    if bad > BAD_SHARE * (seen.frames + bad):
        remedies.append(
            f"{bad} of {seen.frames + bad} frames are damaged, expected less than {BAD_SHARE:.0%}; check cable, "
            f"ground and termination"
        )
    if counters.counter_jumps:
        remedies.append(
            f"frames are missing at {counters.counter_jumps} places, expected none; check that the baud rate is "
            f"high enough and nothing else reads the port"
        )
    if counters.bad_status:
        remedies.append(
            f"the device reports a fault in {counters.bad_status} of {seen.frames} frames, expected none; "
            f"let it warm up, or see its manual"
        )
    if seen.silent:
        remedies.append(seen.silent)
    if missing := sorted(ALL_CHANNELS - seen.channels):
        remedies.append(f"{seen.format} sends no {', '.join(missing)}, expected six channels; {RECORD_INSTEAD}")
    return remedies
