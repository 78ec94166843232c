"""Campaigns with effects planted by the simulator, which shares no code with the diagnosis."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from drivers.simulated.bench_in_memory import simulate_campaign
from drivers.simulated.truth import Truth
from procedures.campaign.campaign import Campaign, DwellRecord
from procedures.campaign.plan_steps import turn_steps
from procedures.counts.sample_records import Series

Effects = Mapping[str, Mapping[str, float]]


def planted(seed: int, effects: Effects | None = None, dwell_s: float = 20.0, turns: bool = False) -> Campaign:
    """Return a campaign of an example unit with short dwells."""
    truth = replace(Truth.example(seed), effects=effects or {})
    return simulate_campaign(truth, seed, dwell_s=dwell_s, turns=turn_steps(2, 3.0) if turns else ())


def lively(seed: int) -> dict[str, dict[str, float]]:
    """Return effects of all kinds, far larger than a healthy unit's: none of them a label, a shock or a clock."""
    rng = np.random.default_rng(seed)
    size = rng.standard_normal(12)
    return {
        "gyroscope.g_sensitivity": {"xx": 5 * size[0], "yz": 5 * size[1], "zy": 5 * size[2]},
        "gyroscope.magnetic": {"xx": 0.05 * size[3], "yz": 0.05 * size[4]},
        "gyroscope.bias_drift": {"x": 5 * size[5], "z": 5 * size[6]},
        "accelerometer.quadratic": {"x": 1e-3, "y": -1e-3},
        "accelerometer.relaxation": {"x": 1e-3 * size[7], "z": 3e-4 * size[8], "tau_s": float(rng.uniform(5, 40))},
        "accelerometer.bias_drift": {"y": 1e-3 * size[9]},
        "placement.dwell": {"position": float(rng.integers(1, 13)), "x": 5e-4, "y": -5e-4, "z": 5e-3},
        "fixture.face_tilt": {"x_up.y": 1e-3, "z_down.x": -1e-3},
    }


def drifting(campaign: Campaign, seed: int, size: float) -> Campaign:
    """Return a campaign in each of whose dwells accelerometer x moves by a ramp of +-``size`` counts a sample.

    Up or down by chance, the mean as it was: no effect of the catalogue does that.
    """
    rng = np.random.default_rng(seed)

    def tilted(dwell: DwellRecord) -> DwellRecord:
        accel = np.array(dwell.series.accel)
        ramp = np.linspace(-1, 1, len(accel)) * size * rng.choice([-1, 1])
        accel[:, 0] += np.diff(np.floor(np.cumsum(ramp) + 0.5), prepend=0.0).astype(accel.dtype)
        return replace(dwell, series=replace(dwell.series, accel=accel))

    return replace(campaign, dwells=tuple(tilted(dwell) for dwell in campaign.dwells))


def with_reference_time(
    campaign: Campaign, ppm: float, seed: int, jitter: float = 1e-3, step: float = 0
) -> Campaign:
    """Return a campaign whose rows hold reference time [s], jittery and in steps, of a clock ``ppm`` too fast."""
    rng = np.random.default_rng(seed)

    def timed(series: Series) -> Series:
        utc = 1.7e9 + series.t / (1 + 1e-6 * ppm) + jitter * rng.standard_normal(len(series))
        utc[:: max(len(utc) // 7, 1)] = np.nan
        return replace(series, extra={"utc_s": np.floor(utc / step) * step if step else utc})

    dwells = tuple(replace(each, series=timed(each.series)) for each in campaign.dwells)
    return replace(campaign, dwells=dwells)
