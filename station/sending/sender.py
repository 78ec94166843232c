"""Takes what a feed has received, calibrates it, sends it to every output, and reports the status."""

import time
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from typing import Self

import numpy as np

from procedures.arrays import FloatArray
from station.calibrated.calibration_choice import AppliedCalibration
from station.sending.live_samples import LiveSamples
from station.sending.outputs import About, Output, open_outputs
from station.stream.live.live_feed import LiveFeed
from station.stream.recorder.sample_times import Utc
from station.text import plural

STATUS_S = 10.0  # between two lines of status


class Sender:
    """Call `take` after each `advance` of the feed, in a ``with``, which ends in closing the outputs.

    ``say`` takes lines for people: the status every ``status_s`` [s], effects not corrected, a summary at the end.
    """

    def __init__(
        self, samples: LiveSamples, outputs: Sequence[Output], say: Callable[[str], None],
        status_s: float = STATUS_S, clock: Callable[[], float] = time.monotonic,
    ) -> None:  # fmt: skip
        self._samples, self._outputs, self._say, self._clock = samples, outputs, say, clock
        self._status_s = status_s
        self._since = clock(), 0  # the last status, and what had been sent by then
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
        now = self._clock()
        found = self._samples.take(now)
        if found is not None:
            for output in self._outputs:
                output.send(found)
            if self._samples.not_applied != self._not_corrected:
                self._not_corrected = self._samples.not_applied
                self._say(f"not corrected: {'; '.join(self._not_corrected) or 'nothing'}")
        if now - self._since[0] >= self._status_s:
            self._say(self._status(now))
            self._since = now, self._samples.sent

    def summary(self) -> str:
        """Return what was sent, what was lost, and how each output fared, in a line."""
        samples = self._samples
        counted = f"{plural(samples.sent, 'sample')}, {samples.lost} lost, {plural(samples.gaps, 'gap')}"
        counted += f", {samples.unsettled} unsettled" if samples.unsettled else ""
        return "; ".join([counted, *(output.said() for output in self._outputs)])

    def _status(self, now: float) -> str:
        then, sent = self._since
        return f"{(self._samples.sent - sent) / (now - then):.1f}/s; {self.summary()}"


def opened_sender(
    feed: LiveFeed, applied: AppliedCalibration, to: Sequence[str], C: FloatArray, say: Callable[[str], None], *,
    frd: bool = False, utc: Utc | None = None, clock_off: Callable[[], str] = lambda: "",
    status_s: float = STATUS_S,
) -> Sender:  # fmt: skip
    """Return what streams the samples of a feed that is identified, its outputs open; use it in a ``with``.

    ``C`` (3, 3) takes IMU axes to forward-right-down, in which all is streamed with ``frd``. ``utc`` gives UTC
    [s] of a moment [ns], ``clock_off`` says what is wrong with the device's clock; ``status_s`` as of `Sender`.

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
    return Sender(samples, outputs, say, status_s)
