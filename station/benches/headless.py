"""The bench without a screen: has the cube moved, waits until it rests on the right face, records, accepts.

Nothing is asked of the hands but to do as told: what the counts show decides. A knock discards the disturbed
seconds only; a cube that was lifted, or a device that began anew, begins the step again. The human has all the
time there is, the stream has 2 s.
"""

from collections.abc import Callable

from drivers.errors import DriverError
from procedures.arrays import FloatArray
from procedures.frames import face_of
from procedures.records import CountSeries
from procedures.steps import Dwell, Step, Turn
from station.benches.face import remark
from station.benches.hands import Hands
from station.benches.live_feed import LiveFeed
from station.benches.progress import Phase, Progress
from station.benches.spans import merged, series
from station.benches.stillness import Block, Stillness
from station.benches.turning import TurnWatch
from station.recorder import CampaignRecorder
from station.recorder.tape import Run

SETTLE_BLOCKS = 3  # discarded once the cube is still
KNOCK_BLOCKS = 3  # a longer disturbance was more than a knock
KEPT_BLOCKS = 8  # of the past, besides those of the step
TURN_ATTEMPTS = 5


class TurnFailed(DriverError):
    """A turn failed again and again; ``reason`` is that of the last time."""

    def __init__(self, name: str, reason: str) -> None:
        self.name, self.reason = name, reason
        super().__init__(f"{name}: failed {TURN_ATTEMPTS} times, expected one good turn; the last time {reason}")


class HeadlessBench:
    """Performs dwells and turns on live data; a `procedures.steps.Bench`.

    Parameters
    ----------
    feed : LiveFeed
        The device's stream, its unit identified.
    hands : Hands
        Who moves the cube.
    recorder : CampaignRecorder
        Where accepted steps go.
    C_ib : (3, 3)
        Takes the cube's axes to the IMU's.
    progress
        Told about every second; must return at once.
    """

    def __init__(
        self,
        feed: LiveFeed,
        hands: Hands,
        recorder: CampaignRecorder,
        C_ib: FloatArray,
        progress: Callable[[Progress], None],
    ) -> None:
        self._feed, self._hands, self._recorder, self._C_ib = feed, hands, recorder, C_ib
        self._progress = progress
        self._blocks = feed.blocks()
        self._stillness = Stillness()
        self._turns: dict[int, float] = {}  # counts per revolution of each turn accepted so far
        self._position: int | None = None
        self._step: Step | None = None

    def perform(self, step: Step) -> CountSeries:
        """Have ``step`` done, record it, and return it once it is accepted."""
        self._step = step
        runs = self._dwell(step) if isinstance(step, Dwell) else self._turn(step)
        self._recorder.accept(step, self._feed.tape, runs)
        self._say("accepted", self._seconds(runs), self._seconds(runs))
        return series(self._feed.tape, runs, self._feed.period)

    def _dwell(self, step: Dwell) -> list[Run]:
        self._put(step.position)
        wanted, face = round(step.seconds / self._feed.period), face_of(step.position)
        kept, disturbed = list[Block](), 0
        while True:
            block = self._next(keep=kept[0] if kept else None)
            if block.is_anew or disturbed > KNOCK_BLOCKS:
                self._say("redo", 0.0, step.seconds, "interrupted" if block.is_anew else "moved")
                kept, disturbed = [], 0
                self._settle(step.position)
                continue
            note = self._hindrance(block, face)
            disturbed = disturbed + 1 if note else 0
            if not note:
                kept.append(block)
            if sum(b.last - b.first for b in kept) >= wanted:
                kept = [b for b in kept if self._stillness.is_still(b)]  # by the noise as it is known now
            self._say("dwell", min(self._sum(kept), step.seconds), step.seconds, note)
            if sum(b.last - b.first for b in kept) >= wanted:
                return merged(kept, wanted)

    def _turn(self, step: Turn) -> list[Run]:
        if self._position != step.start_position:
            self._put(step.start_position)
        reason = ""
        for _ in range(TURN_ATTEMPTS):
            watch = TurnWatch(step, self._C_ib, self._feed.period, list(self._turns.values()))
            for _ in range(watch.rest_blocks):
                watch.rest(self._next_still(step))
            self._hands.turn(step)
            while not watch.is_over:
                block = self._next(keep=watch.first)
                watch.take(block, is_still=self._stillness.is_still(block))
                self._say("turn", watch.moved_s, 0.0)
            reason = watch.fault()
            if not reason:
                self._turns[len(self._turns)] = watch.counts_per_revolution
                return merged(watch.step_blocks(), None)
            self._say("redo", 0.0, 0.0, reason)
        raise TurnFailed(step.name, reason)

    def _put(self, position: int) -> None:
        """Have the cube placed and wait until it stands there."""
        self._say("place")
        is_first, self._position = self._position is None, None
        done = self._hands.place(position)
        has_moved = is_first
        while not (self._is_past(done) if done is not None else has_moved):
            block = self._next()
            has_moved |= self._stillness.is_known and not self._stillness.is_still(block)
        self._settle(position)
        self._position = position

    def _is_past(self, device_time: float) -> bool:
        block = self._next()
        return block.begins >= device_time

    def _settle(self, position: int) -> None:
        """Wait for the right face and some still seconds in a row; they are not used."""
        face, still = face_of(position), 0
        while still < SETTLE_BLOCKS:
            block = self._next()
            note = self._hindrance(block, face)
            still = 0 if note else still + 1
            self._say("settle", still, SETTLE_BLOCKS, note)

    def _next_still(self, step: Turn) -> Block:
        while True:
            block = self._next()
            note = self._hindrance(block, face_of(step.start_position))
            if not note:
                return block
            self._say("settle", 0.0, step.rest_s, note)

    def _hindrance(self, block: Block, face: str) -> str:
        wrong_face = remark(block.rate[3:], self._C_ib, face)
        if wrong_face:
            return wrong_face
        if not block.is_healthy:
            return "the device reports a fault"
        if not self._stillness.is_known:
            return "learning the noise"
        return "" if self._stillness.is_still(block) else "waiting for still"

    def _next(self, keep: Block | None = None) -> Block:
        """Return the next block; samples before ``keep`` are let go."""
        block = next(self._blocks)
        self._stillness.learn(block)
        past = block.first - KEPT_BLOCKS * (block.last - block.first)
        self._feed.tape.forget_before(past if keep is None else keep.first)
        return block

    def _say(self, phase: Phase, seconds: float = 0.0, wanted: float = 0.0, note: str = "") -> None:
        assert self._step is not None
        self._progress(Progress(self._step, phase, seconds, wanted, note))

    def _sum(self, blocks: list[Block]) -> float:
        return sum(b.last - b.first for b in blocks) * self._feed.period

    def _seconds(self, runs: list[Run]) -> float:
        return sum(last - first for first, last in runs) * self._feed.period
