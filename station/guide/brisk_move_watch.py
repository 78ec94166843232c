"""Was the cube carried too briskly for its sample rate? Said as soon as it rests again."""

from math import ceil

import numpy as np

from procedures.twelve_positions.placement_transfers import MAX_CONING_RAD, coning_of, long_enough_s
from procedures.units import RAD_PER_ARCSEC
from station.guide.face_and_stillness import BlockLook
from station.guide.stage_context import StageContext
from station.stream.live.stillness import Block, series_of_runs


class BriskMoveWatch:
    """Looks at the move under way each time the cube has come to rest; the same move is complained of once."""

    def __init__(self, context: StageContext) -> None:
        self._context = context
        self._moved: list[Block] = []  # since it rested
        self._told: int | None = None  # the first row of the move that was too brisk

    def take(self, block: Block, look: BlockLook) -> None:
        """Take a second of the stream."""
        begin = self._context.chain.oldest
        if begin is None or block.is_restarted or block.is_broken:
            self._moved.clear()
        elif not look.is_still:
            self._moved.append(block)
        elif self._moved:
            first, self._moved = self._moved[0], []
            if begin != self._told:
                self._judge(begin, max(begin, first.first), block)

    def _judge(self, begin: int, first: int, block: Block) -> None:
        context, period = self._context, self._context.feed.period
        k = context.rough_gyro_k(block.rate[:3])
        series = series_of_runs(context.feed.buffer, [(first, block.last)], period)
        coning = coning_of(series, k * np.pi / 180 * np.eye(3), np.zeros(3))
        if not coning > MAX_CONING_RAD:
            return
        self._told = begin
        context.chain.brisk(coning)
        enough = ceil(long_enough_s(coning, (block.first - first) * period))
        arcsec = coning / RAD_PER_ARCSEC
        context.event_log.say(
            "still", f"moved too fast: {arcsec:.0f} arcsec of coning; at least {enough} s for a flip"
        )
