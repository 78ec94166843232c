"""When a sample was taken, by the station's clock."""

from collections import deque

LAG_TICKS = 600
FEWEST_TICKS = 50
OTHER_PACE = 0.02  # a clock is a thousand times better: the device's sample period is not the one that it states


class SampleMoments:
    """When a sample was taken, by the station's clock; learnt from ticks in order, the same in a replay.

    A read is never before its last sample: the least that reads lag behind the device's clock is the link's own
    delay. It is asked anew of the last minute, in which the two clocks drift apart by milliseconds. The lag grows
    behind a device that goes slower than it says: it is then a line through the least of either half minute.
    """

    def __init__(self) -> None:
        self._lags: deque[tuple[int, int]] = deque(maxlen=LAG_TICKS)  # ns: how much, and the device's time

    def begin_anew(self) -> None:
        """Forget the lag: the device's clock may have begun anew."""
        self._lags.clear()

    def of(self, t: float, read_ns: int) -> int:
        """Return the moment [ns] of a sample at device time ``t`` [s], in bytes that were read at ``read_ns``."""
        device_ns = round(t * 1e9)
        self._lags.append((read_ns - device_ns, device_ns))
        return device_ns + self._lag(device_ns)

    def _lag(self, device_ns: int) -> int:
        lags = list(self._lags)
        if len(lags) >= FEWEST_TICKS:
            half = len(lags) // 2
            (before, begin), (least, at) = min(lags[:half]), min(lags[half:])
            if (grows := (least - before) / (at - begin)) > OTHER_PACE:
                return min(lags[-1][0], least + round(grows * (device_ns - at)))
        return min(lags)[0]
