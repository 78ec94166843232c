"""Moves less what effects added to them: the samples, and where the placings were turned, the ends."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from procedures.arrays import FloatArray
from procedures.campaign.campaign import Campaign, MoveRecord
from procedures.counts.sample_records import CountSeries
from procedures.diagnosis.move_rows import MoveWeights, move_bins
from procedures.diagnosis.residual_rows import Evidence

Added = tuple[FloatArray | None, MoveWeights, FloatArray | None]


def without_in_moves(
    campaigns: Sequence[Campaign], evidence: Evidence, k: FloatArray, gyro: FloatArray | None,
    turned: FloatArray | None,
) -> tuple[Campaign, ...]:  # fmt: skip
    """Return campaigns whose moves are free of effects.

    Parameters
    ----------
    campaigns : with their moves as recorded
    evidence : whose nodes what is added holds at
    k : (3,) [output/deg], the gyroscopes' scale factors
    gyro : (n, 3) [deg/s], added to E u + D at the nodes, or None
    turned : (n, 3) [rad], by which all that is seen at the nodes is turned, or None
    """
    added = dict[tuple[int, str], Added]()
    for each in evidence.weights:
        if each.move is not None:
            step = evidence.excitation.steps[evidence.step[each.rows.start]]
            added[step.campaign, step.name] = (None if gyro is None else gyro[each.nodes], each.move, turned)
    return tuple(
        replace(
            campaign,
            moves=tuple(
                _less(one, k, *added[number, one.name]) if (number, one.name) in added else one
                for one in campaign.moves
            ),
        )
        for number, campaign in enumerate(campaigns)
    )


def _less(
    record: MoveRecord, k: FloatArray, gyro: FloatArray | None, weights: MoveWeights, turned: FloatArray | None
) -> MoveRecord:
    if turned is not None:
        off = np.radians(weights.of_ends(turned[:, :, None])[:, 0])
        record = replace(record, off=off)
    if gyro is None or record.series.gyro is None:
        return record
    series = record.series
    added = np.repeat(gyro * k, np.diff(move_bins(series).edges), axis=0)
    per_sample = series.period if isinstance(series, CountSeries) else 1.0
    less: Any = np.asarray(record.series.gyro) - added * per_sample  # of counts no whole numbers any more
    return replace(record, series=replace(series, gyro=less))
