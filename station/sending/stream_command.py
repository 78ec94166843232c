"""`station stream` put together: source, calibration, outputs, until somebody or something ends it."""

import contextlib
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from drivers.address_parsing import parse_device_url
from drivers.errors import ReplayEnded
from procedures.arrays import FloatArray
from procedures.campaign.campaign import UNKNOWN
from station.files.atomic_file import journal_path, new_folder
from station.sending.chosen_calibration import chosen_calibration
from station.sending.sender import Sender, opened_sender
from station.stream.live.live_feed import ChunkSource, LiveFeed, open_feed
from station.stream.live.stream_trouble import TroubleLog, refuse_partial
from station.stream.reader import Reader
from station.stream.replay import Replay, is_mcap
from station.stream.sample_rate import SampleRate, host_sample_rate

if TYPE_CHECKING:
    from station.stream.gnss_feed import GnssFeed  # pymavlink: only where a receiver is read

Say = Callable[[str], None]
FIT_S = 30.0  # between two fits of the device's clock, which hold a sample up for milliseconds


@dataclass(frozen=True, slots=True, eq=False)
class StreamRequest:
    """What the command line asks for, checked; ``C`` (3, 3) takes IMU axes to forward-right-down."""

    url: str
    to: Sequence[str]
    C: FloatArray
    frd: bool = False  # every output in these axes, not MAVLink alone
    gnss: str = ""
    calibration: str = ""
    nominal: bool = False
    seconds: float = float("inf")
    speed: float = 1.0
    folder: Path | None = None
    model: str = ""
    serial: str = ""
    database: str | None = None


def run(wanted: StreamRequest, say: Say) -> None:
    """Stream samples until the time is over, nobody takes any more, or a replay ends; ``say`` is for people.

    Raises
    ------
    DriverError, CannotWrite, DataRefused, BadAddress
        What port, disk, calibration or an output's address refuse, or what ended the stream.
    KeyboardInterrupt
        On Ctrl-C; what was under way has been streamed.
    """
    with ExitStack() as stack:
        reader, journal = _source(wanted, stack)
        receiver = _receiver(wanted.gnss, journal, stack)
        feed = open_feed(reader)
        unknown = UNKNOWN if feed.wire.identity is None else None
        unit = feed.identify(wanted.model or unknown, wanted.serial or unknown)
        refuse_partial(feed.address.name, feed.stream.decoder.kind)
        applied = chosen_calibration(wanted.calibration, wanted.database, unit, feed.wire, nominal=wanted.nominal)
        rate = _rate(feed, receiver)
        utc = None if receiver is None else receiver.utc
        sender = opened_sender(
            feed, applied, wanted.to, wanted.C, say, frd=wanted.frd, utc=utc, clock_off=lambda: rate.said
        )
        _follow(feed, stack.enter_context(sender), _watch(feed, receiver, rate, say), wanted.seconds)


def _source(wanted: StreamRequest, stack: ExitStack) -> tuple[ChunkSource, Path | None]:
    """Return where bytes come from, and the folder in which they are kept, if they are."""
    address = parse_device_url(wanted.url)
    if address.scheme == "replay" and is_mcap(Path(address.path)):
        return Replay(wanted.url, wanted.speed), None
    if wanted.folder is None:
        return stack.enter_context(Reader(wanted.url, None)), None
    journal = journal_path(wanted.folder)
    folder = stack.enter_context(new_folder(wanted.folder, journal.name))
    return stack.enter_context(Reader(wanted.url, journal)), folder


def _receiver(url: str, folder: Path | None, stack: ExitStack) -> "GnssFeed | None":
    if not url:
        return None
    from station.stream.gnss_feed import open_gnss

    return stack.enter_context(open_gnss(url, folder))


def _rate(feed: LiveFeed, receiver: "GnssFeed | None") -> SampleRate:
    if receiver is None:
        return host_sample_rate(feed, FIT_S)
    return SampleRate(feed, receiver.utc, receiver.utc_scatter, every_s=FIT_S)


def _watch(feed: LiveFeed, receiver: "GnssFeed | None", rate: SampleRate, say: Say) -> Callable[[], None]:
    """Return what says troubles as they appear and when they are over, as `station record` does."""
    line, sky = TroubleLog(feed.address.name, say), TroubleLog(receiver.address.name if receiver else "", say)

    def look() -> None:
        warned = rate.warned()
        line.look(feed.amiss or feed.silent or ("" if receiver else warned))
        if receiver is not None:
            receiver.advance()
            sky.look(receiver.trouble or warned)

    return look


def _follow(feed: LiveFeed, sender: Sender, look: Callable[[], None], seconds: float) -> None:
    """Stream what comes until the time is over, nobody takes it any more, or a replay ends."""
    with contextlib.suppress(ReplayEnded):
        while not sender.is_over and sender.device_s < seconds:
            sender.take()
            feed.buffer.forget_before(feed.buffer.end)
            look()
            feed.advance()
        return
    sender.take()
