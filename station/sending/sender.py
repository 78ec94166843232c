"""Takes what a feed has received, calibrates it, sends it to every output, and reports the status.

`run` is `station stream`: source, calibration and outputs put together, until somebody or something ends it.
"""

import contextlib
import time
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Self

import numpy as np

from drivers.address_parsing import parse_device_url
from drivers.errors import ReplayEnded
from procedures.arrays import FloatArray
from station.calibrated.calibration_choice import AppliedCalibration, chosen_calibration
from station.files.atomic_file import new_folder, recording_path
from station.sending.live_samples import LiveSamples
from station.sending.outputs import About, Output, open_outputs
from station.stream.live.live_feed import ChunkSource, LiveFeed, open_feed
from station.stream.live.stream_trouble import TroubleLog, refuse_partial
from station.stream.reader import Reader
from station.stream.recorder.sample_times import Utc
from station.stream.replay import Replay, is_mcap
from station.stream.sample_rate import SampleRate, host_sample_rate
from station.text import plural

if TYPE_CHECKING:
    from station.stream.gnss_feed import GnssFeed  # pymavlink: only where a receiver is read


Say = Callable[[str], None]
STATUS_S = 10.0  # between two lines of status


class Sender:
    """Call `take` after each `advance` of the feed, in a ``with``, which ends in closing the outputs.

    ``say`` takes lines for people: the status every `STATUS_S`, effects not corrected, a summary at the end.
    """

    def __init__(self, samples: LiveSamples, outputs: Sequence[Output], say: Say) -> None:
        self._samples, self._outputs, self._say = samples, outputs, say
        self._since = time.monotonic(), 0  # the last status, and what had been sent by then
        self._not_corrected: tuple[str, ...] = ()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *raised: object) -> None:
        with ExitStack() as stack:
            stack.callback(lambda: self._say(self.summary()))
            for output in self._outputs:
                stack.callback(output.close)

    @property
    def is_over(self) -> bool:
        """Whether nobody will take anything any more."""
        return all(output.is_over for output in self._outputs)

    @property
    def device_s(self) -> float:
        """How much of the device's own time has been streamed [s]."""
        return self._samples.device_s

    def take(self) -> None:
        """Stream what has come."""
        now = time.monotonic()
        found = self._samples.take(now)
        if found is not None:
            for output in self._outputs:
                output.send(found)
            if self._samples.not_applied != self._not_corrected:
                self._not_corrected = self._samples.not_applied
                self._say(f"not corrected: {'; '.join(self._not_corrected) or 'nothing'}")
        if now - self._since[0] >= STATUS_S:
            self._say(self._status(now))
            self._since = now, self._samples.sent

    def summary(self) -> str:
        """Return what was sent, what was lost, and how each output fared, in a line."""
        samples = self._samples
        counted = f"{plural(samples.sent, 'sample')}, {samples.lost} lost, {plural(samples.gaps, 'gap')}"
        counted += f", {samples.unsettled} unsettled" if samples.unsettled else ""
        return "; ".join([counted, *(output.status() for output in self._outputs)])

    def _status(self, now: float) -> str:
        then, sent = self._since
        return f"{(self._samples.sent - sent) / (now - then):.1f}/s; {self.summary()}"


def opened_sender(
    feed: LiveFeed, applied: AppliedCalibration, to: Sequence[str], C: FloatArray, say: Say, *,
    frd: bool = False, utc: Utc | None = None, clock_off: Callable[[], str] = lambda: "",
) -> Sender:  # fmt: skip
    """Return what streams the samples of a feed that is identified, its outputs open; use it in a ``with``.

    ``C`` (3, 3) takes IMU axes to forward-right-down, in which all is streamed with ``frd``. ``utc`` gives UTC
    [s] of a moment [ns], ``clock_off`` says what is wrong with the device's clock.

    Raises
    ------
    BadAddress, DriverError, ExtraMissing
        What the address of an output refuses.
    """
    assert feed.unit is not None, "identify first"
    ours, theirs = (C, np.eye(3)) if frd else (np.eye(3), C)
    axes = "forward-right-down" if frd else "sensor"
    about = About(feed.unit.model, feed.unit.serial, applied.in_use.text, axes, theirs, feed.period)
    samples = LiveSamples(feed, applied, ours, utc, clock_off)  # before the outputs: it may refuse
    outputs = open_outputs(to, about)
    say(f"{about.model} {about.serial}, {1 / about.period:.6g} samples/s, calibration {about.calibration}")
    if applied.in_use.note:
        say(applied.in_use.note)
    say(f"to {', '.join(output.name for output in outputs)}; axes: {axes}")
    return Sender(samples, outputs, say)


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
        reader, recording = _source(wanted, stack)
        receiver = _receiver(wanted.gnss, recording, stack)
        feed = open_feed(reader)
        unit = feed.identify_or_unknown(wanted.model, wanted.serial)
        refuse_partial(feed.address.name, feed.stream.decoder.kind)
        applied = chosen_calibration(wanted.calibration, wanted.database, unit, feed.wire, nominal=wanted.nominal)
        rate = _rate(feed, receiver)
        utc = None if receiver is None else receiver.utc
        sender = opened_sender(
            feed, applied, wanted.to, wanted.C, say, frd=wanted.frd, utc=utc, clock_off=lambda: rate.text
        )
        _follow(feed, stack.enter_context(sender), _watch(feed, receiver, rate, say), wanted.seconds)


def _source(wanted: StreamRequest, stack: ExitStack) -> tuple[ChunkSource, Path | None]:
    """Return where bytes come from, and the folder in which they are kept, if they are."""
    address = parse_device_url(wanted.url)
    if address.scheme == "replay" and is_mcap(Path(address.path)):
        return Replay(wanted.url, wanted.speed), None
    if wanted.folder is None:
        return stack.enter_context(Reader(wanted.url, None)), None
    recording = recording_path(wanted.folder)
    folder = stack.enter_context(new_folder(wanted.folder, recording.name))
    return stack.enter_context(Reader(wanted.url, recording)), folder


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
