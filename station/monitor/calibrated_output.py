"""Calibrated samples handed on beside the monitor, as `station stream` does."""

import sys
from collections.abc import Callable, Sequence
from contextlib import ExitStack

from procedures.arrays import FloatArray
from station.calibrated.calibration_choice import AppliedCalibration
from station.monitor.recording import MonitorRecording
from station.stream.gnss.sample_rate import host_sample_rate
from station.stream.live.live_feed import LiveFeed
from station.stream.recorder.row_times import Utc


def calibrated_output(
    to: Sequence[str], feed: LiveFeed, applied: AppliedCalibration, C: FloatArray, utc: Utc | None,
    recording: MonitorRecording | None, stack: ExitStack,
) -> Callable[[], None]:  # fmt: skip
    """Return what hands on the samples that have come, nothing where ``to`` names no output; ``stack`` ends it.

    ``C`` (3, 3) takes IMU axes to forward-right-down. What it says stands among the events of the run; the end of
    it, what was lost and dropped, is on stderr too.

    Raises
    ------
    DataRefused
        If there is no calibration, or it is another unit's or of another output; the monitor alone would go on.
    """
    if not to:
        return lambda: None
    from station.sending.chosen_calibration import refuse_unfit
    from station.sending.opening import opened_sender
    from station.sending.stream_command import FIT_S

    assert feed.unit is not None, "identify first"
    refuse_unfit(applied, "--calibration", feed.unit, feed.wire)
    said = list[str]()

    def say(text: str) -> None:
        said.append(text)
        del said[:-1]
        if recording is not None:
            recording.note("stream", text, float("nan"), 0)

    rate = host_sample_rate(feed, FIT_S)
    sender = opened_sender(feed, applied, to, C, say, utc=utc, clock_off=lambda: rate.said)
    stack.callback(lambda: sys.stderr.writelines(f"{text}\n" for text in said))
    stack.enter_context(sender)

    def take() -> None:
        rate.warned()
        sender.take()

    return take
