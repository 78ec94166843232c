"""A diagnosis of a bench in counts with as much wrong at once as the loop tells apart."""

from dataclasses import replace

import numpy as np

from drivers.simulated.bench_in_memory import simulate_campaign
from procedures.campaign.campaign import RateTable
from procedures.campaign.plan_steps import turn_steps
from procedures.diagnosis.diagnose import diagnose
from procedures.uncertainty.budget import budget
from procedures.uncertainty.given_values import GivenValues
from tests.benchmarks.diagnosing.designs import unit
from tests.procedures.diagnosis.planted import with_reference_time
from tests.stored.diagnosis_told import some_effects, told
from tests.stored.held import assert_held

EFFECTS = {
    "accelerometer.quadratic": {"x": 3e-4, "y": -2e-4},
    "gyroscope.g_sensitivity": {"xx": 3.0, "yz": -2.0},
    "clock.rate": {"value": 300.0},
    "disturbance.dwell": {
        "x": 3e-2, "y": 2e-2, "z": 1e-2, "position": 4.0, "at_s": 8.0, "duration_s": 4.0, "hz": 3.0
    },
}  # fmt: skip
TRIED = (
    "accelerometer.quadratic", "accelerometer.cubic", "accelerometer.relaxation", "fixture.parallelism",
    "gyroscope.g_sensitivity", "gyroscope.magnetic", "gyroscope.scale_nonlinearity", "gyroscope.sagnac_sine",
    "gyroscope.scale_temperature", "slab.tilt",
)  # fmt: skip
RATES = np.concatenate((np.arange(0, 101, 10), -np.arange(0, 101, 10)))


def table(seed: int) -> RateTable:
    """A sensor turned about z: -2e4 a deg/s, a cubic of -2 ppm/(deg/s)^2 and a scale of -400 ppm/K."""
    u = np.tile(RATES, 5).astype(float)
    T = 40 + 10 * np.linspace(0, 1, len(u)) ** 0.7
    rate = (u + 0.01 - 2e-6 * u**3) * (1 - 4e-4 * (T - 25))
    output = np.full((len(u), 3), np.nan)
    output[:, 2] = -2e4 * (rate + 2e-3 * np.random.default_rng(seed).standard_normal(len(u)))
    return RateTable("rates_z.csv", "z", u, output, T)


def test_a_bench_in_counts_with_a_rate_table() -> None:
    bench = simulate_campaign(
        unit(1, effects=EFFECTS), 1, dwell_s=20.0, certificate_sigma=5e-6, turns=turn_steps(2, 3.0), repeats=1
    )
    campaign = replace(with_reference_time(bench, 300.0, 2), rate_tables=(table(2),))
    found = diagnose([campaign], some_effects(*TRIED))
    assert_held("diagnosis", "counts", told(found))
    assert_held("diagnosis", "counts, budget", budget(found.after, GivenValues(clock=found.clock)))
