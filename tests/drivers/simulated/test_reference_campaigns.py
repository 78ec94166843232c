"""The campaigns of `shared/data`, made by another generator of the same physics, through this model."""

import json
from dataclasses import replace

import numpy as np
import pytest

from drivers.simulated.bench_in_memory import SimulatedBench
from drivers.simulated.cube_motion import rest
from drivers.simulated.truth import Truth
from procedures.arrays import FloatArray
from procedures.campaign.plan_steps import Dwell
from tests.paths import DATA

CAMPAIGNS = DATA / "campaigns"
NAMES = (
    "clean", "bench_only", "bias_temperature", "g_sensitivity",
    "one_seating_off", "quadratic_certified", "quadratic_free", "quadratic_uncertified",
)  # fmt: skip
pytestmark = pytest.mark.skipif(
    not CAMPAIGNS.is_dir(), reason=f"STATION_DATA: no reference campaigns in {CAMPAIGNS}"
)


def effects_of(planted: dict) -> dict[str, dict[str, float]]:
    found: dict[str, dict[str, float]] = {}
    for name, value in planted.items():
        if name == "acc_k2":
            found["accelerometer.quadratic"] = dict(zip("xyz", value, strict=True))
        elif name == "acc_bias_tc":
            found["accelerometer.bias_temperature"] = dict(zip("xyz", value, strict=True))
        elif name == "gyro_g":
            sizes = {row + column: value[i][j] for i, row in enumerate("xyz") for j, column in enumerate("xyz")}
            found["gyroscope.g_sensitivity"] = sizes
        elif name == "placement":
            ((index, vector),) = value.items()
            found["placement.dwell"] = {"position": int(index) + 1, **dict(zip("xyz", vector, strict=True))}
        else:
            pytest.fail(f"the generator planted {name!r}, which this test does not know")
    return found


def truth_of(name: str) -> Truth:
    reported = json.loads((CAMPAIGNS / name / "truth.json").read_text())["truth"]
    return Truth(
        sample_period_s=reported["dt"], latitude_deg=reported["lat"], gravity_m_s2=reported["g"],
        accel_k=np.array(reported["ka"]), accel_e=np.array(reported["Ea"]), accel_d_g=np.array(reported["Da"]),
        gyro_k=np.array(reported["kg"]), gyro_e=np.array(reported["Eg"]), gyro_d_deg_s=np.array(reported["Dg"]),
        accel_noise_g=reported["acc_noise"], gyro_arw_deg_rt_s=reported["arw"],
        gyro_instability_dph=reported["bias_walk"] * 3600,
        faces_rad=np.array(reported["faces"]), slab_tilt_rad=-np.array(reported["slab"]),
        slab_azimuth_rad=reported["azimuth"], heading_std_deg=float(np.degrees(reported["yaw_sd"])),
        closure_std_deg=float(np.degrees(reported["turn_end_sd"])),
        temperature_start_c=reported["temp0"], temperature_rise_k=reported["temp_rise"],
        temperature_tau_s=reported["temp_tau"], temperature_swing_k=reported["temp_swing"],
        effects=effects_of(reported["effects"]),
    )  # fmt: skip


def recorded(name: str, position: int) -> FloatArray:
    (path,) = (CAMPAIGNS / name).glob(f"dwell_*_position_{position:02d}.csv")
    return np.loadtxt(path, delimiter=",", skiprows=1)


@pytest.mark.parametrize("name", NAMES)
def test_mean_rates_of_every_dwell_are_reproduced_within_noise(name: str) -> None:
    truth = truth_of(name)
    quiet = SimulatedBench(replace(truth, heading_std_deg=0.0), None)
    worst = []
    for position in range(1, 13):
        rows = recorded(name, position)
        segment = rest(quiet.world.attitude(position), None, position)
        predicted = quiet.sensor.output(segment, round(rows[0, 0] / 0.02), 0, len(rows)).mean(0)
        seconds = 0.02 * len(rows)
        k = np.concatenate((truth.accel_k, truth.gyro_k))
        measured = rows[:, [4, 5, 6, 1, 2, 3]].sum(0) / (k * seconds)
        white = np.repeat([truth.accel_noise_g * np.sqrt(0.02 / seconds), 1e-4 / np.sqrt(seconds)], 3)
        # a heading error turns the horizontal Earth rate; the bias walk is the generator's own
        walk = np.repeat([0.0, 3 * 0.01 / 3600 + 0.00357 * np.radians(truth.heading_std_deg)], 3)
        tilt = 4e-3 * np.radians(truth.heading_std_deg) * np.repeat([1, 0], 3)  # misalignment x heading
        sigma = np.sqrt(white**2 + walk**2 + tilt**2)
        worst.append((np.abs(measured - predicted) - 1 / (k * seconds)) / sigma)
    assert np.max(worst) < 4.5  # the largest of 72


@pytest.mark.parametrize("name", NAMES)
def test_the_vertical_accelerometer_agrees_to_parts_in_ten_million(name: str) -> None:
    truth = truth_of(name)
    quiet = SimulatedBench(replace(truth, heading_std_deg=0.0), None)
    worst = []
    for position in range(1, 13):
        rows, vertical = recorded(name, position), (position - 1) // 4
        segment = rest(quiet.world.attitude(position), None, position)
        predicted = quiet.sensor.output(segment, round(rows[0, 0] / 0.02), 0, len(rows))[:, vertical].mean()
        slope = (
            np.polyfit(rows[:, 0] - rows[0, 0], np.cumsum(rows[:, 4 + vertical]), 1)[0] / truth.accel_k[vertical]
        )
        # line through the cumulative count: white rate noise 1.2 times its bound, and uniform quantisation
        n, seconds = len(rows), 0.02 * len(rows)
        white = truth.accel_noise_g * np.sqrt(1.2 / n)
        quantisation = 1 / (truth.accel_k[vertical] * seconds * np.sqrt(n))
        worst.append(abs(slope - predicted) / np.hypot(white, quantisation))
    assert np.max(worst) < 4.0
    assert np.max(worst) > 0.5, "the sigma is not so wide that anything would pass"


def test_the_scatter_within_a_dwell_agrees() -> None:
    rows = recorded("clean", 1)
    mine = SimulatedBench(truth_of("clean"), 1).perform(Dwell(1, 100.0))
    for counts, columns in ((mine.gyro, slice(1, 4)), (mine.accel, slice(4, 7))):
        seconds = [np.std(x.reshape(-1, 50, 3).sum(1), axis=0) for x in (counts, rows[:, columns])]
        # scatter of 100 sums of 1 s each: a standard deviation is known to 7 %
        assert np.all(np.abs(np.log(seconds[0] / seconds[1])) < 5 * np.sqrt(2) / np.sqrt(200))
