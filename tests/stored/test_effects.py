"""What each effect adds to the sensors at the nodes of one campaign, and what each planted one does to a bench."""

from dataclasses import replace
from functools import cache

import numpy as np

from drivers.simulated.bench_in_memory import ALL_POSITIONS, SimulatedBench, simulate_campaign
from drivers.simulated.effects import EFFECTS as PLANTED
from drivers.simulated.imu import SimulatedImu
from drivers.simulated.truth import Truth
from drivers.simulated.vehicle_track import VehicleTrack
from procedures.calibration.joint_calibration import fit
from procedures.campaign.campaign import DwellRecord, SoakRecord
from procedures.campaign.plan_steps import Dwell, Turn, turn_steps
from procedures.effects import EFFECTS
from procedures.evidence.residual_rows import Evidence, evidence_of
from tests.stored.conftest import StoredResult
from tests.stored.small_campaigns import unit

TRUTH = replace(
    Truth.example(4), accel_instability_g=1e-6, gyro_instability_dph=0.1, temperature_rise_k=5.0,
    temperature_swing_k=2.0, temperature_swing_period_s=100.0, settle_rad=1e-4,
    effects={"accelerometer.relaxation": {"x": 1e-3}, "gyroscope.scale_temperature": {"x": 50.0}},
)  # fmt: skip


@cache
def evidence() -> Evidence:
    """Twelve positions, turns and a soak of a unit in a field that grows warmer, with an auxiliary channel."""
    truth = unit(
        3, temperature_rise_k=6.0, temperature_tau_s=900.0, temperature_swing_k=2.0,
        temperature_swing_period_s=1300.0, magnetic_enu_ut=np.array([-3.0, 34.0, -36.0]),
    )  # fmt: skip
    plain = simulate_campaign(truth, 3, dwell_s=10.0, turns=turn_steps(1, 2.0), certificate_sigma=5e-6)
    bench = SimulatedBench(truth, 3)
    series = [bench.perform(Dwell(p, 10.0)) for p in ALL_POSITIONS]
    soak = bench.perform(Dwell(1, 300.0))
    *parts, soak = (replace(each, extra={"aux_pump": np.sin(each.t / 40)}) for each in (*series, soak))
    dwells = tuple(DwellRecord(f"dwell_{p:02d}", p, each) for p, each in zip(ALL_POSITIONS, parts, strict=True))
    campaign = replace(plain, dwells=dwells, soaks=(SoakRecord("soak", 1, None, soak),))
    return evidence_of(fit([campaign]))


def test_the_columns_of_effects(stored_result: StoredResult) -> None:
    """Of each effect its first two variants: columns, prior standard deviations, what is shown of them."""
    excitation, found = evidence().excitation, dict[str, object]()
    for effect in EFFECTS:
        variants = []
        for way in list(effect.columns(excitation))[:2]:
            sizes = effect.plausible_of(way)
            shown = None if effect.shown is None else effect.shown(sizes, 0.1 * sizes)
            columns = {name: None if each is None else np.array(each).ravel() for name, each in
                       (("accel", way.accel), ("gyro", way.gyro))}  # fmt: skip
            variants.append({"coefficients": way.coefficients, "unit": way.unit, **columns, "prior": sizes,
                             "shown": shown})  # fmt: skip
        found[effect.name] = variants
    stored_result.check(found)


def test_planted_effects_in_a_bench_without_noise(stored_result: StoredResult) -> None:
    """Each coefficient has a size of its own; positions 4 and 9 and a turn show what an effect may depend on."""
    found = dict[str, object]()
    for name, effect in PLANTED.items():
        sizes = {key: 1e-3 * (1 + 0.1 * i) for i, key in enumerate(effect.keys)}
        if name == "placement.label":
            sizes = {"position": 4, "actual": 5}
        bench = SimulatedBench(replace(TRUTH, effects={name: sizes}), None)
        steps = (Dwell(4, 3.0), Turn("x", "+", 1, 1, 1.0), Dwell(9, 3.0))
        found[name] = [(each.gyro.sum(axis=0), each.accel.sum(axis=0)) for each in map(bench.perform, steps)]
    stored_result.check(found)


def test_what_hands_and_a_vehicle_do_to_a_simulated_unit(stored_result: StoredResult) -> None:
    def moved() -> SimulatedImu:
        imu = SimulatedImu(TRUTH, 3)
        imu.rest(1.0)
        imu.place(3, 4.0, np.array([1e-3, -2e-3, 5e-4]))
        imu.heat(3.0, 20.0)
        imu.turn("x", "-", 1, rest_s=1.0)
        imu.shock(0.5, 0.02)
        imu.creep(1.0, np.array([0.0, 1e-3, 2e-3]))
        imu.tilt(np.array([1.0, 1.0, 0.3]), 3.0)
        t = np.arange(0.0, 21.0, 5.0)
        imu.drive(VehicleTrack(t + imu.done, np.stack((3 * t, 40 * np.sin(t / 9), 0.1 * t), axis=1)))
        return imu

    imu = moved()
    stored_result.check({"done": imu.done, "counts": imu.read(4000), "rates": moved().read_rates(4000)})
