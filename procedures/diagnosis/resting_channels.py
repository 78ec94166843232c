"""The channels of recordings at rest, each with what turns its samples into g or deg/h."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from procedures.arrays import FloatArray
from procedures.campaign.campaign import Campaign, RestRecord
from procedures.campaign.observations import channel
from procedures.diagnosis.disturbances import CHANNEL_LABELS, rough_scale
from procedures.frames import TRIADS


@dataclass(frozen=True, slots=True, eq=False)
class RestingChannel:
    """A channel's ``samples`` (n,) [output] at rest; ``per_unit`` outputs are 1 ``unit``, g or deg/h.

    ``label`` is ax ... gz; ``campaign`` and ``step`` number the recording.
    """

    campaign: int
    step: int
    rest: RestRecord
    triad: str
    axis: int
    samples: FloatArray
    per_unit: float

    @property
    def label(self) -> str:
        """The channel's name, ax ... gz."""
        return CHANNEL_LABELS[self.triad][self.axis]

    @property
    def unit(self) -> str:
        """The unit of its triad."""
        return "g" if self.triad == "accelerometer" else "deg/h"


def resting_channels(campaigns: Sequence[Campaign]) -> Iterator[RestingChannel]:
    """Yield the channels of every rest, rest by rest."""
    for number, campaign in enumerate(campaigns):
        for step, rest in enumerate(campaign.rests):
            for triad in TRIADS:
                if (samples := channel(rest.series, triad)) is None:
                    continue
                k = rough_scale(campaign, triad) * (rest.series.period if campaign.counts else 1.0)
                for axis in range(3):
                    x = np.asarray(samples[:, axis], dtype=np.float64)
                    yield RestingChannel(number, step, rest, triad, axis, x, float(abs(k[axis])))
