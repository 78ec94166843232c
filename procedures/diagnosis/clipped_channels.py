"""Channels at rest whose largest or smallest value comes far too often: an output at the end of its range."""

from collections.abc import Iterator, Sequence

import numpy as np

from procedures.campaign.campaign import Campaign
from procedures.diagnosis.disturbances import EFFECT
from procedures.diagnosis.resting_channels import RestingChannel, resting_channels
from procedures.diagnosis.result import CERTAIN, Finding

MIN_ROWS, MIN_SHARE = 20, 0.005  # that stand at one end
MIN_TIMES = 20.0  # as often as any other value: a coarse output's values all come often


def clipped_channels(campaigns: Sequence[Campaign]) -> Iterator[Finding]:
    """Yield a finding for each channel of a recording at rest that stands at an end of its range for some rows."""
    for one in resting_channels(campaigns):
        levels, often = np.unique(one.samples, return_counts=True)
        if len(levels) < MIN_TIMES:
            continue
        usual = int(np.max(often[1:-1]))
        for end, name in ((-1, "largest"), (0, "smallest")):
            rows = int(often[end])
            if rows >= max(MIN_ROWS, MIN_SHARE * len(one.samples)) and rows >= MIN_TIMES * usual:
                yield _finding(one, float(levels[end]), rows, name)


def _finding(one: RestingChannel, value: float, rows: int, name: str) -> Finding:
    share = 100 * rows / len(one.samples)
    return Finding(
        EFFECT, "procedure", ("value",), np.array([value]) / one.per_unit,
        np.array([float(one.samples.std())]) / one.per_unit, one.unit,
        {"file": one.rest.name, "channel": one.label}, CERTAIN,
        "the recording again with a wider range", None,
        f"clipped: {share:.2g} % of the rows stand at its {name} value",
    )  # fmt: skip
