"""Was the device switched off and on? Told by its clock where the stream begins anew.

A port that was away and came back finds the device's clock as much later as the station's. A device that was
switched on meanwhile says a time since then: earlier than before, or less later than time has passed. A clock that
stood still is a stream that was not read, as of a simulated device. Where the device sends no time its counter is
its clock; one that turns sooner than `MIN_TURN_S` tells nothing, nor does a clock that is set from outside.
"""

from drivers.wire import WireFormat
from station.stream.recorder.sample_stream import DecodedChunk

MIN_TURN_S = 60.0
ALLOWED_OFFSET_S, ALLOWED_DRIFT = 5.0, 0.02  # of what two clocks are read apart, and drift by in between


def switched_on_again(before_s: float, now_s: float, elapsed_s: float) -> bool:
    """Say whether a clock that does not turn began again in ``elapsed_s`` of the station's time."""
    went, allowed = now_s - before_s, ALLOWED_OFFSET_S + ALLOWED_DRIFT * elapsed_s
    if went < 0:
        return True
    is_short = went < elapsed_s - allowed and went > ALLOWED_OFFSET_S
    return is_short and now_s <= elapsed_s + allowed


def switched_on_again_within(before_s: float, now_s: float, elapsed_s: float, turn_s: float) -> bool:
    """Say the same of a clock that begins again every ``turn_s`` as well."""
    allowed = ALLOWED_OFFSET_S + ALLOWED_DRIFT * elapsed_s
    late = (now_s - before_s - elapsed_s) % turn_s
    if turn_s < MIN_TURN_S or min(late, turn_s - late) <= allowed:
        return False
    return now_s % turn_s <= elapsed_s + allowed


class PowerWatch:
    """Follows a stream and tells where its device was switched on again."""

    def __init__(self, wire: WireFormat) -> None:
        self._wire = wire
        self._last: tuple[float, int, int] | None = None  # time [s], counter, station's time [ns]

    def take(self, piece: DecodedChunk, period: float | None, *, has_time: bool) -> bool:
        """Look at a piece of the stream, ``period`` [s] a sample; return whether the device began again in it."""
        block = piece.block
        if not len(block):
            return False
        began_again = False
        if piece.anew is not None and self._last is not None and period:
            row = piece.anew
            before = self._last
            if row:
                before = float(block.device_time[row - 1]), int(block.counter[row - 1]), piece.chunk.host_ns
            now = float(block.device_time[row]), int(block.counter[row]), piece.chunk.host_ns
            began_again = self._began_again(before, now, period, has_time=has_time)
        self._last = float(block.device_time[-1]), int(block.counter[-1]), piece.chunk.host_ns
        return began_again

    def _began_again(
        self, before: tuple[float, int, int], now: tuple[float, int, int], period: float, *, has_time: bool
    ) -> bool:
        elapsed, turn = (now[2] - before[2]) / 1e9, self._wire.time_modulus
        frames = self._wire.counter_modulus
        by_counter = frames is not None and switched_on_again_within(
            before[1] * period, now[1] * period, elapsed, frames * period
        )
        if not has_time:
            return by_counter
        if turn is not None:
            return switched_on_again_within(before[0], now[0], elapsed, turn)
        is_told_apart = frames is not None and frames * period > MIN_TURN_S
        goes_on = is_told_apart and not by_counter  # a clock that was set: the frames go on counting
        return switched_on_again(before[0], now[0], elapsed) and not goes_on
