"""What hands on the samples of a feed, put together."""

from collections.abc import Callable, Sequence

import numpy as np

from procedures.arrays import FloatArray
from station.calibrated.calibration_choice import AppliedCalibration
from station.sending.live_samples import LiveSamples
from station.sending.outputs import open_outputs
from station.sending.samples import About
from station.sending.sender import STATUS_S, Sender
from station.stream.live.live_feed import LiveFeed
from station.stream.recorder.row_times import Utc


def opened_sender(
    feed: LiveFeed, applied: AppliedCalibration, to: Sequence[str], C: FloatArray, say: Callable[[str], None], *,
    frd: bool = False, utc: Utc | None = None, clock_off: Callable[[], str] = lambda: "",
    status_s: float = STATUS_S,
) -> Sender:  # fmt: skip
    """Return what hands on the samples of a feed that is identified, its outputs open; use it in a ``with``.

    ``C`` (3, 3) takes IMU axes to forward-right-down, in which all is handed on with ``frd``. ``utc`` gives UTC
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
