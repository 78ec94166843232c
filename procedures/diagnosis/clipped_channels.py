"""Channels at rest whose largest or smallest value comes far too often: an output at the end of its range."""

from collections.abc import Iterator, Sequence

import numpy as np

from procedures.arrays import FloatArray
from procedures.campaign.campaign import Campaign, RestRecord
from procedures.campaign.observations import channel
from procedures.diagnosis.disturbances import CHANNEL_LABELS, EFFECT, rough_scale
from procedures.diagnosis.result import Finding
from procedures.frames import TRIADS

MIN_ROWS, MIN_SHARE = 20, 0.005  # that stand at one end
MIN_TIMES = 20.0  # as often as any other value: a coarse output's values all come often
LOG_P_OF_A_ROW = np.log(1 / MIN_TIMES)


def clipped_channels(campaigns: Sequence[Campaign]) -> Iterator[Finding]:
    """Yield a finding for each channel of a recording at rest that stands at an end of its range for some rows."""
    for campaign in campaigns:
        for rest in campaign.rests:
            for triad in TRIADS:
                if (samples := channel(rest.series, triad)) is not None:
                    for axis in range(3):
                        yield from _of(campaign, rest, triad, axis, np.asarray(samples[:, axis], dtype=np.float64))


def _of(campaign: Campaign, rest: RestRecord, triad: str, axis: int, x: FloatArray) -> Iterator[Finding]:
    levels, often = np.unique(x, return_counts=True)
    if len(levels) < MIN_TIMES:
        return
    for end, name in ((-1, "largest"), (0, "smallest")):
        rows, usual = int(often[end]), int(np.max(often[1:-1]))
        if rows < max(MIN_ROWS, MIN_SHARE * len(x)) or rows < MIN_TIMES * usual:
            continue
        k = float(rough_scale(campaign, triad)[axis]) * (rest.series.period if campaign.counts else 1.0)
        yield Finding(
            EFFECT, "procedure", ("value",), np.array([levels[end] / k]), np.array([float(x.std()) / abs(k)]),
            "g" if triad == "accelerometer" else "deg/h",
            {"file": rest.name, "channel": CHANNEL_LABELS[triad][axis]}, "established", (),
            "the recording again with a wider range", float(rows * LOG_P_OF_A_ROW), 0.0,
            f"clipped: {100 * rows / len(x):.2g} % of the rows stand at its {name} value",
        )  # fmt: skip
