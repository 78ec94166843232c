"""Unsegmented recordings cut into rests and the moves between them."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from procedures.campaign.campaign import Campaign, RestRecord, SequenceRecord
from procedures.rests_and_moves.norm_fit import choose_rests
from procedures.rests_and_moves.rest_detection import rests_of, scatter_level
from procedures.units import STANDARD_GRAVITY


@dataclass(frozen=True, slots=True, eq=False)
class SegmentedSequence:
    """A sequence of campaign number ``campaign``: its rests and where they lie."""

    campaign: int
    record: SequenceRecord
    stretches: tuple[slice, ...]
    rests: tuple[RestRecord, ...]

    def moves(self) -> list[tuple[int, slice]]:
        """Return per move without a gap the number of the rest it begins from, and its samples."""
        gaps = self.record.series.starts
        found = []
        for i, (before, after) in enumerate(zip(self.stretches, self.stretches[1:], strict=False)):
            if not np.any((gaps > before.stop - 1) & (gaps <= after.start)):
                found.append((i, slice(before.stop, after.start)))
        return found


def segment(campaigns: Sequence[Campaign]) -> tuple[SegmentedSequence, ...]:
    """Find the rests of every sequence."""
    found = []
    for number, campaign in enumerate(campaigns):
        for record in campaign.sequences:
            measured = scatter_level(record.series)
            _, stretches = choose_rests(measured, campaign.site.gravity / STANDARD_GRAVITY)
            rests = rests_of(record, stretches)
            found.append(SegmentedSequence(number, record, tuple(stretches), rests))
    return tuple(found)


def all_rests(
    campaigns: Sequence[Campaign], segmented: Sequence[SegmentedSequence]
) -> list[tuple[int, RestRecord]]:
    """Return every rest outside the twelve positions with its campaign's number: those of sequences last."""
    alone = [(number, rest) for number, campaign in enumerate(campaigns) for rest in campaign.rests]
    return [*alone, *((each.campaign, rest) for each in segmented for rest in each.rests)]
