"""A hand or a motor turns a cube: an error periodic in an angle is found; the Earth's rate is none."""

from dataclasses import replace

import numpy as np
import pytest

from drivers.simulated.bench_in_memory import simulate_campaign
from drivers.simulated.effects import PlantedEffect, Stimulus, TriadInput
from drivers.simulated.truth import Truth
from procedures.arrays import FloatArray
from procedures.campaign.campaign import Campaign, Site, TurnRecord
from procedures.counts.sample_records import RateSeries
from procedures.diagnosis.diagnose import diagnose
from procedures.inference.result import Finding
from procedures.samples.sample_turns import periodic_in_turns

PERIOD, NOISE = 0.02, 0.02  # s, deg/s
DEG_H = 3600.0
UNIT = {"gyroscope": np.ones(3)}
FACE_UP = {"x": 1, "y": 5, "z": 9}  # a position with that axis up
LATITUDE = np.radians(45.0)
SKEW = np.array([[1, 3e-3, -2e-3], [1e-3, 1, 4e-3], [-2e-3, 1e-3, 1]])
Planted = dict[tuple[int, int], tuple[float, float]]


def turn(
    rng: np.random.Generator, axis: str, direction: str, planted: Planted, gear: float, name: str
) -> TurnRecord:
    """Three uneven revolutions about the vertical; ``planted`` (cos, sin) [deg/s] by sensor and harmonic."""
    n = int(rng.uniform(60, 80) / PERIOD)
    t = PERIOD * np.arange(1, n + 1)
    speed = np.clip(np.minimum(t - 4, t[-1] - 4 - t), 0, 3)
    wave = sum(
        rng.uniform(0, 0.2) * np.cos(2 * np.pi * f * t + rng.uniform(0, 6)) for f in rng.uniform(0.05, 2, 5)
    )
    speed = speed * (1 + wave)
    sign = 1 if direction == "+" else -1
    rate = sign * 1080 * speed / (speed.sum() * PERIOD)
    angle = np.cumsum(rate) * PERIOD
    other = (40 * t + 3 * np.sin(t)) % 360 if gear == 0 else (gear * angle + 77 + 0.003 * rng.normal(size=n)) % 360
    psi, start = np.radians(angle), rng.uniform(0, 2 * np.pi)
    up = "xyz".index(axis)
    earth = 15.041 / 3600
    omega = np.zeros((n, 3))
    omega[:, up] = rate + earth * np.sin(LATITUDE)
    omega[:, (up + 1) % 3] = earth * np.cos(LATITUDE) * np.cos(psi + start)
    omega[:, (up + 2) % 3] = -earth * np.cos(LATITUDE) * np.sin(psi + start)
    gyro = omega @ SKEW.T + rng.normal(0, 0.01, 3) + NOISE * rng.normal(size=(n, 3))
    for (sensor, h), (c, s) in planted.items():
        gyro[:, sensor] += c * np.cos(np.radians(h * other)) + s * np.sin(np.radians(h * other))
    series = RateSeries(t, gyro, None, np.full(n, 25.0), PERIOD, extra={"aux_motor": other})
    return TurnRecord(name, axis, direction, 3, FACE_UP[axis], series)


def found(seed: int, planted: Planted, gear: float = 1.0) -> tuple[Finding, ...]:
    rng = np.random.default_rng(seed)
    turns = tuple(turn(rng, a, d, planted, gear, f"{a}{d}{i}") for i in range(2) for a in "xyz" for d in "+-")
    campaign = Campaign("m", "s", False, Site(LATITUDE, 9.8, 0.02), (), turns)
    return periodic_in_turns([campaign], UNIT)[0]


def off(finding: Finding, planted: Planted) -> FloatArray:
    true = {f"g{'xyz'[i]}.{part}{h}": v * DEG_H for (i, h), two in planted.items()
            for part, v in zip(("cos", "sin"), two, strict=True)}  # fmt: skip
    assert set(true) <= set(finding.coefficients)
    planted_value = np.array([true.get(name, 0.0) for name in finding.coefficients])
    return (finding.value - planted_value) / finding.std


@pytest.mark.parametrize("gear", [1.0, 0.0, 5.0])
@pytest.mark.parametrize("seed", [1])
def test_an_error_periodic_in_an_angle_while_it_turns_is_found_with_its_size(seed: int, gear: float) -> None:
    samples = 12 * 70 / PERIOD
    size = 14 * NOISE * np.sqrt(2 / samples)  # some 14 sigma
    planted = {(seed, 2): (size, -0.5 * size)}
    (finding,) = found(seed, planted, gear)
    assert (finding.effect, finding.confidence) == ("auxiliary.periodic", "established")
    assert finding.where["channel"] == "motor"
    assert np.all(np.abs(off(finding, planted)) < 4.5)
    if gear == 1.0:
        assert "gx.cos1" not in finding.coefficients


@pytest.mark.parametrize("gear", [1.0, 0.0, 5.0])
def test_the_earth_s_rate_and_an_uneven_hand_are_no_error(gear: float) -> None:
    assert not [each for seed in range(2) for each in found(100 + seed, {}, gear)]


def test_what_goes_once_a_turn_is_not_distinguished_from_the_earth_s_rate() -> None:
    assert not found(7, {(0, 1): (0.002, 0.001), (1, 1): (0.002, 0.001)})


def test_a_diagnosis_reports_what_is_periodic_while_a_simulated_unit_turns() -> None:
    def motor(t: FloatArray) -> FloatArray:
        found: FloatArray = (137.0 * t + 20 * np.sin(t / 7)) % 360
        return found

    def added(seen: Stimulus, triad: TriadInput, sizes: object) -> FloatArray:
        found: FloatArray = np.cos(np.radians(2 * motor(seen.t))) * np.array([1.0, 0.0, 0.0]) / DEG_H
        return found

    campaign = simulate_campaign(Truth.example(3), 3, also=((PlantedEffect("x", "", (), gyro=added), {}),))
    turns = tuple(
        replace(one, series=replace(one.series, extra={"aux_motor": motor(one.series.t)}))
        for one in campaign.turns
    )
    (finding,) = [f for f in diagnose([replace(campaign, turns=turns)]).findings if "aux" in f.effect]
    value = dict(zip(finding.coefficients, finding.value, strict=True))
    std = dict(zip(finding.coefficients, finding.std, strict=True))
    assert value["gx.cos2"] == pytest.approx(1.0, abs=4 * std["gx.cos2"])
    assert not {"gy.cos2", "gz.cos2"} & set(value)
