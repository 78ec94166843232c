"""Times for the samples of a device that sends none: counted on in its period, held to when the bytes were read.

Bytes are late, never early: the least lateness of every half second steers phase and period. What stays late by
more than half a sample for two half seconds was lost on the way, what stays early was never sent: time goes on
from the host's, and the step shows.
"""

import numpy as np

from procedures.arrays import FloatArray, IntArray

LEARN_S, LEARN_SAMPLES, LEARN_WINDOWS = 3.0, 33, 3  # before the period is known
WINDOW_S = 0.5
LASTING_WINDOWS = 2  # windows
HINDSIGHT_S = (LASTING_WINDOWS + 1) * WINDOW_S  # until a sample lost, or one too many, is certain
MAX_STEERED_SAMPLES = 0.6  # samples; a step of less is steered out
FIT_PASSES = 4  # of the first fit: all chunks, then those least late by the fit before
PHASE_GAIN, PERIOD_GAIN = 0.3, 0.05  # of a window's error, taken into phase and period: settles in about 5 s


class HostTimes:
    """Gives each sample a time [s] on the host's clock.

    ``period`` [s] is None while it is being learnt; times until then are of no use but that they rise.
    ``is_reset`` says that with the last call the period has become known, so that time begins there;
    ``has_stepped`` that it found samples lost, or some that the device never sent, and goes on elsewhere from the
    next one on.
    """

    def __init__(self) -> None:
        self.period: float | None = None
        self.is_reset = self.has_stepped = False
        self._index = 0
        self._seen = list[tuple[int, float]]()  # index and arrival of the last sample of each chunk
        self._last = np.nan
        self._window_began, self._least = np.nan, np.inf
        self._lasting = list[float]()
        self._heard = np.nan

    def reset(self) -> None:
        """Forget what came before, but for the period."""
        self._seen.clear()
        self._lasting.clear()
        self._last = np.nan

    def take(self, arrival: float, steps: IntArray) -> FloatArray:
        """Return the times (n,) of the samples that were read at ``arrival`` [s].

        ``steps`` (n,) is by how many samples the sequence went on at each: 1 where nothing counts them.
        """
        self.is_reset = self.has_stepped = False
        self._index += int(steps.sum())
        period = self.period or self._learnt(arrival)
        if period is None:
            return self._provisional(arrival, len(steps))
        if not np.isfinite(self._last):
            self._last = arrival - float(steps.sum()) * period
            self._begin_window(arrival)
        elif self.period is None:
            self.is_reset = True
            self._last -= float(steps.sum()) * period
            self._begin_window(arrival)
        self.period = period
        times: FloatArray = self._last + period * np.cumsum(steps).astype(np.float64)
        self._last = float(times[-1])
        self._watch(arrival)
        return times

    def _learnt(self, arrival: float) -> float | None:
        """Return the period once it is known, with ``_last`` set to the last sample's time."""
        self._seen.append((self._index, arrival))
        (first, began), (last, now) = self._seen[0], self._seen[-1]
        windows = {int((arrival - began) / WINDOW_S) for _, arrival in self._seen}
        if now - began >= LEARN_S and last - first >= LEARN_SAMPLES and len(windows) > LEARN_WINDOWS:
            period, offset = _least_late(*np.array(self._seen).T)
            self._last = offset + period * last
            self._seen.clear()
            return period
        return None

    def _provisional(self, arrival: float, n: int) -> FloatArray:
        """Spread samples evenly since those before; 1 us apart where no time has passed."""
        since = self._last if np.isfinite(self._last) else arrival - n * 1e-6
        until = max(arrival, since + n * 1e-6)
        self._last = until
        return since + (until - since) * np.arange(1, n + 1) / n

    def _watch(self, arrival: float) -> None:
        assert self.period is not None
        if arrival - self._heard > WINDOW_S:  # what the window held is from before a silence
            self._lasting = [(arrival - self._last) / self.period]
            self._begin_window(arrival)
        self._heard = arrival
        self._least = min(self._least, arrival - self._last)
        if arrival - self._window_began >= WINDOW_S:
            self._steer(self._least)
            self._begin_window(arrival)

    def _steer(self, late: float) -> None:
        """Take in by how much a window's least late sample was late [s], negative if all were early."""
        assert self.period is not None
        samples = late / self.period
        if abs(samples) > MAX_STEERED_SAMPLES:
            self._lasting.append(samples)
            if len(self._lasting) >= LASTING_WINDOWS and (
                min(self._lasting) > MAX_STEERED_SAMPLES or max(self._lasting) < -MAX_STEERED_SAMPLES
            ):
                self._last += round(min(map(abs, self._lasting)) * np.sign(samples)) * self.period
                self._lasting.clear()
                self.has_stepped = True
            self._lasting = self._lasting[-LASTING_WINDOWS + 1 :]
            return
        self._lasting.clear()
        self._last += PHASE_GAIN * late
        self.period *= 1 + PERIOD_GAIN * late / WINDOW_S

    def _begin_window(self, arrival: float) -> None:
        self._window_began, self._least = arrival, np.inf


def _least_late(index: FloatArray, arrival: FloatArray) -> tuple[float, float]:
    """Return the period [s] of the chunks that came least late in their half second, and sample 0's time [s].

    The last half second is not complete and is left out.
    """
    window = ((arrival - arrival[0]) / WINDOW_S).astype(np.int64)
    rows, began = np.flatnonzero(window < window[-1]), arrival[0]
    slope = offset = 0.0
    for _ in range(FIT_PASSES):
        slope, offset = (float(each) for each in np.polyfit(index[rows], arrival[rows] - began, 1))
        late = arrival - began - slope * index
        rows = np.array([np.flatnonzero(window == w)[late[window == w].argmin()] for w in np.unique(window)[:-1]])
    return slope, began + offset
