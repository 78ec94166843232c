"""A diagnosis of a bench that grows warmer, with a soak, rests between the faces and a seat that gives."""

from dataclasses import replace

import numpy as np

from drivers.simulated.bench_in_memory import ALL_POSITIONS, SimulatedBench, simulate_campaign
from procedures.campaign.campaign import DwellRecord, RestRecord, SoakRecord
from procedures.campaign.plan_steps import Dwell, turn_steps
from procedures.diagnosis.diagnose import diagnose
from procedures.frames import rotation
from tests.benchmarks.diagnosing.designs import unit
from tests.stored.diagnosis_told import some_effects, told
from tests.stored.held import assert_held

RISING = {"temperature_swing_k": 6.0, "temperature_swing_period_s": 7200.0}
EFFECTS = {
    "accelerometer.bias_temperature": {"x": 3e-5, "y": -2e-5, "z": 4e-5},
    "gyroscope.magnetic": {"xy": 0.02, "yx": 0.02},
    "placement.dwell": {"position": 5.0, "x": 4e-4, "y": -4e-4, "z": 4e-4},
}
TRIED = (
    "accelerometer.bias_drift", "accelerometer.bias_temperature", "accelerometer.temperature_lag",
    "accelerometer.cross_product", "fixture.parallelism", "gyroscope.bias_drift", "gyroscope.magnetic",
    "placement.dwell", "slab.tilt",
)  # fmt: skip
FREE = np.array([(0.5, 0.4, 0.1), (2.0, 0.7, -0.3), (-0.8, 0.2, 1.0), (0.3, -2.3, 0.4), (1.1, 1.2, 1.3)])


def test_a_bench_that_grows_warmer() -> None:
    truth = unit(3, effects=EFFECTS, **RISING)
    plain = simulate_campaign(truth, 3, dwell_s=20.0, turns=turn_steps(2, 3.0), certificate_sigma=5e-6)
    bench = SimulatedBench(truth, 3)
    dwells = tuple(DwellRecord(f"dwell_{p:02d}", p, bench.perform(Dwell(p, 20.0))) for p in ALL_POSITIONS)
    rests = tuple(RestRecord(f"free_{i}", None, bench.free(rotation(C), 20.0)) for i, C in enumerate(FREE))
    soak = SoakRecord("soak", 1, None, bench.perform(Dwell(1, 900.0)))
    found = diagnose([replace(plain, dwells=dwells, rests=rests, soaks=(soak,))], some_effects(*TRIED))
    assert_held("diagnosis", "while it warms", told(found), (".findings.gain",))
