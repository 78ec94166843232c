"""The device's clock as a campaign's own records show it, against reference time beside the rows (``utc_s``).

Nothing is concluded from a reference that leaves the rate open to more than 0.1 % or is no time [s] of these rows.
"""

import numpy as np

from procedures.arrays import FloatArray
from procedures.campaign.campaign import Campaign
from procedures.counts.reference_time import ClockRate, fit_clock
from procedures.units import PPM_PER_ONE

MAX_CLOCK_PPM = 5e4  # ppm: beyond, no clock is off
MAX_RATE_ERROR = 1e-3  # relative: 4 sigma of a rate from which something is concluded
RATE_SIGMAS = 4.0
MAX_PACE = 20.0  # times as fast, or as slow: no device is set as wrong, utc_s is no time [s] of these rows
MIN_RECORD_S = 2.0  # of a record that tells it


def is_known(rate: ClockRate) -> bool:
    """Say whether a rate is known to 0.1 %, by four sigma."""
    return RATE_SIGMAS * rate.std / PPM_PER_ONE <= MAX_RATE_ERROR


def clock_rate(campaign: Campaign) -> ClockRate | None:
    """Fit reference time over device time where rows hold it; None where too few do, or it is no time [s]."""
    return None if false_pace(campaign) is not None else fit_clock(_pieces(campaign))


def false_pace(campaign: Campaign) -> float | None:
    """Return by how much ``utc_s`` moves in a device's second where it is no time [s] of these rows; else None.

    Milliseconds move by 1000, what runs backwards by -1, a constant by 0. Median of the records.
    """
    paces, grains = list[float](), list[float]()
    for t, u in _pieces(campaign):
        t, u = t[known := np.isfinite(t) & np.isfinite(u)], u[known]
        if len(t) and t[-1] - t[0] >= MIN_RECORD_S:
            steps = np.abs(np.diff(u))
            paces.append(float((u[-1] - u[0]) / (t[-1] - t[0])))
            grains.append(float(np.median(steps[steps > 0])) / float(t[-1] - t[0]) if steps.any() else 0.0)
    if not paces:
        return None
    pace, grain = float(np.median(paces)), float(np.median(grains))
    is_time = (
        pace < MAX_PACE and pace + 2 * grain > 1 / MAX_PACE
    )  # coarse stamps may stand still in a short record
    return None if is_time else pace


def _pieces(campaign: Campaign) -> list[tuple[FloatArray, FloatArray]]:
    return [
        (s.t, s.extra["utc_s"])
        for step in (*campaign.steps, *campaign.soaks)
        if "utc_s" in (s := step.series).extra
    ]
