"""Follows the cube's attitude from the counts of the stream, and reports a transfer that was too fast.

At rest gravity determines the face and the tilts, and the Earth's rate, over the whole rest, the heading. Between
two rests the gyroscopes' counts rotate it. What was not determined yet is marked as not known.
"""

from dataclasses import dataclass, field
from math import ceil

import numpy as np

from procedures.arrays import FloatArray
from procedures.bench.cube_attitude import (
    CubeAttitude,
    after_gap,
    attitude_of_up,
    heading_corrected,
    heading_to_position,
    propagated,
    tilt_corrected,
    without_heading,
)
from procedures.campaign.plan_steps import Turn
from procedures.frames import AXES
from procedures.geodesy import EARTH_RATE
from procedures.gyrocompass import (
    BIAS_STD_RAD_S,
    SCALE_SPREAD,
    earth_heading,
    first_position,
    rough_scale_factor,
)
from procedures.twelve_positions.placement_transfers import MAX_CONING_RAD, coning_of, long_enough_s
from procedures.units import RAD_PER_ARCSEC
from station.guide.checks.face_and_stillness import BlockLook
from station.guide.stages.stage_context import StageContext
from station.stream.live.stillness import Block, as_counts, series_of_runs

TURN_TICK_S = 0.05  # a hand turns a cube by some degrees in it
GRAVITY_WINDOW_S = 0.25  # of the newest samples, whose specific force is taken for gravity
LEVELLING_GAIN = 0.5  # of the way to where gravity seems to be, while hands push as well
MAX_FORCE_SHARE_OFF_GRAVITY = 0.1  # of gravity, by which the specific force may differ from it
MAX_REST_S = 60  # of a rest: a longer one is a soak, or lasts until biases have drifted
MARKS_STD = np.radians(2.0)  # how well the marks are kept to by a position that was accepted
KNOWN_HEADING_STD = np.radians(15.0)  # of a heading by which four directions can be distinguished
ROUGH_K_STD = 0.3
TURNED_K_STD = 0.005  # of a gyro that was turned itself: how the turn closed, and the Earth's rate


@dataclass(slots=True)
class _Rest:
    """The rest under way: how the cube stood as it began, and the blocks since."""

    before: CubeAttitude
    seconds: int = 0
    total: FloatArray = field(default_factory=lambda: np.zeros(6))

    @property
    def rate(self) -> FloatArray:
        """The mean count rate (6,)."""
        return self.total / self.seconds


class CubeTracker:
    """Follows the cube of a campaign; `now` is how it stands, None before the first second."""

    def __init__(self, context: StageContext) -> None:
        self._context = context
        self._base: CubeAttitude | None = None
        self.now: CubeAttitude | None = None
        self._block: Block | None = None  # the last one taken
        self._rest: _Rest | None = None
        self._resting: FloatArray | None = None  # (6,) count/s at rest, of the last rest
        self._scale: tuple[float, float] | None = None
        self._scaled_by: tuple[int, ...] = ()
        self._turned: dict[str, float] = {}  # scale factor [count/rad] of gyros that were turned, by cube axis
        self._outdated = 0  # a position from before nobody saw the cube for long

    @property
    def heading_std(self) -> float:
        """1 sigma of the heading [rad]; infinite where it is not known."""
        return float(np.inf) if self.now is None else self.now.heading_std(self._k_std)

    @property
    def is_heading_known(self) -> bool:
        """Whether four directions can be distinguished."""
        return bool(self.heading_std < KNOWN_HEADING_STD)

    def take(self, block: Block, look: BlockLook) -> None:
        """Take a second of the stream."""
        up = self._context.gate.way_up(block.rate[3:])
        base = attitude_of_up(up) if self._base is None else self._seen_since(self._base, block)
        self._learn_scale()
        if look.is_still:
            base = self._rested(base, block, look)
        else:
            self._rest = None
            base = self._moved(base, self._ticks(block.first, block.last))
            base = tilt_corrected(base, up, LEVELLING_GAIN) if self._is_gravity(block.rate[3:]) else base
        self._base = self.now = base
        self._block = block

    def show_newest(self) -> None:
        """Take what has come since the last whole second, for show only."""
        buffer, block, base = self._context.feed.buffer, self._block, self._base
        if block is None or base is None or not max(buffer.begin, buffer.first) <= block.last < buffer.end:
            return
        newest = max(block.last, buffer.end - max(round(GRAVITY_WINDOW_S / self._context.feed.period), 1))
        accel = as_counts(buffer.block(newest, buffer.end), self._context.feed.period).accel
        force = accel.mean(axis=0) / self._context.feed.period
        base = self._moved(base, self._ticks(block.last, buffer.end))
        gain = 1.0 if self._scale is None else LEVELLING_GAIN
        if self._is_gravity(force):
            base = tilt_corrected(base, self._context.gate.way_up(force), gain)
        self.now = base

    @property
    def _k_std(self) -> float:
        up = None if self.now is None else AXES[int(np.argmax(np.abs(self.now.up)))]
        if up in self._turned:
            return TURNED_K_STD
        return ROUGH_K_STD if self._scale is None else self._scale[1]

    def _seen_since(self, base: CubeAttitude, block: Block) -> CubeAttitude:
        """Return how the cube stands as the block begins: less sure after a gap, unsure after a new beginning."""
        last = self._block
        if block.is_restarted or last is None:
            self._rest, self._outdated = None, self._context.position
            return without_heading(base)
        if block.first == last.last and not block.is_broken:
            return base
        self._rest = None
        return after_gap(base, max(block.begins - last.ends, 0.0), self._k_std)

    def _rested(self, base: CubeAttitude, block: Block, look: BlockLook) -> CubeAttitude:
        rest = self._rest = self._rest or _Rest(base)
        if rest.seconds < MAX_REST_S:
            rest.seconds, rest.total = rest.seconds + 1, rest.total + block.rate
        self._resting = rest.rate
        level = tilt_corrected(rest.before, self._context.gate.way_up(rest.rate[3:]), 1.0)
        return self._with_accepted_heading(self._with_earth_heading(level, rest, look))

    def _with_earth_heading(self, level: CubeAttitude, rest: _Rest, look: BlockLook) -> CubeAttitude:
        """Return the resting cube with the heading from the Earth's rate, if it determines it."""
        context, rate, first = self._context, rest.rate[:3], 0.0
        k = None if self._scale is None else self._scale[0]
        if not context.accepted_dwells:  # then the scale factor is part of the question
            found = context.heading(rate, rest.seconds, look.face)
            if not found.is_sure or not look.is_upright:
                return level
            k = float(np.linalg.norm(rate)) / EARTH_RATE
            self._scale = (k, float(np.hypot(BIAS_STD_RAD_S / EARTH_RATE, SCALE_SPREAD)))
            first = heading_to_position(level, first_position(look.face)) + found.quarter * np.pi / 2
        if k is None:
            return level
        std = context.gyro_std(rest.seconds)
        turned = heading_corrected(without_heading(level), first, 0.0, 0.0)
        bench = context.bench.latitude, context.C_sb
        off, off_std = earth_heading(rate, std, turned.C_lb, *bench, k, context.known)
        whole = float(np.angle(np.exp(1j * (first + off))))
        return heading_corrected(level, whole, off_std, self._k_std)

    def _with_accepted_heading(self, level: CubeAttitude) -> CubeAttitude:
        """Return the cube with the heading of its accepted position, where nothing determines it better."""
        position = self._context.position
        self._outdated = self._outdated if position == self._outdated else 0
        if position == self._outdated or level.heading_std(self._k_std) < KNOWN_HEADING_STD:
            return level
        angle = heading_to_position(level, position)
        return heading_corrected(without_heading(level), angle, MARKS_STD, self._k_std)

    def _moved(self, base: CubeAttitude, counts: FloatArray) -> CubeAttitude:
        """Return the cube after the ``counts`` (n, 3) of the gyros; without their scale its heading is lost."""
        if self._scale is None:
            return without_heading(base)
        k = np.array([self._turned.get(axis, self._scale[0]) for axis in AXES])
        return propagated(base, counts @ self._context.C_sb / k)

    def _ticks(self, first: int, last: int) -> FloatArray:
        """Return what the gyros counted in each tick (n, 3), IMU axes, less what they count at rest."""
        period = self._context.feed.period
        gyro = as_counts(self._context.feed.buffer.block(first, last), period).gyro.astype(float)
        if self._resting is not None:
            gyro -= self._resting[:3] * period
        size = max(round(TURN_TICK_S / period), 1)
        return np.add.reduceat(gyro, np.arange(0, len(gyro), size)) if len(gyro) else np.zeros((0, 3))

    def _is_gravity(self, force: FloatArray) -> bool:
        """Say whether a specific force (3,) [count/s] may be gravity alone."""
        if self._resting is None:
            return True
        rest = float(np.linalg.norm(self._resting[3:]))
        return abs(float(np.linalg.norm(force)) - rest) < MAX_FORCE_SHARE_OFF_GRAVITY * rest

    def _learn_scale(self) -> None:
        """Take the gyros' scale factor from the accepted steps, once there are others."""
        context = self._context
        done = (len(context.accepted_dwells), len(context.turns))
        if done == self._scaled_by or not any(done):
            return
        self._scaled_by = done
        if context.turns:
            self._scale = (float(context.gyro_k or 0.0), SCALE_SPREAD)
            axes = {step.name: step.axis for step in context.checklist.steps if isinstance(step, Turn)}
            self._turned = {axes[n]: each.counts / (2 * np.pi) for n, each in context.turns.items() if n in axes}
        else:
            found = rough_scale_factor(context.known, context.bench.latitude, context.C_sb)
            is_sure = found is not None and found[1] <= ROUGH_K_STD
            self._scale = (found[0], float(np.hypot(found[1], SCALE_SPREAD))) if found and is_sure else None


class FastMoveWatch:
    """Looks at the move under way each time the cube has come to rest; the same move is complained of once."""

    def __init__(self, context: StageContext) -> None:
        self._context = context
        self._moved: list[Block] = []  # since it rested
        self._reported: int | None = None  # the first row of the move that was too brisk

    def take(self, block: Block, look: BlockLook) -> None:
        """Take a second of the stream."""
        begin = self._context.chain.oldest
        if begin is None or block.is_restarted or block.is_broken:
            self._moved.clear()
        elif not look.is_still:
            self._moved.append(block)
        elif self._moved:
            first, self._moved = self._moved[0], []
            if begin != self._reported:
                self._judge(begin, max(begin, first.first), block)

    def _judge(self, begin: int, first: int, block: Block) -> None:
        context, period = self._context, self._context.feed.period
        k = context.rough_gyro_k(block.rate[:3])
        series = series_of_runs(context.feed.buffer, [(first, block.last)], period)
        coning = coning_of(series, k * np.pi / 180 * np.eye(3), np.zeros(3))
        if not coning > MAX_CONING_RAD:
            return
        self._reported = begin
        context.chain.too_fast(coning)
        enough = ceil(long_enough_s(coning, (block.first - first) * period))
        found = f"{coning / RAD_PER_ARCSEC:.0f} arcsec of coning"
        context.event_log.say("still", f"moved too fast: {found}; at least {enough} s for a flip")
