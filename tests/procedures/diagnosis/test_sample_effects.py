"""What acts sample by sample: planted in noise, found with its size and period; noise of any colour has none."""

from collections.abc import Callable

import numpy as np
import pytest
from scipy.signal import lfilter

from procedures.arrays import FloatArray, IntArray
from procedures.campaign.campaign import Campaign, Site, SoakRecord
from procedures.counts.sample_records import CountSeries, RateSeries
from procedures.inference.result import Finding
from procedures.samples.sample_effects import SampleEffects, sample_effects

N, PERIOD = 30_000, 0.01
T = PERIOD * np.arange(1, N + 1)
UNIT = {"gyroscope": np.ones(3), "accelerometer": np.ones(3)}
DEG_H = 3600.0


def soak(gyro: FloatArray, accel: FloatArray | None = None, **aux: FloatArray) -> Campaign:
    extra = {f"aux_{name}": values for name, values in aux.items()}
    series = RateSeries(T, gyro, accel, np.full(N, 25.0), PERIOD, extra=extra)
    return Campaign("m", "s", False, Site(0.8, 9.8, 0.02), (), (), soaks=(SoakRecord("soak", 0, None, series),))


def found(campaign: Campaign) -> tuple[Finding, ...]:
    return sample_effects([campaign], UNIT).findings


def white(seed: int) -> FloatArray:
    return np.random.default_rng(seed).normal(size=(N, 3))


def errors(finding: Finding, true: dict[str, float]) -> FloatArray:
    assert set(finding.coefficients) == set(true)
    planted = np.array([true[name] for name in finding.coefficients])
    return (finding.value - planted) / finding.std


def test_an_error_periodic_in_a_channel_that_wraps_is_found_with_its_harmonics() -> None:
    rng = np.random.default_rng(1)
    turns = (3.7 * T + 1e-3 * np.cumsum(rng.normal(size=N))) % 1.0
    gyro = white(2)
    gyro[:, 2] += 0.2 * np.cos(2 * np.pi * turns) + 0.1 * np.sin(4 * np.pi * turns)
    (finding,) = found(soak(gyro, ramp=360 * turns, temp=25 + 0.01 * rng.normal(size=N)))
    assert finding.effect == "auxiliary.periodic"
    assert finding.where["channel"] == "ramp"
    assert finding.shape == "period 360 of ramp, 2 harmonics"
    assert finding.confidence == "established"
    true = {"gz.cos1": 0.2 * DEG_H, "gz.sin1": 0.0, "gz.cos2": 0.0, "gz.sin2": 0.1 * DEG_H}
    assert np.all(np.abs(errors(finding, true)) < 4)
    # of the variance 1 + 0.02 + 0.005
    assert finding.share == pytest.approx(0.025 / 1.025, abs=4 * np.sqrt(2 * 0.025 / N))


def test_the_period_of_an_angle_that_never_wraps_is_found() -> None:
    angle = np.cumsum(0.3 + 0.05 * np.random.default_rng(3).normal(size=N))  # deg
    gyro = white(4)
    gyro[:, 0] += 0.15 * np.cos(np.radians(6 * angle))
    (finding,) = found(soak(gyro, motor=angle))
    assert (finding.effect, finding.shape) == ("auxiliary.periodic", "period 60 of motor, 1 harmonic")
    assert np.all(np.abs(errors(finding, {"gx.cos1": 0.15 * DEG_H, "gx.sin1": 0.0})) < 4)


@pytest.mark.parametrize("wraps", [False, True])
def test_a_line_at_a_multiple_of_a_steady_motor_s_turns_may_be_the_motor_s(wraps: bool) -> None:
    angle = 360 * 0.237 * T
    gyro = white(4)
    gyro[:, 0] += 0.6 * np.cos(np.radians(2 * angle))
    (finding,) = found(soak(gyro, motor=angle % 360 if wraps else angle))
    assert {finding.effect, *finding.aliases} == {"disturbance.line", "auxiliary.periodic"}
    assert finding.confidence == "possible"
    assert finding.separate_by == "motor at another speed"


def test_a_channel_that_acts_later_is_found_with_its_lag() -> None:
    rng = np.random.default_rng(5)
    current, accel = lfilter([1], [1, -0.9], rng.normal(size=N)), white(6)
    accel[3:, 1] += 0.06 * current[:-3]
    (finding,) = found(soak(white(7), accel, current=current))
    assert (finding.effect, finding.where["channel"]) == ("auxiliary.channel", "current")
    assert finding.shape == "0.03 s after the channel"
    assert np.all(np.abs(errors(finding, {"ay": 0.06})) < 4)


def test_a_line_is_found_and_what_the_sample_rate_may_have_folded_is_reported() -> None:
    (finding,) = found(soak(white(8) + 0.5 * np.sin(2 * np.pi * 17.77 * T)[:, None]))
    assert finding.effect == "disturbance.line"
    hertz, _, std, rest = finding.shape.split(" ", 3)
    assert float(hertz) == pytest.approx(17.77, abs=4 * float(std))
    assert float(std) < 1e-4
    assert rest == "Hz, 1 harmonic; it may be any multiple of 100 Hz away"
    assert finding.share == pytest.approx(0.125 / 1.125, rel=0.05)


def test_rectified_vibration_is_found_with_its_coefficient_and_skewed_noise_is_not() -> None:
    scale = 2e-3 * (1 + 3 * (np.sin(2 * np.pi * T / 40) > 0.5))
    accel = scale[:, None] * white(9)
    accel[:, 2] += 40 * scale**2
    (finding,) = found(soak(white(10), accel))
    assert finding.effect == "accelerometer.vibration_rectification"
    assert np.all(np.abs(errors(finding, {"z": 40.0})) < 4)
    drawn = sample_effects([soak(white(10), accel)], UNIT).folded
    assert [(each.axis, each.coordinate[:8]) for each in drawn] == [(2, "variance")]
    before, after = (np.polyfit(drawn[0].phase, values, 1)[0] for values in (drawn[0].before, drawn[0].after))
    assert abs(after) < 0.2 * abs(before)
    skewed = np.random.default_rng(11).exponential(size=(N, 3))
    assert not found(soak(white(12), skewed))


def test_a_gyroscope_that_rectifies_vibration_is_found_and_one_that_shakes_itself_is_not() -> None:
    shaking = 1 + 3 * (np.sin(2 * np.pi * T / 40) > 0.5)
    for seed in range(1):
        accel, gyro = 2e-3 * shaking[:, None] * white(20 + seed), 0.01 * white(30 + seed)
        gyro[:, 1] += 60.0 * 3 * (2e-3 * shaking) ** 2  # three axes that shake alike
        (finding,) = found(soak(gyro, accel))
        assert finding.effect == "gyroscope.vibration_rectification"
        assert np.all(np.abs(errors(finding, {"y": 60.0 * DEG_H})) < 4)
        assert not found(soak(0.01 * shaking[:, None] * white(40 + seed), accel))


def _counted(output: FloatArray) -> IntArray:
    return np.diff(np.floor(output), prepend=0).astype(np.int64)


def test_a_converter_that_errs_by_its_count_is_found_and_rounding_is_not() -> None:
    rng = np.random.default_rng(13)
    true = [np.cumsum(20.3 + 8 * rng.normal(size=N)) for _ in range(3)]
    bent = true[0] + 0.9 * np.sin(2 * np.pi * true[0] / 16)
    gyro = np.stack([_counted(each) for each in (bent, true[1], true[2])], axis=1)
    rounded = np.stack([_counted(rate * np.arange(1, N + 1)) for rate in (20.5, 20.8837, 21.111)], axis=1)
    series = CountSeries(T, gyro, rounded, np.full(N, 25.0), PERIOD)
    campaign = Campaign("m", "s", True, Site(0.8, 9.8, 0.02), (), (), soaks=(SoakRecord("soak", 0, None, series),))
    (finding,) = found(campaign)
    assert finding.effect == "gyroscope.count_periodic"
    assert finding.shape.startswith("period 16 of sum of gyroscope x")


NOISES: dict[str, Callable[[np.random.Generator], FloatArray]] = {
    "white": lambda rng: rng.normal(size=(N, 3)),
    "heavy": lambda rng: rng.standard_t(3, size=(N, 3)),
    "slow": lambda rng: lfilter([1], [1, -0.99], rng.normal(size=(N, 3)), axis=0),
    "walk": lambda rng: np.cumsum(rng.normal(size=(N, 3)), axis=0),
    "resonance": lambda rng: lfilter([1], [1, -1.6, 0.98], rng.normal(size=(N, 3)), axis=0),
    "bursts": lambda rng: rng.normal(size=(N, 3)) * (1 + 3 * (np.sin(2 * np.pi * T / 37) > 0.6))[:, None],
}


@pytest.mark.parametrize("noise", NOISES)
def test_noise_of_any_colour_with_any_channel_has_nothing(noise: str) -> None:
    for seed in range(1):
        rng = np.random.default_rng(seed)
        others = {
            "ramp": (3.7 * T) % 1.0,
            "volts": 5 + 0.01 * rng.normal(size=N),
            "slow": lfilter([1], [1, -0.999], rng.normal(size=N)),
            "angle": np.degrees(np.cumsum(0.05 + 0.01 * rng.normal(size=N))) % 360,
            "sine": np.sin(2 * np.pi * 1.3 * T),
            "clock": T,
        }
        assert not found(soak(NOISES[noise](rng), NOISES[noise](rng), **others))


# The number of harmonics of a periodic error follows from the data


LEVELS = np.random.default_rng(5).normal(size=24)
SHAPES: dict[str, tuple[Callable[[FloatArray], FloatArray], float]] = {
    "one": (lambda p: np.cos(2 * np.pi * p), 0.3),
    "two": (lambda p: np.cos(2 * np.pi * p) + 0.5 * np.sin(4 * np.pi * p), 0.3),
    "twelfth": (lambda p: np.cos(2 * np.pi * 12 * p) + np.cos(2 * np.pi * p), 0.4),
    "thirty-second": (lambda p: np.cos(2 * np.pi * 32 * p) + 0.5 * np.cos(2 * np.pi * p), 0.5),
    "reset": (lambda p: (p < 0.05) * 1.0, 3.0),
    "short reset": (lambda p: (p < 0.02) * 1.0, 4.0),
    "triangle": (lambda p: np.abs(p - 0.5), 2.0),
    "saw and third": (lambda p: (p - 0.5) + 0.5 * np.cos(6 * np.pi * p), 1.0),
    "half and half": (lambda p: np.sign(p - 0.5), 0.5),
    "levels": (lambda p: LEVELS[(24 * p).astype(int)], 0.6),
}


def ramp(seed: int) -> FloatArray:
    """Return a phase (n,) that passes all values in an irregular order."""
    return np.cumsum(0.037 * (1 + 0.1 * np.random.default_rng(seed).normal(size=N))) % 1.0


def found_by_phase(error: FloatArray, phase: FloatArray, seed: int = 1) -> SampleEffects:
    gyro = np.random.default_rng(seed).normal(size=(N, 3))
    gyro[:, 2] += error
    return sample_effects([soak(gyro, ramp=360 * phase)], UNIT)


@pytest.mark.parametrize("name", SHAPES)
def test_the_error_on_held_out_samples_is_that_of_noise_alone(name: str) -> None:
    shape, size = SHAPES[name]
    error = size * shape(ramp(2))
    reported = found_by_phase(error, ramp(2))
    left = float(np.prod([1 - each.share for each in reported.findings if each.share is not None]))
    assert left == pytest.approx(1 / (1 + np.var(error)), abs=0.025)
    assert not reported.left


@pytest.mark.parametrize(("harmonics", "order"), [((1,), 1), ((1, 2), 2), ((1, 3), 3), ((2, 12), 12)])
def test_the_order_is_that_of_the_highest_harmonic(harmonics: tuple[int, ...], order: int) -> None:
    phase = ramp(3)
    (finding,) = found_by_phase(
        0.3 * np.sum([np.cos(2 * np.pi * h * phase) for h in harmonics], axis=0), phase
    ).findings
    assert len(finding.coefficients) == 2 * order
    errors = (
        finding.value / 3600 - [0.3 * (i % 2 == 0 and i // 2 + 1 in harmonics) for i in range(2 * order)]
    ) / (finding.std / 3600)
    assert np.abs(errors).max() < 4.5
