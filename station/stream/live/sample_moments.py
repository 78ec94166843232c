"""When a sample was taken, by the station's clock."""

from collections import deque

LAG_TICKS = 600


class SampleMoments:
    """When a sample was taken, by the station's clock; learnt from ticks in order, the same in a replay.

    A read is never before its last sample: the least that reads lag behind the device's clock is the link's own
    delay. It is asked anew of the last minute, in which the two clocks drift apart by milliseconds.
    """

    def __init__(self) -> None:
        self._lags: deque[int] = deque(maxlen=LAG_TICKS)

    def begin_anew(self) -> None:
        """Forget the lag: the device's clock may have begun anew."""
        self._lags.clear()

    def of(self, t: float, read_ns: int) -> int:
        """Return the moment [ns] of a sample at device time ``t`` [s], in bytes that were read at ``read_ns``."""
        device_ns = round(t * 1e9)
        self._lags.append(read_ns - device_ns)
        return device_ns + min(self._lags)
