"""Transfers: the rows between an accepted step and the next, where nothing interrupts them.

A step that is recorded again, a gap, a restart and an interruption of the campaign leave no rotation from one
placement to the next: then no transfer is recorded, and the reason is kept.
"""

from procedures.campaign.plan_steps import Dwell, Step, Turn
from procedures.units import RAD_PER_ARCSEC
from station.stream.recorder.accepted_step_writer import MovedFrom
from station.stream.recorder.sample_buffer import SampleBuffer

MAX_MOVE_S = 600.0  # s of rows that are kept from step to step, which bounds the memory that a break takes
MIN_MOVE_S = 1.0  # s; a turn that follows a turn at once leaves no move between them
LOST, RESTARTED = "samples were lost", "the data stream restarted"
LONG = f"it took more than {MAX_MOVE_S / 60:.0f} min"
SWITCHED, INTERRUPTED = "the unit was switched off and on", "the campaign was interrupted"
DEAD = "a channel was dead during the transfer"
SAME, UNEVEN = "the step before was recorded again", "its samples did not arrive at the unit's period"
MAX_UNEVEN = 0.4  # of a period, by which a move's rows may begin early or late; a folder is refused at 0.5


class TransferChain:
    """``why`` says why there is no move to the next step, empty while there may be one.

    ``is_resumed``: steps were accepted before, of whose rows none is left.
    """

    def __init__(self, *, is_resumed: bool) -> None:
        self._step: Step | None = None  # that the cube is carried from
        self._file = ""
        self._end = 0  # one beyond its last row ...
        self._ended_s = 0.0  # ... which was at this device time
        self.why = INTERRUPTED if is_resumed else ""
        self.doubt = ""  # of the move under way, though it is recorded

    @property
    def oldest(self) -> int | None:
        """The first row of the move under way; None where there is none."""
        return self._end if self._step is not None and not self.why else None

    def broken(self, why: str) -> None:
        """Take it that no rotation leads from the last step to the next."""
        if self._step is not None:
            self.why = self.why or why

    def too_fast(self, coning: float) -> None:
        """Take it that coning leaves 1 sigma ``coning`` [rad] open in the move under way, too much to be used."""
        self.doubt = f"its transfer is not used, {coning / RAD_PER_ARCSEC:.0f} arcsec of coning"

    def look(self, buffer: SampleBuffer, needed: int, period: float) -> None:
        """See whether the rows go on up to the sample ``needed``; ``period`` [s]."""
        if self._step is None or self.why:
            return
        if buffer.begin > self._end:
            self.broken(RESTARTED)
        elif len(buffer.breaks(self._end, needed + 1)):
            self.broken(LOST)
        elif (needed - self._end) * period > MAX_MOVE_S:
            self.broken(LONG)

    def move_to(self, step: Step, first: int, buffer: SampleBuffer, period: float) -> MovedFrom | None:
        """Return the rows before the sample ``first``, with which ``step`` begins; None where there is no move."""
        self.look(buffer, first, period)
        if self._step is not None and self._step.name == step.name:
            self.broken(SAME)
        if self._step is None or self.why or not is_placement(step) or (first - self._end) * period < MIN_MOVE_S:
            return None
        ends = [self._ended_s, *(_time_s(buffer, at) for at in (self._end, first - 1, first))]
        if max(abs(ends[1] - ends[0] - period), abs(ends[3] - ends[2] - period)) > MAX_UNEVEN * period:
            self.broken(UNEVEN)
            return None
        return MovedFrom(self._file, (self._end, first))

    def begin(self, step: Step, file: str, end: int, buffer: SampleBuffer) -> None:
        """Take it that the cube is carried from ``step``, whose last row is before the sample ``end``."""
        self._step, self._file, self._end, self.why = step if is_placement(step) else None, file, end, ""
        self.doubt = ""
        self._ended_s = _time_s(buffer, end - 1)


def _time_s(buffer: SampleBuffer, sample: int) -> float:
    """Return the device time [s] of a sample."""
    return float(buffer.block(sample, sample + 1).device_time[0])


def is_placement(step: Step) -> bool:
    """Say whether a step is one that moves lead from and to: a dwell in a known attitude, or a turn."""
    return isinstance(step, Dwell | Turn)
