"""Takes what a feed has brought, calibrates it, and hands it to every output; says how that goes."""

import time
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from typing import Self

from station.sending.live_samples import LiveSamples
from station.sending.output import Output
from station.text.plural import plural

STATUS_S = 10.0  # between two lines of status


class Sender:
    """Call `take` after each `advance` of the feed, in a ``with``, which ends in closing the outputs.

    ``say`` takes lines for people: the status every ``status_s`` [s], effects left in, a summary when all is over.
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
        """How much of the device's own time has been handed on [s]."""
        return self._samples.device_s

    def take(self) -> None:
        """Hand on what has come."""
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
